"""Speed against error: the arithmetic on made-up curves, the workers, and one scene in small from end to end."""

import dataclasses
import io
import json
import sys

import numpy as np
import pytest

from benchmarks import error, error_process, error_scenes, error_worker, references, table
from benchmarks.error_curves import MARGIN, Run, curve, equal_error, time_for, told_apart
from benchmarks.measure import QUICK, BenchmarkError


def run(level, seconds, relative_mse, repeat=0, **changes):
    """Return a Run with the given time and error."""
    return Run(level, changes.pop("samples", level), repeat, seconds, 2 * seconds, relative_mse / 2, relative_mse, 0.5,
               0.1, **changes)  # fmt: skip


def law(seconds, relative_mse, levels=(1, 4, 16, 64), repeats=(1.0,), power=1.0):
    """Return runs of a contender whose error falls with a power of the samples; repeats differ by factors of time."""
    return [run(n, seconds * n * factor, relative_mse / n**power, repeat)
            for repeat, factor in enumerate(repeats) for n in levels]  # fmt: skip


def test_time_to_an_error_lies_on_the_line_between_two_points():
    """Closed form: an error of c / t takes c / error, also between the points, and the points themselves."""
    points = [(1.0, 8.0), (4.0, 2.0), (16.0, 0.5)]
    for wanted in (8.0, 5.0, 2.0, 1.0, 0.5):
        assert time_for(points, wanted) == pytest.approx(8.0 / wanted)


def test_an_error_beyond_the_curve_is_not_guessed():
    """Nothing is faster than the first picture, and what was not reached has no time."""
    points = [(1.0, 8.0), (4.0, 2.0)]
    assert time_for(points, 100.0) == 1.0
    with pytest.raises(ValueError, match="not reached"):
        time_for(points, 1.9)


def test_curve_falls():
    """A picture that took longer and is no better is passed over."""
    runs = [run(16, 4.0, 1.0), run(1, 1.0, 3.0), run(4, 2.0, 3.5), run(4, 2.0, 0.1, repeat=1)]
    assert curve(runs, 0) == [(1.0, 3.0), (4.0, 1.0)]


def test_ratio_at_equal_error_is_that_of_the_laws():
    """With a fifth of the noise and half of the time for a sample the same error is there ten times as soon."""
    ratio, reached = equal_error(law(1.0, 2.0), law(2.0, 10.0))
    assert ratio["median"] == pytest.approx(10.0) and ratio["min"] == pytest.approx(ratio["max"])
    assert reached == pytest.approx(10.0 / 64)


def test_ratio_depends_on_the_error_where_one_side_converges_faster():
    """Closed form: ours falls with N^2, and takes sqrt(N) samples where Mitsuba takes N; that is 64 if it can."""
    for levels in ((1, 4, 16, 64), (1, 4, 16, 64, 256, 1024)):
        ours, theirs = law(1.0, 1.0, power=2.0), law(1.0, 1.0, levels)
        assert equal_error(ours, theirs)[0]["median"] == pytest.approx(8.0)
        assert equal_error(ours, theirs, 4096)[0]["median"] == pytest.approx(levels[-1] ** 0.5)


def test_ratio_is_taken_where_both_come():
    """Where Mitsuba has fewer samples than 64, at its last; where ours is the worse one, at its best."""
    ratio, reached = equal_error(law(1.0, 1.0), law(3.0, 1.0, levels=(1, 4)))
    assert ratio["median"] == pytest.approx(3.0) and reached == pytest.approx(1 / 4)
    ratio, reached = equal_error(law(1.0, 9.0, levels=(1, 4, 16)), law(1.0, 1.0))
    assert ratio["median"] == pytest.approx(1 / 9) and reached == pytest.approx(9 / 16)


def test_spread_is_over_repeats():
    """Each repeat has a ratio of its own."""
    ratio, _ = equal_error(law(1.0, 1.0, repeats=(1.0, 1.0, 1.0)), law(1.0, 1.0, repeats=(2.0, 3.0, 5.0)))
    assert [ratio[key] for key in ("min", "median", "max")] == pytest.approx([2.0, 3.0, 5.0])


def test_time_on_a_gpu_is_by_the_clock():
    """CPU time says nothing about it."""
    assert run(1, 1.0, 1.0).seconds == 1.0 and run(1, 1.0, 1.0, on_gpu=True).seconds == 2.0


