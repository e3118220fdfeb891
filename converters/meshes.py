"""Mesh files as Mitsuba's own `ply` and `obj` plugins load them: which settings give the scene format's mesh.

Mitsuba reads the file itself. Only what it needs to be told is looked up here: whether a file has vertex normals, and
where the mesh goes. Measured with Mitsuba 3.9.1:

- `face_normals` drops the vertex normals. Without it those of the file count, and where it has none they are computed,
  weighted by angle; a file's normals cannot be ignored in favour of computed ones.
- A mirroring `to_world` turns triangles inside out, and with them computed normals, but not those of a file.
  `flip_normals` turns both. Normals of a file must therefore be negated beforehand.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from converters.geometry import unit

HEADER = 2**16  # bytes: the header of a PLY file ends well before
CORNER_WITH_NORMAL = re.compile(rb"^\s*f\s+-?\d+/-?\d*/-?\d", re.MULTILINE)


@dataclass(frozen=True)
class MeshFile:
    """A mesh file and how it is used."""

    path: Path
    normals: str  # of the scene format: "file", "smooth" or "flat"
    has_normals: bool  # whether the file brings vertex normals
    to_world: np.ndarray  # (4, 4) float64

    @property
    def plugin(self):
        """The Mitsuba plugin that reads the file."""
        return self.path.suffix.lower().lstrip(".")

    @property
    def flat(self):
        """Whether triangles have their own normals."""
        return self.normals == "flat" or self.normals == "file" and not self.has_normals

    @property
    def mirrored(self):
        """Whether the transformation turns the mesh inside out."""
        return bool(np.linalg.det(self.to_world) < 0)

    @property
    def drops_normals(self):
        """Whether Mitsuba must not see the file's normals, so that it computes some."""
        return self.normals == "smooth" and self.has_normals

    @property
    def negates_normals(self):
        """Whether Mitsuba must see the file's normals negated, because `flip_normals` negates them once more."""
        return self.normals == "file" and self.has_normals and self.mirrored

    @property
    def settings(self):
        """The plugin's parameters besides the file name."""
        return {"to_world": self.to_world, "face_normals": self.flat, "flip_normals": self.mirrored}


def mesh_file(shape, resolve):
    """Return the MeshFile of a mesh shape of the description; `resolve` gives the path of a file that it names."""
    path = Path(resolve(shape.filename))
    return MeshFile(path, shape.normals, _has_normals(path), placement(shape.transform))


def placement(steps):
    """Return the (4, 4) float64 matrix of transformation steps, which are applied in their order."""
    result = np.eye(4)
    for step in steps:
        this = np.eye(4)
        if step.translate is not None:
            this[:3, 3] = step.translate
        elif step.scale is not None:
            this[:3, :3] = np.diag(step.scale)
        elif step.rotate is not None:
            turn = np.radians(step.rotate.angle) * unit(step.rotate.axis)
            this[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
        else:
            this = np.reshape(step.matrix, (4, 4))
        result = this @ result
    return result


def _has_normals(path):
    """Return whether a PLY or OBJ file gives normals to its vertices."""
    data = path.read_bytes()
    if path.suffix.lower() == ".obj":
        return CORNER_WITH_NORMAL.search(data) is not None
    return re.search(rb"^property \S+ nx\s*$", data[:HEADER].partition(b"end_header")[0], re.MULTILINE) is not None
