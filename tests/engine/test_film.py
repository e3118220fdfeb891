"""Sums over samples: nothing is lost to rounding, what is not finite is left out and found again."""

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.engine import passes, tiles
from renderer.core.colour import LUMINANCE
from renderer.engine.film import Film, relative_error
from renderer.engine.passes import Until, View, find_lost, refine
from renderer.samplers import KINDS

LANES = 16


def summed(film, colour_of, first, end):
    """Return the film with samples `colour_of(sample)`, added in a kernel as the renderer does it."""
    end = dr.opaque(UInt32, end)
    sample = dr.opaque(UInt32, first) + dr.zeros(UInt32, LANES)
    _, film = dr.while_loop(
        (sample, film), lambda sample, film: sample < end,
        lambda sample, film: (sample + 1, film.add(colour_of(sample), Bool(True))),
    )
    dr.eval(film)
    return film


def test_sixteen_million_samples_lose_nothing():
    """As many samples as a scene may ask for; a plain sum would be wrong by percents, and FastMath is on."""
    values = np.random.default_rng(3).uniform(0.05, 0.2, LANES).astype(np.float32)
    value, count = Float(values), 2**24
    film = summed(Film.empty(LANES, variance=True).opaque(), lambda sample: Vector3f(value, value * 3, 1), 0, count)
    mean = film.mean(count).numpy()
    assert np.abs(mean[0] / values - 1).max() < 3e-7 and np.abs(mean[1] / (values * np.float32(3)) - 1).max() < 3e-7
    assert np.array_equal(mean[2], np.ones(LANES))
    total = dr.zeros(Float, LANES) + dr.opaque(Float, 0)
    plain = dr.while_loop((dr.zeros(UInt32, LANES), total), lambda k, total: k < dr.opaque(UInt32, count),
                          lambda k, total: (k + 1, total + value))[1]  # fmt: skip
    assert np.abs(plain.numpy() / count / values - 1).max() > 1e-3


@pytest.mark.parametrize("spread", [1.0, 0.01])
def test_variance_is_that_of_the_samples(spread):
    """Of luminance, against two passes in double precision; also where it is a ten-thousandth of the square."""
    count = 4096
    data = (1 + spread * np.random.default_rng(5).standard_normal((count, 3, LANES))).astype(np.float32)
    columns = [Float(data[:, c].ravel()) for c in range(3)]
    lane = dr.arange(UInt32, LANES)
    film = summed(Film.empty(LANES, variance=True),
                  lambda sample: Vector3f(*(dr.gather(Float, c, sample * LANES + lane) for c in columns)), 0, count)
    expected = np.var(np.tensordot(LUMINANCE, data.astype(np.float64), ([0], [1])), axis=0, ddof=1) / count
    assert np.allclose(film.variance(count).numpy(), expected, rtol=2e-3)
    brightness = np.mean(np.tensordot(LUMINANCE, data.astype(np.float64), ([0], [1])))
    assert relative_error([film], count) == pytest.approx(np.sqrt(expected.mean()) / brightness, rel=2e-3)


def test_variance_of_equal_samples_is_nothing():
    """Neither negative nor what rounding leaves."""
    film = summed(Film.empty(LANES, variance=True), lambda sample: Vector3f(0.3, 0.7, 0.1), 0, 1000)
    assert np.sqrt(film.variance(1000).numpy().max() * 1000) < 2**-11 * 0.57
    assert film.variance(1000).numpy().min() >= 0 and film.variance(1).numpy().max() == 0


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("channel", range(3))
def test_sample_that_is_not_finite_is_left_out(wrong, channel):
    """The mean is that of the others, and the lane counts its losses."""
    bad = Vector3f(*(Float(wrong if c == channel else 1.0) for c in range(3)))
    film = summed(Film.empty(LANES, variance=True),
                  lambda sample: dr.select(sample % 4 == 1, bad, Vector3f(2, 3, 4)), 0, 16)
    assert np.array_equal(film.mean(16).numpy(), np.repeat([[2], [3], [4]], LANES, 1))
    assert np.array_equal(film.lost.numpy(), np.full(LANES, 4)) and np.isfinite(film.variance(16).numpy()).all()
    lone = summed(Film.empty(LANES, single=True), lambda sample: bad, 0, 1)
    assert np.array_equal(lone.mean(1).numpy(), np.zeros((3, LANES))) and lone.lost.numpy().min() == 1


def test_film_without_a_good_sample_is_black():
    """Not 0 / 0."""
    film = summed(Film.empty(LANES), lambda sample: Vector3f(Float(np.nan)), 0, 5)
    assert np.array_equal(film.mean(5).numpy(), np.zeros((3, LANES)))


