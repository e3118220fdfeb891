"""Our picture beside Mitsuba's and their difference on one scale, and in numbers how far they agree.

All that the report renders is rendered here, by `both` and `alone`: the tests put flat pictures in their place. What
else takes long is marked as `slow`.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from renderer.engine.render import render
from renderer.scene.loader import from_dict, load, override
from renderer.scene.schema import PATHTRACER
from tools import testsuite
from tools.report.results import ROOT, THIN, digits, percent, unit

SIZE = 480, 320  # pixels of a picture
FULL_SCALE = 1 / 20  # of white: the difference at the end of the colour map, in all figures
LEVELS = 255  # steps between black and white
HIGH = 0.999  # the quantile told beside the median
COLOURS = "magma_r"  # light where there is no difference, so that single pixels show in print


quick = False  # whether `slow` functions are replaced, as in the tests


def slow(stand_in):
    """Mark a function that takes more than a second: with `quick`, `stand_in` is called with its arguments instead."""
    def marked(function):
        @functools.wraps(function)
        def chosen(*arguments, **settings):
            return (stand_in if quick else function)(*arguments, **settings)

        return chosen

    return marked


@dataclass(frozen=True)
class Both:
    """Two pictures of one scene, (height, width, 3) in [0, 1]; radiance where light is estimated, else None."""

    ours: np.ndarray
    theirs: np.ndarray
    our_radiance: np.ndarray | None = None
    their_radiance: np.ndarray | None = None

    @property
    def noisy(self):
        """Whether noise decides about single pixels."""
        return self.our_radiance is not None


def pair(folder: Path, name: str, scene: str, *, mode: str | None = None, size: tuple[int, int] = SIZE,
         samples: int | None = None, document: dict | None = None) -> dict[str, str]:
    """Write NAME_ours, NAME_mitsuba and NAME_difference, and return how far the two agree, as text.

    `scene` is a path below scenes/ without its ending; a `document` takes its place, and `scene` then names the folder
    that its files lie in. Keys: NAME_median, NAME_high and NAME_greatest, differences in 8-bit levels (of the channel
    that differs most); NAME_apart, the share of pixels that differ by more than one level, and NAME_pixels, how many
    and of how many; of path-traced pictures the same of the means of squares, and NAME_means, the relative difference
    of mean radiance with its standard error.
    """
    found = both(prepared(scene, mode, size, samples, document))
    difference = found.ours - found.theirs
    if found.noisy:
        difference = testsuite.blocks(difference)
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / f"{name}_ours", found.ours, found.noisy)
    write(folder / f"{name}_mitsuba", found.theirs, found.noisy)
    write(folder / f"{name}_difference", coloured(difference), False)
    return agreement(name, difference, found)


def picture(folder: Path, name: str, scene: str, *, mode: str | None = None, size: tuple[int, int] = SIZE,
            samples: int | None = None, document: dict | None = None, noisy: bool = False) -> None:
    """Write our picture of a scene alone; `noisy` ones as JPEG."""
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / name, alone(prepared(scene, mode, size, samples, document)), noisy)


def prepared(scene, mode=None, size=SIZE, samples=None, document=None):
    """Return the loaded scene with the settings of a picture."""
    path = ROOT / "scenes" / f"{scene}.json"
    loaded = load(str(path)) if document is None else from_dict(document, directory=str(ROOT / "scenes" / scene))
    return override(loaded, mode=mode, width=size[0], height=size[1], samples=samples)


def both(loaded) -> Both:
    """Return our picture and Mitsuba's of a loaded scene; where the reference takes one ray, ours takes one too."""
    if loaded.description.rendermode != PATHTRACER:
        ours, theirs = testsuite.ours_and_mitsubas(override(loaded, samples=1))
        return Both(ours, testsuite.coarse(theirs))
    from converters.path_traced import reference

    rendering, theirs = render(loaded), reference(loaded)
    shown = testsuite.coarse(testsuite.encoded(testsuite.toned(theirs, loaded.description)))
    channels = rendering.channels()
    ours = np.stack([channels[name] for name in "RGB"], axis=-1)
    return Both(testsuite.picture_of(rendering), shown, ours, theirs)


def alone(loaded) -> np.ndarray:
    """Return our picture of a loaded scene, (height, width, 3) in [0, 1]."""
    return testsuite.picture_of(render(loaded))


def coloured(difference: np.ndarray) -> np.ndarray:
    """Return differences, (height, width, 3), as colours: of the channel that differs most, FULL_SCALE at the end."""
    import matplotlib

    return matplotlib.colormaps[COLOURS](np.abs(difference).max(-1) / FULL_SCALE)[..., :3]


def agreement(name: str, difference: np.ndarray, found: Both) -> dict[str, str]:
    """Return the numbers of `pair`."""
    step = testsuite.BLOCK if found.noisy else 1
    levels = LEVELS * np.abs(difference).max(-1)[::step, ::step]
    apart = levels > 1.5  # between one level and two: both are rounded
    numbers = {"apart": percent(float(apart.mean())), "pixels": f"{apart.sum():,} of {apart.size:,}"}
    for key, value in (("median", np.median(levels)), ("high", np.quantile(levels, HIGH, method="higher")),
                       ("greatest", levels.max())):  # fmt: skip
        text = digits(float(value)) if found.noisy else f"{value:.0f}"
        numbers[key] = f"{text}{THIN}{'level' if text == '1' else 'levels'}"
    if found.noisy:
        numbers["means"] = relative_means(found.our_radiance, found.their_radiance)
    return {f"{name}_{key}": value for key, value in numbers.items()}


def relative_means(ours: np.ndarray, theirs: np.ndarray) -> str:
    """Return how far our mean radiance lies from Mitsuba's, and the standard error of that, as per cent.

    The error is that of the mean of squares' differences, of which neighbours are almost independent.
    """
    apart = testsuite.blocks(ours - theirs).mean(-1)[:: testsuite.BLOCK, :: testsuite.BLOCK]
    scale = 100 / theirs.mean()
    error = scale * apart.std(ddof=1) / np.sqrt(apart.size)
    return f"{digits(float(scale * apart.mean()), 2)} \u00b1 {unit(float(error), '%', 1)}"


def write(path: Path, shown: np.ndarray, noisy: bool) -> None:
    """Write a picture in [0, 1] as JPEG where it is noisy and as PNG else; the path has no ending yet."""
    image = testsuite.image_of(shown)
    if noisy:
        image.save(f"{path}.jpg", quality=testsuite.QUALITY)
    else:
        image.save(f"{path}.png", optimize=True)
