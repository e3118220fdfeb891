"""The validated scene with its place on disk: what the loader hands to the renderer and to the converters."""

from __future__ import annotations

from dataclasses import dataclass, field
from os.path import isfile
from pathlib import Path

from renderer.core.errors import Problem, SceneError
from renderer.scene import schema
from renderer.scene.source import Source


@dataclass(frozen=True)
class LoadedScene:
    """A description that passed every check.

    `shapes` holds `(index in the file, shape)` for what is rendered: degenerate shapes were dropped with a warning,
    so that indices in messages and in the shape-number picture stay those of the file.
    Texture file names in the description are as written; `resolve` turns them into paths.
    """

    path: str  # as the user wrote it
    directory: Path  # textures are relative to it
    description: schema.Scene
    shapes: tuple[tuple[int, schema.Shape], ...]
    warnings: tuple[Problem, ...]  # and notes
    source: Source = field(repr=False, compare=False)  # turns a path of keys into a place in the file

    def refused(self, error, *path):
        """Return the SceneError about a file, told at the place of the scene (keys of `path`) that names it."""
        return SceneError(self.source.problem("; ".join(map(str, error.problems)), *path))

    def resolve(self, filename):
        """Return the path of a file that the scene names."""
        return resolve(self.directory, filename)


def resolve(directory, filename):
    """Return the path of a file named in a scene file of `directory`.

    Names are relative to that directory. Where that leads nowhere, a folder `textures` beside the scene file and
    backslashes as separators are tried too, because scenes in circulation are written that way.
    """
    asked = directory / filename
    if isfile(asked):  # unlike Path.is_file, it does not raise where a name is too long
        return asked
    slashed = filename.replace("\\", "/")
    for candidate in (directory / slashed, directory / "textures" / slashed):
        if isfile(candidate):
            return candidate
    return asked
