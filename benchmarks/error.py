"""Speed against error of path tracing beside Mitsuba's `path`, scene by scene, at rising numbers of samples.

Contenders: ours as it is by default, and Mitsuba in `llvm_ad_rgb` and `scalar_rgb`, each with its `independent` sampler
and with the other stock sampler for which error x time is smallest (in `llvm_ad_rgb`, at 64 samples a pixel, found in
the same run); with a GPU also both on CUDA. All render the same scene: 192 x 128 pixels, box filter, no Russian
roulette, the same number of bounces. Each has a process and a kernel cache of its own, and they take turns, picture by
picture.

Time is that of a render whose kernels are compiled: CPU time of all threads, on a GPU time by the clock. Importing,
building the scene and compiling are told apart, each with an empty cache. Errors are taken against references of both
renderers (`references.py`); what is not ten times a reference's own error is left out. Relative MSE is the mean of
(x - r)^2 / (r^2 + 0.01); SSIM and FLIP compare tone-mapped pictures. Efficiency is 1 / (relative MSE x time).

At equal error: how many times our time Mitsuba takes to the error that it has with 64 samples a pixel (with fewer where
these would take too long), and beside its best sampler also to the least error that both reach. `scene` keeps the
coursework's material, which Mitsuba has as a plugin in Python; its scalar mode is left out there, which would mostly
run Python.
"""

from __future__ import annotations

import json
import sys
import tempfile
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from benchmarks import error_scenes, references
from benchmarks.error_curves import EQUAL_SAMPLES, Run, equal_error, told_apart
from benchmarks.error_process import Process
from benchmarks.error_worker import OURS
from benchmarks.measure import FULL, BenchmarkError, result, spread
from benchmarks.targets import HIGHER, Figure
from renderer import compare

SCENES = tuple(error_scenes.SCENES)
LEVELS = (1, 4, 16, 64, 256, 1024, 4096)  # samples a pixel
LONGEST, LONGEST_QUICK = 6.0, 4.0  # seconds of a single picture, CPU time: levels beyond are not rendered
REPEATS, REPEATS_QUICK = 3, 2  # of everything, with other seeds
PLAIN, OTHERS = "independent", ("stratified", "multijitter", "orthogonal", "ldsampler")
WARM = 16  # samples a pixel of the picture that compiles
NEUTRAL_EXPOSURE = 0.1  # of a camera: radiance 1 is white
AIM = 1.0  # x Mitsuba's best: nowhere slower
LEAST_OF_BOTH = "llvm best, at the least error of both"  # no ratio to be held: it depends on the effort


@dataclass(frozen=True)
class Contender:
    """A renderer with a sampler."""

    name: str
    side: str  # OURS or a variant of Mitsuba
    sampler: str | None  # None: its own
    on_gpu: bool = False


def measure(effort):
    """Return the curves of all contenders on all scenes, what came before rendering, and ratios at equal error."""
    quick = effort.samples < FULL.samples
    wanted = effort.scenes or (error_scenes.QUICK_SCENES if quick else SCENES)
    names = [name for name in SCENES if name in wanted]
    if not names:
        raise BenchmarkError(f"no scene is named {' or '.join(wanted)} (there are: {', '.join(SCENES)})")
    repeats = min(effort.repeats, REPEATS_QUICK if quick else REPEATS)
    longest = LONGEST_QUICK if quick else LONGEST
    tables = {"curves": [], "stages": [], "at equal error": [], "references": []}
    for name in names:
        print(f"  {name}", file=sys.stderr)
        for title, rows in of_scene(name, repeats, longest).items():
            tables[title] += rows
    figures = [
        Figure(f"{row['scene']}, speed at equal error beside Mitsuba's best", "x", HIGHER, slowest(row), None, AIM)
        for row in tables["at equal error"]
    ]
    return result(figures, **tables)


def slowest(row):
    """Return the median of the ratio beside whichever sampler of Mitsuba's JIT variant is the faster one."""
    return min(row[f"llvm {which}, x Mitsuba"]["median"] for which in ("independent", "best"))


