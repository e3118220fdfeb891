"""Reference pictures: those committed, the test of agreement that they passed, and what it refuses."""

import numpy as np
import pytest

from benchmarks import error_scenes, references
from benchmarks.error_curves import MARGIN
from benchmarks.measure import BenchmarkError

LARGEST_FILE, LARGEST_FOLDER = 200_000, 1_500_000  # bytes
NOISE = 0.02  # standard deviation of the made-up batches


def batches(seed, noise=NOISE, count=references.BATCHES, size=(32, 48)):
    """Return made-up batches (K, H, W, 3) of a grey slope."""
    slope = np.linspace(0.25, 0.75, size[1])[:, None]
    return slope + noise * np.random.default_rng(seed).normal(size=(count, *size, 3))


@pytest.fixture(params=error_scenes.SCENES)
def committed(request):
    """Each scene's committed Reference, with its name."""
    return request.param, references.read(request.param)


def test_committed_reference_tells_how_far_it_can_be_trusted(committed):
    """It has the scene's size, both renderers' samples, its own error, and an agreement that still passes."""
    name, reference = committed
    picture, about = reference.picture, reference.about
    assert picture.shape == (error_scenes.HEIGHT, error_scenes.WIDTH, 3) and picture.dtype == np.float32
    assert np.isfinite(picture).all() and picture.min() >= 0 and picture.std() > 0.01
    assert references.Agreement(**about["agreement"]).holds
    assert min(about["samples"].values()) >= 256 and min(about["CPU seconds"].values()) > 0
    assert 0 < about["weight of ours"] < 1 and 0 < about["error"] < 1e-4 and 0 < about["mse"]
    assert references.path_of(name).stat().st_size < LARGEST_FILE


def test_references_are_few_and_small():
    """A file for each scene and no other."""
    files = list(references.FOLDER.iterdir())
    assert {path.name for path in files} == {f"{name}.exr" for name in error_scenes.SCENES}
    assert sum(path.stat().st_size for path in files) < LARGEST_FOLDER


@pytest.mark.slow
@pytest.mark.parametrize("name", ["binary_primitives", "simple_phong", "thin_lens"])
def test_our_picture_of_today_is_the_references(name, tmp_path):
    """Rendered anew, its error is what its samples explain: an estimate from four pictures, without the reference."""
    from benchmarks.error_worker import Ours

    reference = references.read(name)
    ours = Ours(error_scenes.write(name, tmp_path))
    pictures = np.array([ours.render(None, 64, seed).picture for seed in range(1, 5)], np.float64)
    square = reference.picture.astype(np.float64) ** 2 + references.DARK
    explained = (pictures.var(0, ddof=1) / square).mean()
    found = ((pictures - reference.picture) ** 2 / square).mean()
    assert MARGIN * reference.about["error"] < found == pytest.approx(explained, rel=0.05)


def test_noise_alone_agrees():
    """Of twenty pairs none is refused, and their squares are those of noise."""
    found = [references.agreement(batches(seed), batches(1000 + seed, 3 * NOISE)) for seed in range(20)]
    assert all(one.holds for one in found)
    assert np.mean([one.squares for one in found]) == pytest.approx(1.07, abs=0.05)  # of t-tests, 15 to 30 free
    assert abs(np.mean([one.beyond for one in found])) < 1e-5


def spoilt_block(pictures):
    """Return the batches with one block brighter by 0.01."""
    pictures[:, 8:16, 16:24] += 0.01
    return pictures


def spoilt_everywhere(pictures):
    """Return the batches brighter by less than a thousandth."""
    return pictures * 1.0008


def spoilt_tint(pictures):
    """Return the batches with small errors of both signs all over, whose mean is none."""
    signs = np.kron(np.indices((16, 24)).sum(0) % 2 * 2 - 1, np.ones((8, 8)))
    return pictures + 0.001 * signs[..., None]


def spoilt_by_nan(pictures):
    """Return the batches with a NaN."""
    pictures[3, 5, 7, 1] = np.nan
    return pictures