class Faulty:
    """An integrator whose samples are numbers of their sampler, and wrong where a list of (pixel, sample) says so."""

    looks_ahead = False
    uneven = False
    tint = 0.0  # by which columns differ in the last channel

    def __init__(self, faults):
        self._faults = faults  # {(column, row): (sample, value)}

    def start(self, lanes):
        return dr.zeros(Vector3f, lanes)

    def restart(self, state, where, o, d):
        return dr.select(where, o, state)

    def step(self, state, draws):
        radiance = Vector3f(draws.u1(5))
        radiance.z += self.tint * state.x
        for (column, row), (sample, value) in self._faults.items():
            here = (state.x == column) & (state.y == row) & (draws.sample == sample)
            radiance.y = dr.select(here, dr.opaque(Float, value), radiance.y)
        return radiance, Bool(False), state


class Grid:
    """A camera whose rays start at column and row."""

    has_lens = False

    @staticmethod
    def ray(row, position, u2=None):
        return Vector3f(dr.floor(position.x), dr.floor(position.y), 0), Vector3f(0, 0, 1)


class Uneven(Faulty):
    """The same with samples that end after up to seven steps, in pixels that take turns in lanes."""

    uneven = True

    def step(self, state, draws):
        radiance, _, _ = super().step(state, draws)
        goes_on = (state.z < 6) & (draws.u1(6) < 0.1 * state.x) & (state.x != 3)
        state.z = dr.select(goes_on, state.z + 1, 0)
        return dr.select(goes_on, 0, radiance), goes_on, state


def view(faults=(), width=20, height=10, seed=3, kind=Faulty):
    """Return a View of samples that are random numbers but for some faults."""
    return View(kind(dict(faults)), (Grid, None), KINDS["sobol"], width, height, seed)