def of_scene(name, repeats, longest):
    """Return {table: rows} of a scene."""
    reference = references.read(name)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        path = error_scenes.write(name, folder, *reference.picture.shape[1::-1])
        judge = Judge(path, reference)
        best = best_sampler(path, judge, folder)
        field = contenders(name, best)
        stages, runs = race(field, path, judge, folder, repeats, longest)
    kept = {who: told_apart(found, reference.about) for who, found in runs.items()}
    left_out = sum(map(len, runs.values())) - sum(map(len, kept.values()))
    if any(not found for found in kept.values()):
        raise BenchmarkError(f"{name}: the reference is too noisy for every level; make it anew with more samples")
    return {
        "curves": [row for who in field for row in _curve_rows(name, who, kept[who.name])], "stages": stages,
        "at equal error": [_equal_row(name, best, kept)], "references": [_reference_row(name, reference, left_out)],
    }  # fmt: skip


def contenders(name, best, gpu=None):
    """Return the Contenders on a scene; `best` is Mitsuba's best sampler but the plain one."""
    found = [Contender("ours", OURS, None)]
    variants = ["llvm"] if name in error_scenes.JIT_ONLY else ["llvm", "scalar"]
    if has_gpu() if gpu is None else gpu:
        found.append(Contender("ours cuda", OURS, None, on_gpu=True))
        variants.append("cuda")
    names = {"llvm": "llvm_ad_rgb", "scalar": "scalar_rgb", "cuda": "cuda_ad_rgb"}
    return found + [Contender(f"{variant} {sampler}", names[variant], sampler, on_gpu=variant == "cuda")
                    for variant in variants for sampler in (PLAIN, best)]  # fmt: skip


def has_gpu():
    """Return whether Dr.Jit can use CUDA here."""
    import drjit as dr

    return dr.has_backend(dr.JitBackend.CUDA)


class Judge:
    """Compares pictures of a scene with its reference."""

    def __init__(self, path, reference):
        camera = json.loads(path.read_text())["camera"]
        self._exposure = camera.get("exposure", NEUTRAL_EXPOSURE) / NEUTRAL_EXPOSURE
        self._reference = reference.picture

    def relative_mse(self, picture):
        """Return the error by which samplers are chosen."""
        return compare.relative_mse(picture, self._reference)

    def measures(self, picture):
        """Return {measure: value} as a Run has them."""
        pair = picture, self._reference
        try:
            flip = compare.flip(*pair, exposure=self._exposure)
        except ModuleNotFoundError:  # its makers have no package for this machine
            flip = None
        return {"mse": compare.mse(*pair), "relative_mse": self.relative_mse(picture),
                "ssim": compare.ssim(*pair, exposure=self._exposure), "flip": flip}  # fmt: skip


def best_sampler(path, judge, folder):
    """Return the one of OTHERS for which error x CPU time is smallest."""
    products = {}
    with Process("llvm_ad_rgb", path, folder) as mitsuba:
        for sampler in OTHERS:
            told, picture = mitsuba.compiled(sampler, EQUAL_SAMPLES, seed=1)
            products[sampler] = told["cpu"] * judge.relative_mse(picture)
    return min(products, key=products.get)


def race(field, path, judge, folder, repeats, longest):
    """Return the rows of `stages`, and {contender: Runs}.

    Processes are started `repeats` times, all in turns; the last ones stay and render in turns.
    """
    stages = {who.name: [] for who in field}
    with ExitStack() as stack:
        for last in [False] * (repeats - 1) + [True]:
            processes = {}
            for who in field:
                process = processes[who.name] = stack.enter_context(Process(who.side, path, folder, who.on_gpu))
                warm, _ = process.render(who.sampler, WARM, seed=1)
                stages[who.name].append(process.started | {"compile": warm["compile"]})
                if not last:
                    process.peak()
        runs = _in_turns(field, processes, judge, repeats, longest)
        peaks = {name: process.peak() for name, process in processes.items()}
    scene = path.stem
    return [_stage_row(scene, who.name, stages[who.name], peaks[who.name]) for who in field], runs


