"""Where the pictures of one render go: several files of several formats, or standard output.

All places are checked before any work is done, so that an hour of rendering is not lost to a typing mistake.
"""

import os
import sys
from contextlib import contextmanager
from dataclasses import dataclass

from renderer.core.errors import RenderError, UsageError
from renderer.io import image
from renderer.io.files import check_writable, reason

STANDARD_OUTPUT = "-"
EXTENSIONS = (".ppm", ".png", ".exr")


@dataclass(frozen=True)
class Grading:
    """How radiance becomes 8 bits: None takes what the scene says, or its mode; `encoding` is `linear` or `srgb`."""

    tonemap: str | None = None
    exposure: float | None = None
    encoding: str | None = None


def check(paths, inputs=(), what="the scene"):
    """Return nothing if a picture can be written to every one of `paths`; nothing is written.

    Raises: UsageError for a path that has an unknown extension, is not writable, is given twice, or is one of the
    files `inputs` that `what` is read from; the message names all of them.
    """
    mistakes, seen, inputs = [], set(), {os.path.realpath(file) for file in inputs}
    for path in paths:
        place = path if path == STANDARD_OUTPUT else os.path.realpath(path)
        if place in seen:
            mistakes.append(f"{name(path)}: this output is given twice")
            continue
        seen.add(place)
        try:
            if place in inputs:
                raise UsageError(f"{path}: {what} is read from this file; choose another output")
            _check_one(path)
        except UsageError as error:
            mistakes.append(str(error))
    if mistakes:
        raise UsageError("\n".join(mistakes))


def write_all(paths, rendering, grading, header):
    """Write the pictures, each whole or not at all; `header` is the text that EXR files carry along.

    A failure does not keep the others from being written.

    Raises: RenderError naming every file that could not be written and why.
    """
    failures, rgb8 = [], None
    for path in paths:
        try:
            if is_exr(path):
                image.write_exr(path, rendering.channels(beside=True), header)
                continue
            if rgb8 is None:
                rgb8 = rendering.rgb8(grading.tonemap, grading.exposure, grading.encoding)
            if path == STANDARD_OUTPUT:
                with standard_output() as stream:
                    stream.write(image.ppm_header(rendering.width, rendering.height))
                    stream.write(rgb8)
            elif _extension(path) == ".png":
                image.write_png(path, rgb8, rendering.width, rendering.height)
            else:
                image.write_ppm(path, rgb8, rendering.width, rendering.height)
        except RenderError as error:
            failures.append(str(error))
    if failures:
        raise RenderError("\n".join(failures))


@contextmanager
def standard_output():
    """Yield standard output as a binary stream, flushed when the block ends.

    Raises: UsageError if it is closed, RenderError if it cannot take what is written, BrokenPipeError if its reader
    has gone.
    """
    if sys.stdout is None:
        raise UsageError("standard output is closed")
    try:
        sys.stdout.flush()
        # Not sys.stdout.buffer: with PYTHONUNBUFFERED that may write less than it is given.
        with open(sys.stdout.fileno(), "wb", closefd=False) as stream:
            yield stream
    except BrokenPipeError:
        raise
    except OSError as error:
        raise RenderError(f"standard output: cannot be written: {reason(error)}") from error


def is_exr(path):
    """Return whether a path is that of an EXR, which holds more than the colour."""
    return _extension(path) == ".exr"


def name(path):
    """Return a path as messages call it."""
    return "standard output" if path == STANDARD_OUTPUT else path


def _extension(path):
    return os.path.splitext(path)[1].lower()


def _check_one(path):
    """Raise UsageError if no picture can be written to `path`."""
    if path == STANDARD_OUTPUT:
        if sys.stdout is None:
            raise UsageError("standard output is closed")
        if sys.stdout.isatty():
            raise UsageError("standard output is a terminal: send it to a file or a program, or use -o FILE")
        return
    if os.path.isdir(path):
        raise UsageError(f"{path}: cannot be written: it is a folder")
    if _extension(path) not in EXTENSIONS:
        raise UsageError(f"{path or '(empty)'}: unknown picture format; the name must end in {', '.join(EXTENSIONS)}")
    check_writable(path)