@pytest.mark.parametrize("spoil, told", [
    (spoilt_block, {"block"}), (spoilt_everywhere, {"mean"}), (spoilt_tint, {"squares"}),
    (spoilt_by_nan, {"mean", "block", "squares"}),
])  # fmt: skip
def test_spoilt_picture_is_refused(spoil, told):
    """Each way in which one side can be wrong is seen by the number that is there for it, and by no other."""
    ours, theirs = (batches(seed, size=(128, 192)) for seed in (1, 2))
    assert references.agreement(ours, theirs).holds
    found = references.agreement(spoil(ours), theirs)
    limits = {"mean": references.MOST_MEAN, "block": references.MOST_BLOCK, "squares": references.MOST_SQUARES}
    assert {name for name, limit in limits.items() if not abs(getattr(found, name)) <= limit} == told
    assert not found.holds


def test_what_noise_does_not_explain_is_told():
    """Closed form: a difference of d everywhere is a relative MSE of d^2 / (r^2 + 0.01)."""
    ours, theirs = (batches(seed, 1e-3) for seed in (1, 2))
    ours += 0.01
    expected = (0.01**2 / (((ours.mean(0) + theirs.mean(0)) / 2) ** 2 + references.DARK)).mean()
    assert references.agreement(ours, theirs).beyond == pytest.approx(expected, rel=0.01)


def test_scene_on_which_the_sides_differ_is_not_written(monkeypatch, tmp_path, capsys):
    """The command says which, goes on, and fails."""
    spoilt = iter([batches(1), spoilt_block(batches(2)), batches(3), batches(4)])
    monkeypatch.setattr(references, "_batches", lambda *_: references.Side(next(spoilt), 100, 1.0))
    monkeypatch.setattr(references, "FOLDER", tmp_path)
    assert references.main(["cornell", "thin_lens"]) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["thin_lens.exr"]
    assert "cornell: the two renderers differ" in capsys.readouterr().err
    about = references.read("thin_lens").about
    assert about["samples"] == {"ours": 100, "Mitsuba": 100} and references.Agreement(**about["agreement"]).holds


def test_missing_reference_is_told_with_what_makes_it(monkeypatch, tmp_path):
    """In words, with the command."""
    monkeypatch.setattr(references, "FOLDER", references.ROOT / "no such folder")
    with pytest.raises(BenchmarkError, match="cornell.exr is missing; `python -m benchmarks.references cornell`"):
        references.read("cornell")


def test_quieter_side_has_the_greater_weight():
    """Variances 1 to 9 weigh 9 to 1, and the error that is told is the one that there is."""
    truth = batches(0, noise=0.0, count=1)[0]
    square, errors, told = truth**2 + references.DARK, [], []
    for seed in range(20):
        picture, (error, mse), weight = references.combined(batches(seed), batches(1000 + seed, 3 * NOISE))
        assert weight == pytest.approx(0.9, abs=0.01)
        errors.append(((picture - truth) ** 2 / square).mean())
        told.append(error)
        assert mse == pytest.approx(NOISE**2 / references.BATCHES * 0.9, rel=0.05)
    assert np.mean(told) == pytest.approx(np.mean(errors), rel=0.02)


@pytest.mark.parametrize("error", [1e-3, 1e-6, 1e-9])
def test_cut_mantissas_add_less_than_they_may(error):
    """Up to ROUNDED of the error, and more than an eighth of that: what could be cut was."""
    exact = np.random.default_rng(3).uniform(0.0, 4.0, (64, 64, 3)) ** 2
    added = ((references.cut(exact, error) - exact) ** 2 / (exact**2 + references.DARK)).mean()
    assert references.ROUNDED * error / 8 < added < references.ROUNDED * error


def test_reference_survives_its_file(monkeypatch, tmp_path):
    """Pixels, also beyond 1, and what is known of them."""
    monkeypatch.setattr(references, "FOLDER", tmp_path / "new")
    picture = np.linspace(0, 300, 16 * 24 * 3, dtype=np.float32).reshape(16, 24, 3)
    references.write(references.path_of("made-up"), picture, {"error": 1e-7})
    back = references.read("made-up")
    assert back.about == {"error": 1e-7}
    np.testing.assert_array_equal(back.picture, picture)
