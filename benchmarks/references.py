"""Reference pictures of the benchmark `error`, made by both renderers: `python -m benchmarks.references [NAME ...]`.

Each side renders BATCHES pictures with seeds of their own, for about so many SECONDS of CPU time. Only where the two
agree is the reference written: their mean, each side weighted by the inverse of its variance. A weight belongs to a
whole picture: weights by pixel would follow the noise, and draw the mean towards the side that is darker by chance.

The two agree if no block of pixels, no sum of squares over the blocks and no mean brightness is further apart than
noise explains. Beside the noise counts a share of a block's radiance: FLOOR for rounding, and OFFSETS on meshes.
Mitsuba starts rays 1e-4 (1 + |p|) off a surface, which lets light through their finest crevices. What is left between
the two beyond noise, as a relative MSE, is told too.

The file is an EXR whose header tells how it was made. Mantissas are cut to as many bits as the reference's own error
deserves, so that the files stay small.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks import error_scenes
from benchmarks.machine import describe
from benchmarks.measure import ROOT, BenchmarkError

FOLDER = ROOT / "benchmarks" / "references"
DARK = 0.01  # added to squares, so that the error of black pixels stays finite
BATCHES = 16  # of each side, independent: enough to estimate their variance
SECONDS = {"ours": 100.0, "Mitsuba": 50.0}  # CPU time: a batch of ours takes longer than any picture that is measured
FIRST_SEED = 100_000  # those that are measured lie below
TRIAL, LARGEST = 16, 256  # samples a pixel: to learn the speed, and at once in Mitsuba, whose sums are of 32 bits
THEIR_SAMPLER = "multijitter"
BLOCK = 8  # pixels
FLOOR = 1e-4  # of a block's radiance
OFFSETS = {"mesh_100k": 2e-4, "mesh_1m": 5e-4}
MOST_BLOCK, MOST_SQUARES, MOST_MEAN = 7.0, 1.6, 4.0  # standard errors; mean square of those; standard errors
ROUNDED = 0.05  # of the reference's error, that cutting its mantissas may add
KEY = "reference"  # of the file's header


@dataclass(frozen=True)
class Agreement:
    """How far the batches of the two sides are apart, in standard errors of the difference."""

    mean: float  # of the mean radiance
    block: float  # of the block where that is largest
    squares: float  # mean over blocks and channels of its square: 1 for noise alone
    relative: float  # mean radiance of ours over Mitsuba's, less 1
    beyond: float  # relative MSE between the two that their noise does not explain; below 0 where it explains all

    @property
    def holds(self):
        """Return whether noise explains it; a NaN is refused."""
        return abs(self.mean) <= MOST_MEAN and self.block <= MOST_BLOCK and self.squares <= MOST_SQUARES


@dataclass(frozen=True)
class Reference:
    """A reference picture and what is known about it."""

    picture: np.ndarray  # (H, W, 3) float32, linear
    about: dict  # `error`, the relative MSE that it has itself, `mse`, and how it was made


def agreement(ours, theirs, floor=FLOOR):
    """Return the Agreement of two sides, (K, H, W, 3) each; `floor` of a block's radiance is granted to them."""
    (a, va), (b, vb) = (_moments(_blocks(side)) for side in (ours, theirs))
    score = (a - b) / np.sqrt(va + vb + (floor * np.maximum(abs(a), abs(b))) ** 2 + 1e-30)
    (mean_a, var_a), (mean_b, var_b) = (_moments(side.mean((1, 2, 3))) for side in (ours, theirs))
    apart = (mean_a - mean_b) / math.sqrt(var_a + var_b + (floor * max(mean_a, mean_b)) ** 2 + 1e-30)
    (a, va), (b, vb) = _moments(ours), _moments(theirs)
    beyond = (((a - b) ** 2 - va - vb) / (((a + b) / 2) ** 2 + DARK)).mean()
    return Agreement(float(apart), float(abs(score).max()), float((score**2).mean()), float(mean_a / mean_b - 1),
                     float(beyond))


def _moments(batches):
    """Return the mean along the first axis and the variance of that mean."""
    return batches.mean(0), batches.var(0, ddof=1) / len(batches)


def _blocks(batches):
    """Return the means of BLOCK x BLOCK pixels; what is left over at the edges is dropped."""
    count, height, width, channels = batches.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = batches[:, :rows * BLOCK, :columns * BLOCK]
    return cut.reshape(count, rows, BLOCK, columns, BLOCK, channels).mean((2, 4))


def combined(ours, theirs):
    """Return the mean of two sides (K, H, W, 3), its (relative MSE, MSE) by estimate, and the share of ours in it."""
    (a, va), (b, vb) = _moments(ours), _moments(theirs)
    square = ((a + b) / 2) ** 2 + DARK
    weights = np.array([1 / max((v / square).mean(), 1e-30) for v in (va, vb)])
    x, y = weights / weights.sum()
    variance = x**2 * va + y**2 * vb
    return x * a + y * b, (float((variance / square).mean()), float(variance.mean())), float(x)


