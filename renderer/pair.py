"""A picture and its reference, read from files and brought into one domain, in which they can be compared.

EXR and HDR hold linear radiance. PPM, PNG and JPEG hold what is shown of it: exposed, through a tone curve, clipped,
encoded, in 8 bits. Of two pictures of one sort nothing has to be undone. Radiance that meets 8 bits is brought there as
the renderer would write it, rounding included, so that both files of one render are equal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from renderer import compare
from renderer.core import srgb
from renderer.core.errors import Problem, SceneError, UsageError
from renderer.core.tones import NEUTRAL_EXPOSURE, shown
from renderer.io.image import read_picture
from renderer.scene.schema import SHADED_MODES

WHITE = 255  # the greatest 8-bit value
NEUTRAL = {"exposure": NEUTRAL_EXPOSURE, "tonemap": "linear", "encoding": "linear"}  # of pictures that show no light
ASSUMED = {"exposure": NEUTRAL_EXPOSURE, "tonemap": "linear", "encoding": "srgb"}  # of files that do not tell
NAMES = {"exposure": "exposure", "tonemap": "tone map", "encoding": "encoding"}


@dataclass(frozen=True)
class Look:
    """How radiance is shown, and where each of the three settings comes from."""

    exposure: float
    tonemap: str
    encoding: str
    origins: dict[str, str]

    def shown(self, radiance):
        """Return what is seen of some rows of radiance, in [0, 1]."""
        scale = self.exposure / NEUTRAL_EXPOSURE
        return shown(np.asarray(radiance, np.float64) * scale, self.tonemap, self.encoding, np.where)

    def in_words(self, names=tuple(NAMES)):
        """Return settings with their origins: `exposure 0.2 (--exposure), tone map linear (assumed)`."""
        values = {"exposure": f"{self.exposure:g}", "tonemap": self.tonemap, "encoding": self.encoding}
        parts = []
        for place, name in enumerate(names):
            last = place + 1 == len(names) or self.origins[names[place + 1]] != self.origins[name]
            parts.append(f"{NAMES[name]} {values[name]}" + f" ({self.origins[name]})" * last)
        return ", ".join(parts)


@dataclass(frozen=True)
class Pair:
    """Two pictures of one size, both uint8 or both float32 radiance; `domain` says in words how they came to be so."""

    picture: np.ndarray
    reference: np.ndarray
    look: Look
    used: tuple[str, ...]  # settings of the look that matter
    domain: str

    @property
    def is_radiance(self):
        """Return whether the pictures hold radiance."""
        return self.picture.dtype != np.uint8

    @property
    def height(self):
        """Return the number of rows."""
        return self.picture.shape[0]

    @property
    def width(self):
        """Return the number of columns."""
        return self.picture.shape[1]

    def linear(self):
        """Return both in what is proportional to light: radiance, or shares of white."""
        if self.is_radiance:
            return self.picture, self.reference
        values = np.array(srgb.BYTES) if self.look.encoding == "srgb" else np.arange(WHITE + 1) / WHITE
        return self._changed(lambda rows: values[rows])

    def seen(self):
        """Return both as they are seen, in [0, 1]; radiance is not rounded to 8 bits."""
        return self._changed(self.look.shown if self.is_radiance else lambda rows: rows / WHITE)

    def levels(self):
        """Return both as they are seen, in 8 bits."""
        return self._changed(lambda rows: _rounded(self.look, rows) if self.is_radiance else rows)

    def _changed(self, change):
        return compare.Rows(self.picture, change), compare.Rows(self.reference, change)


def read(options):
    """Return the Pair that a command line names.

    Raises: SceneError for a file that cannot be read, or has NaN or infinite values; UsageError for pictures of two
    sizes, and for settings of radiance where there is none.
    """
    paths = options.picture, options.reference
    (picture, header), (reference, other) = (_read_finite(path) for path in paths)
    if picture.shape != reference.shape:
        sizes = ["{1} x {0}".format(*side.shape) for side in (picture, reference)]
        raise UsageError(f"{paths[0]} has {sizes[0]} pixels, and {paths[1]} {sizes[1]}: "
                         "only pictures of one size can be compared")
    of_radiance = [path for path, side in zip(paths, (picture, reference)) if side.dtype != np.uint8]
    for name in ("exposure", "tonemap"):
        if getattr(options, name) is not None and not of_radiance:
            raise UsageError(f"--{name}: both pictures have 8 bits, and are compared as they are")
    look = look_of(options, {paths[1]: other, paths[0]: header})
    if len(of_radiance) == 2:
        domain = f"compared as radiance; seen with {look.in_words()}"
        return Pair(picture, reference, look, tuple(NAMES), domain)
    if not of_radiance:
        used = ("encoding",)
        domain = f"compared in 8 bits as they are; MSE and means are of light: {look.in_words(used)}"
        return Pair(picture, reference, look, used, domain)
    domain = f"compared in 8 bits; radiance of {of_radiance[0]} shown with {look.in_words()}"
    return Pair(_in_bytes(look, picture), _in_bytes(look, reference), look, tuple(NAMES), domain)


def look_of(options, headers):
    """Return the Look of a comparison: options come first, then headers {path: text} in their order, then ASSUMED."""
    values, origins = dict(ASSUMED), dict.fromkeys(ASSUMED, "assumed")
    for path, header in reversed(headers.items()):
        for name, value in _told(header).items():
            values[name], origins[name] = value, f"header of {path}"
    for name in ASSUMED:
        if getattr(options, name) is not None:
            values[name], origins[name] = getattr(options, name), f"--{name}"
    return Look(**values, origins=origins)


def _told(header):
    """Return the settings that an EXR of ours carries: those of its 8-bit twin."""
    if "renderer.mode" not in header:
        return {}
    if header["renderer.mode"] not in SHADED_MODES:
        return NEUTRAL
    told = {name: header.get(f"renderer.{name}") for name in ASSUMED}
    told["exposure"] = told["exposure"] and float(told["exposure"])
    return {name: value for name, value in told.items() if value is not None}


def _read_finite(path):
    """Return (pixels, header) of a file; raises SceneError where a pixel is NaN or infinite."""
    pixels, header = read_picture(path)
    if pixels.dtype != np.uint8 and (trouble := compare.not_finite(pixels)):
        raise SceneError(Problem(path, f"{trouble}; such a picture is at no distance from another"))
    return pixels, header


def _in_bytes(look, pixels):
    """Return radiance as the renderer writes it in 8 bits; what has 8 bits stays as it is."""
    if pixels.dtype == np.uint8:
        return pixels
    result = np.empty(pixels.shape, np.uint8)
    for rows in compare.bands(*pixels.shape[:2]):
        result[rows] = _rounded(look, pixels[rows])
    return result


def _rounded(look, radiance):
    return (look.shown(radiance) * WHITE + 0.5).astype(np.uint8)
