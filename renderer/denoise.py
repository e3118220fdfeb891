"""Noise taken out of a finished picture by Intel's Open Image Denoise, guided by what the pixels' middles show.

The library is an extra (`requirements/denoise.txt`). Its package `mitsuba_oidn` is so called after those who pack it,
and neither needs nor contains Mitsuba. A denoised picture looks better than it is: what is smooth may be invented. It
is for looking at, not for measuring.
"""

from renderer.core.errors import RenderError, UsageError
from renderer.extras import install_command


def load():
    """Return the library, before any work is done. Raises UsageError where it is not installed."""
    try:
        import mitsuba_oidn
    except ImportError as error:
        raise UsageError(
            f"--denoise needs a library that is not installed: {install_command('denoise')} ({error})"
        ) from error
    return mitsuba_oidn


def denoised(rendering):
    """Return the Rendering with less noise; raises RenderError where the library fails.

    Albedo and normals are those of single rays, free of noise, so the library may take their edges for true: over
    scenes with and without textures that halved the error or left it as it was without them.
    """
    import numpy as np

    library, channels = load(), rendering.channels(beside=True)

    def picture(*names):
        return np.ascontiguousarray(np.stack([channels[name] for name in names], -1), dtype=np.float32)

    try:
        colour = library.denoise(
            picture(*"RGB"), picture("Albedo.R", "Albedo.G", "Albedo.B"), picture("N.X", "N.Y", "N.Z"),
            hdr=True, clean_aux=True,
        )
    except Exception as error:  # the binding has no class of its own for them
        raise RenderError(f"the picture cannot be denoised: {error}") from error
    return rendering.with_colour(colour)