def cut(picture, error):
    """Return float32 pixels with mantissas so short that rounding adds ROUNDED of `error` (a relative MSE) at most."""
    # a mantissa of m bits, 1 <= f < 2, is rounded by up to 2^-m / 2: mean square 2^-2m / 12, over f^2 half of that
    bits = min(23, max(1, math.ceil(0.5 * math.log2(1 / (24 * ROUNDED * max(error, 1e-30))))))
    dropped = 23 - bits
    words = np.ascontiguousarray(picture, np.float32).view(np.uint32).astype(np.uint64)
    words = (words + (1 << dropped >> 1)) >> dropped << dropped
    return words.astype(np.uint32).view(np.float32)


def path_of(name):
    """Return the file of a scene's reference."""
    return FOLDER / f"{name}.exr"


def write(path, picture, about):
    """Write a reference; `about` is plain data."""
    from renderer.io.image import write_exr

    channels = {name: np.ascontiguousarray(picture[..., k]) for k, name in enumerate("RGB")}
    path.parent.mkdir(exist_ok=True)
    write_exr(path, channels, {KEY: json.dumps(about)})


def read(name):
    """Return the Reference of a scene. Raises BenchmarkError where there is none."""
    import OpenEXR

    path = path_of(name)
    if not path.exists():
        raise BenchmarkError(f"{path.relative_to(ROOT)} is missing; `python -m benchmarks.references {name}` makes it")
    with OpenEXR.File(str(path)) as file:
        channels, header = file.channels(), file.header()
        pixels = channels["RGB"].pixels if "RGB" in channels else np.stack([channels[c].pixels for c in "RGB"], -1)
        return Reference(np.array(pixels, np.float32), json.loads(header[KEY]))


def made(name, share=1.0, size=(error_scenes.WIDTH, error_scenes.HEIGHT)):
    """Return the picture of a scene and what its file is to tell; `share` of the time is spent.

    Raises BenchmarkError where the sides differ.
    """
    from benchmarks.error_worker import Ours, Theirs

    with tempfile.TemporaryDirectory() as folder:
        path = error_scenes.write(name, Path(folder), *size)
        ours = _batches(Ours(path), None, share * SECONDS["ours"])
        theirs = _batches(Theirs(path, "llvm_ad_rgb"), THEIR_SAMPLER, share * SECONDS["Mitsuba"], LARGEST)
    found = agreement(ours.pictures, theirs.pictures, OFFSETS.get(name, FLOOR))
    if not found.holds:
        raise BenchmarkError(f"{name}: the two renderers differ: {found}")
    picture, (error, mse), weight = combined(ours.pictures, theirs.pictures)
    about = {"error": error, "mse": mse, "weight of ours": weight, "agreement": asdict(found),
             "samples": {"ours": ours.samples, "Mitsuba": theirs.samples},
             "CPU seconds": {"ours": ours.seconds, "Mitsuba": theirs.seconds}, "versions": _versions()}
    return cut(picture, error), about


@dataclass(frozen=True)
class Side:
    """The batches of one renderer."""

    pictures: np.ndarray  # (K, H, W, 3) float64
    samples: int  # a pixel, all batches
    seconds: float  # CPU


def _batches(contender, sampler, seconds, largest=2**20):
    """Return the Side of a contender: a power of two of samples a batch, at most `largest` of them at once."""
    for _ in range(3):  # the first ones compile
        trial = contender.render(sampler, TRIAL, FIRST_SEED)
    wanted = max(TRIAL, TRIAL * seconds / BATCHES / trial.cpu)
    samples = 2 ** int(math.log2(wanted))
    parts = max(1, samples // largest)
    pictures, spent, taken, seed = [], 0.0, 0, FIRST_SEED
    for _ in range(BATCHES):
        shots = []
        for _ in range(parts):
            seed += 1
            shots.append(contender.render(sampler, samples // parts, seed))
        pictures.append(np.mean([shot.picture for shot in shots], axis=0, dtype=np.float64))
        spent += sum(shot.cpu for shot in shots)
        taken += sum(shot.samples for shot in shots)  # some samplers round up
    return Side(np.array(pictures), taken, spent)


def _versions():
    """Return what rendered, and when."""
    told = describe()
    return {"ours": told["commit"]} | {key: told[key] for key in ("drjit", "mitsuba", "llvm", "date")}


def main(arguments=None):
    """Make the references of the named scenes, or of all; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.references", allow_abbrev=False,
                                     description="Make the references of scenes, where the two renderers agree.")
    parser.add_argument("names", nargs="*", metavar="NAME",
                        help=f"of these: {', '.join(error_scenes.SCENES)} (default: all)")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.names if name not in error_scenes.SCENES]
    if unknown:
        parser.error(f"unknown scene '{unknown[0]}' (there are: {', '.join(error_scenes.SCENES)})")
    failed = False
    for name in options.names or error_scenes.SCENES:
        try:
            picture, about = made(name)
        except BenchmarkError as error:
            print(f"references: {error}", file=sys.stderr)
            failed = True
            continue
        write(path_of(name), picture, about)
        print(f"{name}: relative MSE {about['error']:.1e}, {about['agreement']}, {about['samples']}, "
              f"{path_of(name).stat().st_size} bytes", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