@pytest.mark.parametrize("measure", ["error", "mse"])
def test_levels_near_the_references_own_error_are_dropped(measure):
    """What is not MARGIN times as large would tell of the reference; all repeats of a level go together."""
    runs = law(1.0, 1.0, repeats=(1.0, 1.0))
    about = {"error": 0.0, "mse": 0.0}
    assert told_apart(runs, about) == runs
    limit = {"error": 1 / 16, "mse": 1 / 32}[measure] / MARGIN
    assert {kept.level for kept in told_apart(runs, about | {measure: limit * 0.99})} == {1, 4, 16}
    assert {kept.level for kept in told_apart(runs, about | {measure: limit * 1.01})} == {1, 4}


def test_levels_stop_where_pictures_take_too_long(monkeypatch):
    """Contenders take turns; a sampler that took more samples than asked is not asked for those again."""
    asked = []

    class Fake:
        def __init__(self, name, seconds, least):
            self._name, self._seconds, self._least = name, seconds, least

        def compiled(self, sampler, samples, seed):
            taken = max(samples, self._least)
            asked.append((self._name, samples))
            return {"samples": taken, "cpu": self._seconds * taken, "wall": 0.0, "compile": 0.0}, None

    monkeypatch.setattr(error, "LEVELS", (1, 4, 16))
    one = {"mse": 1.0, "relative_mse": 1.0, "ssim": 1.0, "flip": 1.0}
    judge = type("Judge", (), {"measures": lambda self, picture: one})()
    field = [error.Contender(name, "ours", None) for name in ("slow", "rounds")]
    runs = error._in_turns(field, {"slow": Fake("slow", 0.3, 1), "rounds": Fake("rounds", 0.1, 4)}, judge, 2, 2.0)
    assert asked == 2 * [("slow", 1), ("rounds", 1)] + 2 * [("slow", 4)] + 2 * [("rounds", 16)]
    assert [one.samples for one in runs["rounds"]] == [4, 4, 16, 16]


def test_flip_may_be_missing(monkeypatch):
    """Its makers offer no package for every machine: the column stays empty, and the other measures are there."""
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    judge = error.Judge.__new__(error.Judge)
    judge._exposure, judge._reference = 1.0, np.full((12, 12, 3), 0.5)
    found = judge.measures(np.full((12, 12, 3), 0.25))
    assert found["flip"] is None and found["mse"] == 0.0625 and 0 < found["ssim"] < 1
    row, = error._curve_rows("cornell", error.Contender("ours", "ours", None), [Run(1, 1, 0, 1.0, 1.0, **found)])
    assert row["FLIP"] is None and row["MSE"]["median"] == 0.0625
    assert table.cell(row["FLIP"], "FLIP") == "-"


def test_every_scene_has_the_same_contenders_but_for_the_plugin():
    """Where Mitsuba would run Python at every hit in scalar mode, that is not called Mitsuba's speed."""
    names = [who.name for who in error.contenders("cornell", "multijitter", gpu=False)]
    assert names == ["ours", "llvm independent", "llvm multijitter", "scalar independent", "scalar multijitter"]
    assert len(error.contenders("scene", "multijitter", gpu=False)) == 3
    on_gpu = [who for who in error.contenders("cornell", "ldsampler", gpu=True) if who.on_gpu]
    assert [(who.name, who.side) for who in on_gpu] == [
        ("ours cuda", "ours"), ("cuda independent", "cuda_ad_rgb"), ("cuda ldsampler", "cuda_ad_rgb")]  # fmt: skip


@pytest.mark.parametrize("name", [name for name in error_scenes.SCENES if name != "mesh_1m"])  # as mesh_100k
def test_only_the_scenes_that_say_so_need_a_plugin(name, tmp_path, monkeypatch):
    """Mitsuba gets stock materials, exactly the same as ours; meshes are replaced by small ones here."""
    from benchmarks.mesh_scenes import bumpy
    from converters.mitsuba.plan import plan
    from renderer.scene import loader

    monkeypatch.setattr(error_scenes.path_scenes, "bumpy", lambda count: bumpy(72))
    loaded = loader.load(error_scenes.write(name, tmp_path))
    assert not loaded.warnings and not plan(loaded, exact=True).warnings
    types = str(plan(loaded, exact=True).children)
    assert ("type='coursework'" in types) == (name in error_scenes.JIT_ONLY)
    assert not loaded.description.roulette and loaded.description.filter == "box"


@pytest.fixture
def tiny(tmp_path):
    """The scene file of the coursework's primitives, 24 x 16 pixels."""
    return error_scenes.write("binary_primitives", tmp_path, 24, 16)


