"""`python -m renderer compare PICTURE REFERENCE`: how far two pictures are apart, as a table, JSON and a picture."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, fields

import numpy as np

from renderer import compare, difference, pair as pairs
from renderer.core.errors import EXIT_DONE, RenderError, UsageError
from renderer.extras import install_command
from renderer.io import outputs
from renderer.options import LIMITED, parse_comparison, print_out

NOTICED = 1  # a level: a greater difference counts; rounding of one render's files makes no greater one
PACKAGES = {"ssim": (compare.ssim_of_seen, "SSIM", "scikit-image"),
            "flip": (compare.flip_of_seen, "FLIP", "flip-evaluator")}  # fmt: skip
LARGER_IS_BETTER = ("psnr", "ssim")


@dataclass(frozen=True)
class Values:
    """What is measured of two pictures; None where it cannot be. Places are (x, y) from the top left corner, from 0."""

    mse: float
    relative_mse: float
    psnr: float  # dB
    ssim: float | None
    flip: float | None
    differing_pixels: int
    differing_share: float
    greatest_levels: int
    greatest_at: tuple[int, int]
    greatest_radiance: float | None  # of pictures that hold radiance
    greatest_radiance_at: tuple[int, int] | None
    picture_mean: tuple[float, ...]  # R, G, B, linear
    reference_mean: tuple[float, ...]


def main(arguments, say):
    """Run the command and return its exit status; `say` prints to standard error.

    Raises: SceneError and UsageError for what cannot be compared, RenderError for what is worse than its limit.
    """
    options = parse_comparison(arguments)
    paths = options.output or []
    outputs.check(paths, (options.picture, options.reference), what="one of the pictures")
    try:
        pair = pairs.read(options)
        values, counts, remarks = measured(pair)
        _demand_limited(options.limit, values, remarks)
        worse = exceeded(options.limit, values)
        gain = options.gain or difference.fitting_gain(counts)
        failures = _draw(options, pair, gain)
    except MemoryError:
        raise RenderError("there is not enough memory to compare these pictures") from None
    if options.json:
        text = as_json(options, pair, values, remarks, worse, gain if paths else None)
    else:
        text = as_table(options, pair, values, remarks)
        text += "".join(f"{_drawn(path, gain)}\n" for path in paths if not failures)
    if outputs.STANDARD_OUTPUT in paths:
        say(text.rstrip("\n"))
    else:
        print_out(text)
    failures += [f"{name} is {getattr(values, name):.6g}, and its limit {limit:g}" for name, limit in worse.items()]
    if failures:
        raise RenderError("\n".join(failures))
    return EXIT_DONE


def _draw(options, pair, gain):
    """Write the pictures of the difference; return what went wrong, which must not cost the numbers."""
    header = {"compare.picture": options.picture, "compare.reference": options.reference}
    try:
        outputs.write_all(options.output or [], difference.DifferencePicture(pair, gain), outputs.Grading(), header)
    except RenderError as error:
        return [str(error)]
    return []


def measured(pair):
    """Return (Values, pixels by their difference in levels, remarks on what could not be measured)."""
    linear, seen, remarks = pair.linear(), pair.seen(), []
    found = {"ssim": None, "flip": None}
    missing = []
    for name, (measure, title, package) in PACKAGES.items():
        if name == "ssim" and min(pair.width, pair.height) < compare.WINDOW:
            remarks.append(f"SSIM needs {compare.WINDOW} x {compare.WINDOW} pixels at least")
            continue
        try:
            found[name] = measure(*seen)
        except ImportError:
            missing.append((title, package))
    if missing:
        titles, packages = (" and ".join(words) for words in zip(*missing))
        remarks.append(f"{titles} need{'s' * (len(missing) == 1)} {packages}: {install_command('compare')}")
    counts, (levels, at) = _levels_apart(pair)
    differing = int(counts[NOTICED + 1 :].sum())
    radiance, radiance_at = _radiance_apart(pair) if pair.is_radiance else (None, None)
    values = Values(
        mse=compare.mse(*linear), relative_mse=compare.relative_mse(*linear), psnr=compare.psnr_of_seen(*seen), **found,
        differing_pixels=differing, differing_share=differing / (pair.width * pair.height),
        greatest_levels=levels, greatest_at=at, greatest_radiance=radiance, greatest_radiance_at=radiance_at,
        picture_mean=_mean(linear[0]), reference_mean=_mean(linear[1]),
    )  # fmt: skip
    return values, counts, remarks


def _levels_apart(pair):
    """Return (pixels by the difference of their worst channel, (the greatest, its first place))."""
    x, y = pair.levels()
    counts, greatest = np.zeros(pairs.WHITE + 1, np.int64), (-1, None)
    for rows in compare.bands(pair.height, pair.width):
        apart = np.abs(x[rows].astype(np.int16) - y[rows]).max(axis=2)
        counts += np.bincount(apart.reshape(-1), minlength=counts.size)
        greatest = _greater(greatest, apart, rows)
    return counts, greatest


def _radiance_apart(pair):
    """Return (the greatest difference of a channel, its first place)."""
    x, y = pair.linear()
    greatest = (-1, None)
    for rows in compare.bands(pair.height, pair.width):
        apart = np.abs(np.asarray(x[rows], np.float64) - y[rows]).max(axis=2)
        greatest = _greater(greatest, apart, rows)
    return greatest


def _greater(greatest, apart, rows):
    """Return (value, (x, y)) of the greatest of a band, or what was there before."""
    row, column = np.unravel_index(apart.argmax(), apart.shape)
    value = apart[row, column].item()
    return (value, (int(column), int(rows.start + row))) if value > greatest[0] else greatest


def _mean(picture):
    """Return the mean colour."""
    height, width, _ = picture.shape
    sums = [np.asarray(picture[rows], np.float64).sum(axis=(0, 1)) for rows in compare.bands(height, width)]
    return tuple(math.fsum(channel) / (height * width) for channel in zip(*sums))


def _demand_limited(limits, values, remarks):
    """Raise UsageError where a measure has a limit and no value."""
    for name, _ in limits:
        if getattr(values, name) is None:
            raise UsageError(f"--limit {name}: {'; '.join(remarks)}")


def exceeded(limits, values):
    """Return {measure: limit} of those that are worse than their limit."""
    signs = {name: -1 if name in LARGER_IS_BETTER else 1 for name in LIMITED}
    return {name: limit for name, limit in limits if signs[name] * getattr(values, name) > signs[name] * limit}


def as_table(options, pair, values, remarks):
    """Return the table for people."""
    def place(at):
        return f"at x {at[0]}, y {at[1]}"

    def number(value, unit=""):
        return "-" if value is None else f"{value:.6g}{unit}"

    pixels = pair.width * pair.height
    rows = [
        ("MSE", number(values.mse)), ("relative MSE", number(values.relative_mse)),
        ("PSNR", number(values.psnr, " dB") if values.psnr < math.inf else "infinite: nothing is seen to differ"),
        ("SSIM", number(values.ssim)), ("FLIP", number(values.flip)),
        ("pixels that differ", f"{100 * values.differing_share:.4g} % ({values.differing_pixels} of {pixels}, "
                               f"by more than {NOTICED} level of {pairs.WHITE})"),
        ("greatest difference", f"{values.greatest_levels} levels {place(values.greatest_at)}"),
    ]  # fmt: skip
    if values.greatest_radiance is not None:
        rows.append(("... of radiance", f"{number(values.greatest_radiance)} {place(values.greatest_radiance_at)}"))
    rows += [(f"mean of the {name}", " ".join(f"{channel:.6g}" for channel in mean))
             for name, mean in (("picture", values.picture_mean), ("reference", values.reference_mean))]  # fmt: skip
    lines = [f"{options.picture} against {options.reference}: {pair.width} x {pair.height} pixels", pair.domain]
    width = max(len(name) for name, _ in rows)
    return "\n".join([*lines, *(f"  {name:{width}}  {text}" for name, text in rows), *remarks]) + "\n"


def _drawn(path, gain):
    """Return what a picture that was written shows."""
    if outputs.is_exr(path):
        return f"{path}: picture less reference, linear"
    return (f"{outputs.name(path)}: picture, reference, difference x {gain:g} "
            f"(lightest from {pairs.WHITE / gain:.4g} levels on)")  # fmt: skip


def as_json(options, pair, values, remarks, worse, gain):
    """Return the same as one line of JSON, for programs. Of equal pictures, PSNR is null: JSON knows no infinity."""
    told = {"picture": options.picture, "reference": options.reference, "width": pair.width, "height": pair.height,
            "domain": "radiance" if pair.is_radiance else "8 bits"}  # fmt: skip
    told |= {name: getattr(pair.look, name) if name in pair.used else None for name in pairs.NAMES}
    told |= {field.name: getattr(values, field.name) for field in fields(values)}
    told["psnr"] = values.psnr if values.psnr < math.inf else None
    told |= {"gain": gain, "remarks": [pair.domain, *remarks], "exceeded": list(worse)}
    return json.dumps(told, allow_nan=False) + "\n"
