"""Gates for noise-free pictures: each raises Mismatch, with numbers, unless two pictures are the same up to rounding.

Two correct float32 renderers differ in the last digits everywhere, and visibly only where rounding decides which
surface, texel or side of a shadow a ray meets. The gates therefore bound the median tightly (a common error shows),
the mean (a bias shows), the share of visibly different pixels (an edge may differ, an area may not), and forbid any
solid patch of such pixels. Medians are taken for each shape too, so that no wrong small shape can hide.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import minimum_filter

NO_SHAPE = 0xFFFFFFFF

# Colour, linear radiance.
COLOUR_MEDIAN = 1e-6  # float32 rounding of a sum of a few products
COLOUR_MEAN = 1e-4  # what the permitted edge pixels can add up to
COLOUR_VISIBLE = 1e-2  # a pixel off by more counts as wrong
COLOUR_SHARE = 1e-3  # share of such pixels: silhouettes and shadow edges
SHAPE_MEDIAN = 2e-5  # of one shape's pixels: curved mirrors and glass magnify where the oracle's secondary rays start
SHAPE_NINETY = 1e-4  # of the best 90 % of one shape's pixels: a wrong highlight covers few pixels and none off by much
SHAPE_PIXELS = 30  # fewer pixels of a shape give no trustworthy median
PATCH = 5  # pixels: side of a square that must not be filled with wrong pixels

# Other values: absolute where the value is of order 1, relative to the value where it is larger.
TOLERANCES = {
    "depth": 2e-5,  # relative; Mitsuba's spheres, tubes and far disks lose a few digits
    "normal": 4e-4,  # rounding of the position over the radius of small spheres
    "uv": 1e-4,  # rounding of the position over the length of u and v; angles near a pole
    "albedo": 2e-5,  # rounding of uv times the slope of an interpolated texture
}
VALUE_SHARE = 1e-3  # share of pixels that may exceed the tolerance
MEDIAN_DIGITS = 0.1  # medians must be this much smaller than the tolerance for single pixels
UNSETTLED_SHARE = 0.05  # the same for colours, which nested glass magnifies
UNCERTAIN_SHARE = 0.02  # more uncertain pixels than this make the comparison of masks worthless


class Mismatch(AssertionError):
    """Two pictures that should agree do not."""


def _demand(problems, what):
    """Raise Mismatch where there are problems."""
    if problems:
        raise Mismatch(f"{what}: " + "; ".join(problems))


def has_patch(wrong, side=PATCH):
    """Return whether a boolean picture contains a filled square of `side` pixels."""
    return bool(minimum_filter(np.asarray(wrong, dtype=np.uint8), size=side, mode="constant", cval=0).any())


def difference(ours, theirs):
    """Return (H, W) float64: the greatest absolute difference over channels; NaN counts as infinite."""
    if np.shape(ours) != np.shape(theirs):
        raise Mismatch(f"sizes differ: {np.shape(ours)} and {np.shape(theirs)}")
    delta = np.abs(np.asarray(ours, np.float64) - np.asarray(theirs, np.float64))
    delta = np.where(np.isnan(delta), np.inf, delta)
    return delta.max(axis=-1) if delta.ndim == 3 else delta


def check_colour(ours, theirs, labels=None):
    """Raise Mismatch unless two linear pictures (H, W, 3) agree; `labels` (H, W) tell the shapes apart."""
    delta = difference(ours, theirs)
    mean = np.abs((np.asarray(ours, np.float64) - theirs).mean(axis=(0, 1))).max()
    wrong = delta > COLOUR_VISIBLE
    problems = []
    if np.median(delta) > COLOUR_MEDIAN:
        problems.append(f"median {np.median(delta):.1e} > {COLOUR_MEDIAN:.0e}")
    if not mean <= COLOUR_MEAN:
        problems.append(f"mean difference {mean:.1e} > {COLOUR_MEAN:.0e}")
    if wrong.mean() > COLOUR_SHARE:
        problems.append(f"{wrong.sum()} of {wrong.size} pixels off by more than {COLOUR_VISIBLE}")
    if has_patch(wrong):
        problems.append(f"a solid {PATCH} x {PATCH} patch of wrong pixels")
    for label in np.unique(labels) if labels is not None else ():
        here = delta[labels == label]
        name = "background" if label == NO_SHAPE else f"shape {label}"
        for share, limit in ((0.5, SHAPE_MEDIAN), (0.9, SHAPE_NINETY)) if len(here) >= SHAPE_PIXELS else ():
            if np.quantile(here, share) > limit:
                problems.append(f"{share:.0%} quantile over {name} {np.quantile(here, share):.1e} > {limit:.0e}")
    _demand(problems, "colour")


def check_shapes(ours, theirs, uncertain):
    """Raise Mismatch unless shape numbers (H, W), NO_SHAPE for a miss, differ in `uncertain` pixels only.

    Returns how many pixels differ and how many are uncertain: those whose ray passes a silhouette within rounding.
    """
    if np.shape(ours) != np.shape(theirs):
        raise Mismatch(f"sizes differ: {np.shape(ours)} and {np.shape(theirs)}")
    different = np.asarray(ours) != np.asarray(theirs)
    problems = []
    if uncertain.mean() > UNCERTAIN_SHARE:
        problems.append(f"{uncertain.sum()} uncertain pixels: the comparison would say nothing")
    if (different & ~uncertain).any():
        problems.append(f"{(different & ~uncertain).sum()} pixels differ that no rounding explains")
    _demand(problems, "shape numbers")
    return int(different.sum()), int(uncertain.sum())


def check_values(name, ours, theirs, where, spread, periodic=None):
    """Raise Mismatch unless two pictures of depth, normal, uv or albedo agree in the pixels `where`.

    `spread` (H, W) is how much the value changes within the camera's rounding, which no tolerance can undercut.
    `periodic` (H, W) marks pixels whose first channel is an angle, 0 and 1 being the same.
    """
    ours, theirs = np.asarray(ours, np.float64), np.asarray(theirs, np.float64)
    if periodic is not None:
        ours = np.where(periodic[..., None] & (np.arange(ours.shape[-1]) == 0), unwrap(ours, theirs), ours)
    delta = difference(ours, theirs)
    size = np.abs(theirs).max(axis=-1) if theirs.ndim == 3 else np.abs(theirs)
    scale = size if name == "depth" else np.maximum(size, 1)
    relative = np.where(where, delta / np.where(where, scale, 1), 0)
    allowed = TOLERANCES[name] + spread / np.where(where, scale, 1)
    wrong = where & ~(relative <= allowed)
    problems = []
    if not where.any():
        problems.append("no pixel to compare")
    elif np.median(relative[where]) > TOLERANCES[name] * MEDIAN_DIGITS:
        problems.append(f"median {np.median(relative[where]):.1e} > {TOLERANCES[name] * MEDIAN_DIGITS:.0e}")
    if wrong.mean() > VALUE_SHARE:
        problems.append(f"{wrong.sum()} pixels off by more than {TOLERANCES[name]:.0e}")
    if has_patch(wrong):
        problems.append(f"a solid {PATCH} x {PATCH} patch of wrong pixels")
    _demand(problems, name)


def unwrap(ours, theirs):
    """Return `ours` moved by whole numbers to lie next to `theirs`."""
    return ours - np.rint(ours - theirs)