def _in_turns(field, processes, judge, repeats, longest):
    """Return {contender: Runs}: level by level, repeat by repeat, one after the other, until pictures take too long."""
    runs = {who.name: [] for who in field}
    going = list(field)
    for number, level in enumerate(LEVELS):
        # some samplers have taken more than they were asked for, up to this level's number
        racing = [who for who in going if not runs[who.name] or runs[who.name][-1].samples < level]
        for repeat in range(repeats):
            for who in racing:
                told, picture = processes[who.name].compiled(who.sampler, level, seed=100 * (number + 1) + repeat)
                runs[who.name].append(Run(level, told["samples"], repeat, told["cpu"], told["wall"],
                                          on_gpu=who.on_gpu, **judge.measures(picture)))  # fmt: skip
        if level < LEVELS[-1]:
            going = [who for who in going if _expected(runs[who.name][-1], LEVELS[number + 1]) <= longest]
    return runs


def _expected(run, samples):
    """Return the seconds that so many samples may take."""
    return run.seconds * samples / run.samples


def _curve_rows(scene, who, runs):
    """Return the rows of a contender, one for each number of samples."""
    rows = []
    for level in sorted({run.level for run in runs}):
        group = [run for run in runs if run.level == level]

        def of(value, group=group):
            return spread([value(run) for run in group])

        rows.append({
            "scene": scene, "contender": who.name, "samples a pixel": group[0].samples,
            "CPU time (s)": of(lambda run: run.cpu), "wall time (s)": of(lambda run: run.wall),
            "MSE": of(lambda run: run.mse), "relative MSE": of(lambda run: run.relative_mse),
            "SSIM": of(lambda run: run.ssim), "FLIP": None if group[0].flip is None else of(lambda run: run.flip),
            "efficiency": of(lambda run: 1 / (run.relative_mse * run.seconds)),
        })  # fmt: skip
    return rows


def _stage_row(scene, name, starts, peak):
    """Return the row of what one contender's processes took before and beside rendering."""
    return {"scene": scene, "contender": name,
            **{f"{key} (s)": spread([start[key] for start in starts]) for key in ("import", "build", "compile")},
            "peak memory (MB)": peak}  # fmt: skip


def _equal_row(scene, best, runs):
    """Return the row of a scene at equal error."""
    row = {"scene": scene, "Mitsuba's best other sampler": best, "relative MSE": None, LEAST_OF_BOTH: None}
    for variant in ("llvm", "scalar"):
        for which, sampler in (("independent", PLAIN), ("best", best)):
            theirs = runs.get(f"{variant} {sampler}")
            ratio, error = equal_error(runs["ours"], theirs) if theirs else (None, None)
            row[f"{variant} {which}, x Mitsuba"] = ratio
            if (variant, which) == ("llvm", "best"):
                row["relative MSE"] = error
                row[LEAST_OF_BOTH] = equal_error(runs["ours"], theirs, LEVELS[-1])[0]
    if "ours cuda" in runs:
        row["cuda best, x Mitsuba"] = min((equal_error(runs["ours cuda"], runs[f"cuda {sampler}"])[0]
                                           for sampler in (PLAIN, best)), key=lambda ratio: ratio["median"])
    return row


def _reference_row(scene, reference, left_out):
    """Return the row that tells how far the reference can be trusted."""
    about, agreed = reference.about, reference.about["agreement"]
    return {"scene": scene, "samples, ours": about["samples"]["ours"], "samples, Mitsuba": about["samples"]["Mitsuba"],
            "weight of ours": about["weight of ours"], "relative MSE": about["error"],
            "means apart": f"{agreed['relative']:.1e}", "in standard errors": agreed["mean"],
            "largest block, standard errors": agreed["block"], "mean square of blocks": agreed["squares"],
            "pictures left out": left_out}  # fmt: skip