def test_worker_speaks_lines_of_json(tmp_path):
    """It greets, answers each question with a picture beside it, and ends with its memory."""

    class Fake:
        imported, built = 0.25, 0.5

        def render(self, sampler, samples, seed):
            return error_worker.Shot(np.full((2, 3, 3), seed, np.float32), 2 * samples, 1.0, 2.0, 3.0)

    question = {"sampler": "independent", "samples": 8, "seed": 5, "picture": str(tmp_path / "p.npy")}
    answers = io.StringIO()
    error_worker.serve(Fake(), [json.dumps(question), "{}", "never read"], answers)
    greeting, shot, end = map(json.loads, answers.getvalue().splitlines())
    assert greeting == {"import": 0.25, "build": 0.5}
    assert shot == {"samples": 16, "cpu": 1.0, "wall": 2.0, "compile": 3.0}
    assert (np.load(tmp_path / "p.npy") == 5).all() and 10 < end["peak"] < 10_000


def test_our_process_renders_what_the_renderer_renders(tiny, tmp_path):
    """The picture is that of `render`, byte for byte; the first one compiles, the next does not."""
    from renderer.engine.render import render
    from renderer.scene import loader

    with error_process.Process(error_worker.OURS, tiny, tmp_path) as process:
        first, _ = process.render(None, 8, seed=3)
        told, picture = process.compiled(None, 8, seed=3)
        assert 50 < process.peak() < 2000
    assert first["compile"] > 0.01 and told["compile"] == 0 and told["samples"] == 8
    assert told["cpu"] > 0 and told["wall"] > 0 and process.started["build"] > 0
    channels = render(loader.override(loader.load(tiny), samples=8), seed=3).channels()
    np.testing.assert_array_equal(picture, np.stack([channels[c] for c in "RGB"], axis=-1))


def test_process_that_fails_is_told_in_words(tmp_path):
    """Its last words, and no traceback of ours."""
    path = tmp_path / "none.json"
    with pytest.raises(BenchmarkError, match="(?s)error_worker ours .*none.json' ended with status 1: .*none.json"):
        error_process.Process(error_worker.OURS, path, tmp_path)


def test_picture_that_always_compiles_is_refused():
    """Its time would be that of a compiler."""
    process = object.__new__(error_process.Process)
    process.render = lambda *_: ({"compile": 0.2}, None)
    with pytest.raises(BenchmarkError, match="compiled anew each time"):
        process.compiled("independent", 4, 1)


@pytest.mark.oracle
def test_mitsuba_renders_with_the_sampler_that_it_is_told(tiny):
    """The same expectation as ours, less noise than with independent samples, and numbers rounded up are told."""
    theirs, ours = error_worker.Theirs(tiny, "llvm_ad_rgb"), error_worker.Ours(tiny)
    truth = ours.render(None, 1024, 1).picture
    plain, stratified = (theirs.render(sampler, 64, 1) for sampler in ("independent", "multijitter"))
    assert plain.samples == stratified.samples == 64
    errors = [((shot.picture - truth) ** 2).mean() for shot in (plain, stratified)]
    assert 0 < errors[1] < errors[0] / 3 < 1e-4
    assert theirs.render("orthogonal", 16, 1).samples == 25


@pytest.mark.slow
@pytest.mark.oracle
def test_one_scene_from_end_to_end(monkeypatch):
    """Every table has what it promises; times are not judged."""
    monkeypatch.setattr(error, "LEVELS", (4, 16))
    monkeypatch.setattr(error, "EQUAL_SAMPLES", 4)
    committed = references.read("binary_primitives")
    small = dataclasses.replace(committed, picture=committed.picture.reshape(16, 8, 24, 8, 3).mean((1, 3)))
    monkeypatch.setattr(references, "read", lambda name: small)
    effort = dataclasses.replace(QUICK, repeats=1, scenes=("binary_primitives",))
    found = error.measure(effort)
    tables = found["tables"]
    samples = [row["samples a pixel"] for row in tables["curves"]]
    assert samples[0::2] == 5 * [4] and set(samples[1::2]) <= {16, 25}  # 25: rounded up by a sampler
    assert len(tables["stages"]) == 5 and all(row["compile (s)"]["median"] > 0.01 for row in tables["stages"][:3])
    for row in tables["curves"]:
        assert 0 < row["relative MSE"]["median"] < 0.1 and 0 < row["FLIP"]["median"] < 0.2 < row["SSIM"]["median"] < 1
    (equal,), (judged,) = tables["at equal error"], found["figures"]
    assert judged["reached"] == min(equal[f"llvm {which}, x Mitsuba"]["median"] for which in ("independent", "best"))
    for rows in tables.values():
        assert table.table(rows).count("\n") == len(rows) + 1


def test_unknown_scene_is_told(monkeypatch):
    """Before anything is measured."""
    with pytest.raises(BenchmarkError, match="no scene is named teapod .there are: binary_primitives, "):
        error.measure(dataclasses.replace(QUICK, scenes=("teapod",)))