@pytest.mark.parametrize("pixels", [200, 200 // 3, 7])
@pytest.mark.parametrize("seconds", [0.0, 1e-4, 10.0])
@pytest.mark.parametrize("kind", [Faulty, Uneven])
def test_passes_add_up_to_the_same_bytes(kind, seconds, pixels, monkeypatch):
    """64 samples and 192 more are 256 at once, for any split into passes, squares and losses included."""
    monkeypatch.setattr(passes, "PASS_SECONDS", seconds)
    monkeypatch.setattr(tiles, "PACKETS_A_THREAD", 0)
    shot, empty = view({(3, 4): (100, np.nan)}, kind=kind), Film.empty(200, variance=True)
    whole = shot.expose(empty, 0, 256)
    split = shot.expose(shot.expose(empty, 0, 64), 64, 256)
    monkeypatch.setattr(passes, "PART_PIXELS", pixels)
    exposure = refine(shot, Until(256), variance=True)
    assert exposure.samples == exposure.taken == 256
    refined = exposure.film
    for name in ("total", "rest", "lost", "squares", "squares_rest"):
        assert np.array_equal(getattr(whole, name).numpy(), getattr(split, name).numpy())
        assert np.array_equal(getattr(whole, name).numpy(), getattr(refined, name).numpy())


@pytest.mark.parametrize("first, count", [(0, 200), (33, 150), (199, 1)])
def test_pixels_that_take_turns_have_the_same_bytes(first, count, monkeypatch):
    """As those that have a lane each; also where rows begin and end within the part, and after earlier samples."""
    monkeypatch.setattr(Faulty, "tint", 1.0)
    monkeypatch.setattr(tiles, "PACKETS_A_THREAD", 0)  # all turns that there may be
    for faults in ({}, {(3, 4): (10, np.nan)}):
        alone, turns = (view(faults, kind=kind) for kind in (Faulty, Uneven))
        begun = turns.expose(Film.empty(count), 0, 5, first)
        expected, film = alone.expose(Film.empty(count), 0, 40, first), turns.expose(begun, 5, 40, first)
        for name in ("total", "rest", "lost"):
            assert np.array_equal(getattr(film, name).numpy(), getattr(expected, name).numpy())


def test_passes_run_one_kernel(monkeypatch):
    """Also the first one, and whatever is kept beside the colour."""
    small_passes(monkeypatch)
    monkeypatch.setattr(passes, "PART_PIXELS", 90)
    for variance, kind in ((False, Faulty), (True, Faulty), (True, Uneven)):
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            refine(view(kind=kind), Until(6), variance=variance)
            launched = [kernel["hash"] for kernel in dr.kernel_history() if kernel.get("operation_count", 0) > 50]
        assert len(launched) == 18 and len(set(launched)) == 1


def test_lost_samples_are_counted_and_found():
    """One of each kind, with its place; following it again gives the very value."""
    shot = view({(7, 2): (9, np.inf), (3, 4): (17, np.nan), (4, 4): (3, np.nan)})
    lost = find_lost(shot, refine(shot, Until(20)))
    assert lost.count == 3 and set(lost.examples) == {("inf", 7, 2, 9), ("nan", 3, 4, 17)}
    assert np.isnan(shot.follow(3 + 4 * 20, 17).y[0]) and np.isinf(shot.follow(7 + 2 * 20, 9).y[0])
    assert find_lost(shot, refine(shot, Until(3))) is None


def test_search_for_a_late_sample_is_split(monkeypatch):
    """The number told counts from the first sample, not from the part that was searched."""
    monkeypatch.setattr(passes, "SEARCHED_AT_ONCE", 8)
    shot = view({(7, 2): (29, np.nan)})
    assert find_lost(shot, refine(shot, Until(32))).examples == (("nan", 7, 2, 29),)


def test_followed_samples_are_those_of_the_picture():
    """Their mean is the pixel's."""
    shot = view()
    film = refine(shot, Until(32)).film
    followed = shot.follow(123, 0, 32).x.numpy()
    assert film.mean(32).x[123] == pytest.approx(followed.astype(np.float64).mean(), rel=1e-6)


def small_passes(monkeypatch):
    """Let every round add one sample."""
    monkeypatch.setattr(passes, "PASS_SECONDS", 0.0)
    monkeypatch.setattr(passes, "LEAST_IN_PASS", 1)


def test_error_stops_where_the_spread_says(monkeypatch):
    """Uniform numbers deviate by 1 / sqrt(12) of a mean of 1 / 2: error 2 % takes 833 samples."""
    for part in (passes.PART_PIXELS, 90):
        monkeypatch.setattr(passes, "PART_PIXELS", part)
        exposure = refine(view(), Until(error=0.02))
        assert 0.95 * 833 < exposure.samples < 1.05 * 833 and relative_error([exposure.film], exposure.taken) <= 0.02
    calls = []
    assert 30 <= refine(view(), Until(error=0.1), progress=lambda *told: calls.append(told)).samples <= 36
    shares = [done for done, _ in calls]
    assert shares == sorted(shares) and calls[-1] == (1.0, 1.0)
    assert len(calls) <= 3 * 5  # parts and rounds: the error tells how many samples it takes
    assert min(shares[5:]) > 0.2  # also between estimates


class Clock:
    """Time that passes with every look at it."""

    def __init__(self, tick):
        self.now, self.tick = 0.0, tick

    def perf_counter(self):
        self.now += self.tick
        return self.now


def test_time_stops_before_it_is_up(monkeypatch):
    """A round that would not end in time is not begun; one sample there is always."""
    clock = Clock(0.25)  # two looks a pass
    monkeypatch.setattr(passes, "time", clock)
    small_passes(monkeypatch)
    exposure = refine(view(), Until(seconds=10.0))
    assert 12 <= exposure.samples <= 20 and clock.now <= 10.75
    assert refine(view(), Until(seconds=1e-3)).samples == 1
    monkeypatch.setattr(passes, "PART_PIXELS", 90)
    assert refine(view(), Until(seconds=0.6)).samples == 1  # it was up after the first of three parts


def test_time_is_planned_so_that_all_pixels_end_alike(monkeypatch):
    """The last round is as long as the time left: 10 s at 0.2 s a sample of the picture are 50 samples everywhere."""
    clock, expose = Clock(0.0), View.expose

    def exposed(self, film, first, end, pixel=0):
        clock.pending = 0.001 * len(film.lost) * (end - first)
        return expose(self, film, first, end, pixel)

    def sync():
        clock.now += clock.pending

    monkeypatch.setattr(View, "expose", exposed)
    monkeypatch.setattr(passes, "time", clock)
    monkeypatch.setattr(passes.dr, "sync_thread", sync)
    monkeypatch.setattr(passes, "PART_PIXELS", 90)
    exposure = refine(view(), Until(seconds=10.0))
    assert exposure.samples == exposure.taken and 48 <= exposure.samples <= 50 and clock.now <= 10.001


def test_interrupted_picture_keeps_its_passes(monkeypatch):
    """What was rendered before is there; a pixel's mean is that of its own samples."""
    small_passes(monkeypatch)

    def stopped_after(count):
        asked = []
        return refine(view(), Until(50), interrupted=lambda: asked.append(0) or len(asked) == count)

    whole = stopped_after(5)
    assert whole.samples == whole.taken == 5
    assert np.array_equal(whole.film.total.numpy(), view().expose(Film.empty(200), 0, 5).total.numpy())
    monkeypatch.setattr(passes, "PART_PIXELS", 90)
    uneven = stopped_after(3 * 4 + 2)
    assert uneven.samples == 4 and np.array_equal(uneven.taken.numpy(), np.repeat([5, 4], [180, 20]))
    means = [view().expose(Film.empty(200), 0, count).mean(count).numpy() for count in (5, 4)]
    expected = np.where(np.arange(200) < 180, *means)
    assert np.array_equal(uneven.film.mean(uneven.taken).numpy(), expected)


def test_first_round_is_one_sample(monkeypatch):
    """So that there is a picture soon; then as many as a pass may take, and no more than there are to be."""
    calls = []
    refine(view(), Until(300), progress=lambda done, total: calls.append((done, total)))
    assert calls == [(1, 300), (65, 300), (300, 300)]
    monkeypatch.setattr(passes, "PART_PIXELS", 100)
    calls.clear()
    refine(view(), Until(2), progress=lambda done, total: calls.append((done, total)))
    assert calls == [(0.5, 2), (1, 2), (1.5, 2), (2, 2)]
