"""Which light is chosen, with which probability; which scenes have lights at all; few and many alike."""

import drjit as dr
import numpy as np
import pytest
from scipy import stats

from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.distribution import InverseTables, alias
from renderer.scene import light_choice, light_sources, lighting
from renderer.scene.light_choice import Estimate, FewLights, ManyLights
from renderer.scene.lighting import Light, LightNumber
from tests.lights.room import SIGNIFICANCE, Room, points, uniform_directions
from tests.support.scenes import point_light

BOX = (-4.0, -4.0, -4.0), (4.0, 4.0, 4.0)


def estimates(count):
    """Return Estimates of all sorts: near and far, gated, constant, one without any power."""
    rng = np.random.default_rng(count)
    made = []
    for k in range(count):
        axis = rng.normal(size=3)
        gate = {2: {"gate": 0.0}, 3: {"gate": 0.9}}.get(k % 4, {})
        axis = tuple(axis / np.linalg.norm(axis))
        made.append(Estimate(tuple(rng.uniform(-4, 4, 3)), 10 ** rng.uniform(-2, 2), 0.1, axis, **gate))
    made[count // 2] = Estimate(constant=0.3)
    if count > 2:
        made[-1] = Estimate(center=(1.0, 1.0, 1.0), strength=0.0)
    return made


def choice_of(count):
    """Return a choice among estimates: computed for each point, or by tables where they are many."""
    return FewLights(estimates(count)) if count <= light_choice.FEW else ManyLights(estimates(count), *BOX)


def probability_of(choice, light, p, lanes):
    """Return the probability (lanes,) with which points choose a light."""
    return (choice.probability(p, Light({light: Bool(True)})) + dr.zeros(Float, lanes)).numpy()


@pytest.mark.parametrize("count", [2, 3, 8, 9, 60])
def test_probabilities_add_up_to_one(count):
    """At points in the box and outside of it."""
    choice = choice_of(count)
    rng = np.random.default_rng(1)
    p = Vector3f(*(Float(rng.normal(size=64).astype(np.float32) * 4) for _ in range(3)))
    total = np.zeros(64)
    for k in range(count):
        probability = probability_of(choice, k, p, 64)
        assert (probability >= 0).all()
        total += probability
    assert np.allclose(total, 1, atol=1e-5)


@pytest.mark.parametrize("count", [2, 3, 8, 9, 100])
def test_lights_are_chosen_as_often_as_is_told(count):
    """A chi-square test of their numbers; the probability that comes with a choice is that of the light."""
    choice, lanes = choice_of(count), 2**19
    rng = np.random.default_rng(3)
    p = points([0.3, -0.7, 1.1], lanes)
    u, v = (Float(rng.random(lanes, np.float32)) for _ in range(2))
    chosen = choice.choose(p, u, v)
    number = chosen.number if count > light_choice.FEW else Light(dict(enumerate([Bool(True), *chosen.masks]))).number
    number = (number + dr.zeros(UInt32, lanes)).numpy()
    expected = np.array([probability_of(choice, k, p, lanes)[0] for k in range(count)], float)
    assert np.allclose(chosen.probability.numpy(), expected[number], rtol=1e-4)
    seen = np.bincount(number, minlength=count)
    assert (seen[expected == 0] == 0).all()
    enough = expected * lanes > 10
    p_value = stats.chisquare(seen[enough], expected[enough] / expected[enough].sum() * seen[enough].sum()).pvalue
    assert p_value > SIGNIFICANCE
    for left in (chosen.u, chosen.v):  # what is left is even, and independent of the choice
        for k in np.flatnonzero(expected > 0.05):
            values = left.numpy()[number == k]
            assert stats.kstest(values[:20000], "uniform").pvalue > SIGNIFICANCE


def test_near_lights_are_preferred():
    """Beside one of a thousand equal lights that one is chosen most, and all the others may be."""
    rng = np.random.default_rng(5)
    centers = rng.uniform(-4, 4, (1000, 3))
    choice = ManyLights([Estimate(tuple(c), 1.0, 1e-4) for c in centers], *BOX)
    p = Vector3f(*map(float, centers[7] + 0.01)) + dr.zeros(Vector3f, 1000)
    own = choice.probability(p, LightNumber(dr.arange(UInt32, 1000), range(1000))).numpy()
    assert own[7] == own.max() > 20 / 1000 and own.min() > 0.05 / 1000


def test_lights_that_shine_away_are_left_to_chance():
    """Behind a one-sided lamp its share is only that which follows power alone, far as well as near."""
    lamps = [Estimate((0.0, 0.0, z), 1.0, 0.01, (0.0, 0.0, sign), 0.0)
             for z in (-3.0, 3.0) for sign in (-1.0, 1.0) for _ in range(5)]  # fmt: skip
    choice = ManyLights(lamps, *BOX)
    behind = [k for k, lamp in enumerate(lamps) if lamp.axis[2] * (0 - lamp.center[2]) < 0]
    p = points([0, 0, 0], len(lamps))
    own = choice.probability(p, LightNumber(dr.arange(UInt32, len(lamps)), range(len(lamps)))).numpy()
    assert np.allclose(own[behind], light_choice.BY_POWER / len(lamps)) and own.sum() == pytest.approx(1)


WEIGHTS = [[1.0], [1, 0], [0, 0, 5], [1, 2, 3, 4], [0.1] * 10, [3, *[0] * 30, 1]]


@pytest.mark.parametrize("weights", [*WEIGHTS, [1e-30, 1, 1e30]])
def test_alias_tables_hold_their_weights(weights):
    """The shares of each thing over all places are its weight, exactly but for rounding, and 0 for 0."""
    rows = np.array([weights, weights[::-1]], float)
    places = 1 << (rows.shape[1] - 1).bit_length()
    share, other = alias(rows, places)
    for row, own_share, own_other in zip(rows, share, other):
        own = np.bincount(np.arange(places), own_share, places) + np.bincount(own_other, 1 - own_share, places)
        expected = np.zeros(places)
        expected[: len(row)] = row / row.sum() * places
        assert np.allclose(own, expected, atol=1e-12) and (own[expected == 0] == 0).all()


@pytest.mark.parametrize("weights", [*WEIGHTS, [0, 0, 0], range(300)])
def test_inverse_tables_choose_in_order(weights):
    """As a search among the sums of weights does, at their edges too; what is left is the place between the sums."""
    weights = np.array([weights, [*weights][::-1]], float)
    tables, row = InverseTables.of(weights), 1
    own = weights[row] if weights.any() else np.ones(weights.shape[1])
    sums = np.concatenate([[0], np.cumsum(own)]) / own.sum()
    sums = sums.astype(np.float32)
    grid, below = np.linspace(0, 1, 4001, dtype=np.float32)[:-1], np.nextafter(sums[1:], np.float32(0))
    u = np.concatenate([grid, sums[sums < 1], below, [1 - 2.0**-24]])
    found, left = tables.choose(Float(u.astype(np.float32)), UInt32(row))
    found, left = found.numpy(), left.numpy()
    assert (found == np.searchsorted(sums[:-1], u, side="right") - 1).all()
    assert (own[found] > 0).all()
    assert np.allclose(left, (u - sums[found]) / (sums[found + 1] - sums[found]), atol=1e-5) and (left < 1).all()


BLACK = [0.0, 0.0, 0.0]
RECTANGLE = {"type": "rectangle", "center": [0, 1, 0], "u": [1, 0, 0], "v": [0, 0, 1]}
CHANCE = [{"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
          {"type": "cylinder", "center": [0, 0, 0], "axis": [0, 1, 0], "radius": 1, "height": 1},
          {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]},
          {"type": "convex", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}]  # fmt: skip


def flags(room):
    """Return what a Lighting tells about itself."""
    return room.lighting.has_lights, room.lighting.has_emitters, room.lighting.has_background


def test_scenes_tell_what_they_have(tmp_path):
    """Kernels contain nothing for what is not there."""
    assert flags(Room(tmp_path)) == (False, False, False)
    assert flags(Room(tmp_path, [RECTANGLE], [point_light([0, 0, 0], BLACK)])) == (False, False, False)
    assert flags(Room(tmp_path, [RECTANGLE | {"emission": BLACK}])) == (False, False, False)
    assert flags(Room(tmp_path, [RECTANGLE | {"emission": [0, 0, 1]}])) == (True, True, False)
    assert flags(Room(tmp_path, [], [point_light([0, 0, 0])])) == (True, False, False)
    assert flags(Room(tmp_path, backgroundcolor=[0, 0.1, 0])) == (False, False, True)


@pytest.mark.parametrize("shape", CHANCE, ids=lambda shape: shape["type"])
def test_shapes_that_are_not_sampled_shine_when_met(tmp_path, shape):
    """Their density is 0, also beside lights that are sampled."""
    beside = [{"type": "sphere", "center": [9, 9, 9], "radius": 0.1, "emission": [7, 7, 7]}]
    for others, lights, sampled in (([], [], False), ([], [point_light([9, 9, 9])], True), (beside, [], True)):
        room = Room(tmp_path, [shape | {"emission": [1, 2, 3]}, *others], lights)
        assert flags(room) == (sampled, True, False)
        radiance, pdf_sa = room.seen([0.2, 5, 0.2], uniform_directions(2**10))
        assert (pdf_sa[radiance[1] == 2] == 0).all() and 2 in radiance[1]
        inside = room.seen([0.1, 0.2, 0.1], uniform_directions(2**10))[0]
        assert (inside == 0).all() != (shape["type"] == "plane")  # solids shine outwards, this plane downwards too


def test_black_lights_are_never_chosen(tmp_path):
    """Also by the tables of many lights."""
    for count in (2, 20):
        lights = [point_light([0, k, 0], BLACK if k % 2 else [1, 1, 1]) for k in range(count)]
        radiance = Room(tmp_path, [], lights).sample([0.1, 0.2, 0.3], 2**12).radiance.numpy()
        assert (radiance > 0).all()


def test_background_is_the_same_everywhere(tmp_path):
    """A constant one is found by chance alone."""
    radiance, pdf_sa = Room(tmp_path, backgroundcolor=[0.1, 0.2, 0.3]).seen([0, 0, 0], uniform_directions(64))
    assert np.allclose(radiance.T, [0.1, 0.2, 0.3]) and (pdf_sa == 0).all()


def test_one_code_or_the_other_finds_the_same_emitters(tmp_path, monkeypatch):
    """Emitters are looked for one after the other, or by a table; records are kept as scalars, or in packets."""
    shapes = [RECTANGLE | {"emission": [k + 1, 0, 1], "center": [2 * k, 1, k]} for k in range(5)] + CHANCE[:1]
    shapes += [{"type": "sphere", "center": [-3, k, 0], "radius": 0.4, "emission": [0, k, 1]} for k in range(3)]
    first = Room(tmp_path, shapes)
    monkeypatch.setattr(lighting, "SELECT_LIMIT", 0)
    table = Room(tmp_path, shapes)
    even = uniform_directions(2**14)
    for one, other in zip(first.seen([0, 0, 0], even), table.seen([0, 0, 0], even)):
        assert np.allclose(one, other, rtol=1e-5)
    for module in (lighting, light_sources):
        monkeypatch.setattr(module, "FEW", 1)
    for n in ([0, 1, 0], [-1, 0, 0]):
        (one, error), (other, other_error) = (room.irradiance([0, 0, 0], n) for room in (first, Room(tmp_path, shapes)))
        assert (abs(one - other) < 5 * np.hypot(error, other_error)).all()


def test_kernels_do_not_grow_with_the_number_of_lights(tmp_path):
    """Twice as many shining triangles need the same operations."""
    def operations(count):
        shapes = [{"type": "triangle", "v0": [k, 0, 0], "v1": [k + 1, 0, 0], "v2": [k, 1, 0], "emission": [1, 1, 1]}
                  for k in range(count)]  # fmt: skip
        room = Room(tmp_path, shapes)
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            room.sample([0, 0, 1], 2**10)
            return max(kernel["operation_count"] for kernel in dr.kernel_history() if "operation_count" in kernel)

    assert operations(200) == operations(400)
