"""The scene as path tracing sees it: geometry, what surfaces do to light, and where light comes from."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import UInt32, Vector3f
from renderer.core.rows import Rows
from renderer.scene.arrange import AUTO, arrange
from renderer.scene.geometry import Geometry
from renderer.scene.lamps import with_lamps
from renderer.scene.lighting import Lighting
from renderer.scene.light_sources import emitters_of
from renderer.scene.media import exterior_indices
from renderer.scene.mirrors import Mirrors
from renderer.scene.scattering import Scattering
from renderer.scene.texturing import Texturing


@dataclass(frozen=True)
class PathScene(Geometry):
    """See the module docstring."""

    scattering: Scattering | None  # None without shapes
    lighting: Lighting
    mirrors: Mirrors | None  # that may show lamps; None where that is not worth a look
    roulette: bool  # whether long paths may end at random
    file_indices: Rows | None  # by shape: its place in the file

    def file_index(self, hit):
        """Return the place in the file of each hit's shape."""
        return self.file_indices.row(self.shape_of(hit), hit.valid)[0]

    def material(self, hit):
        """Return None: what surfaces are made of is asked for together with what they do to light."""
        return None

    def diffuse_colour(self, hit, surface, material):
        """Return the albedo of each hit, for pictures of first hits."""
        return self.scattering.albedo(self.shape_of(hit), surface, hit.valid) + dr.zeros(Vector3f, dr.width(hit.t))


def compile_paths(loaded, accel=AUTO):
    """Return the PathScene of a LoadedScene, its shapes in the structure that `accel` names (see arrange.py).

    Raises SceneError for files that cannot be read.
    """
    loaded = with_lamps(loaded)
    ordered, geometry = arrange(loaded, accel)
    shapes = [shape for _, shape in ordered]
    materials = [shape.material for shape in shapes]
    emitters = emitters_of(loaded.description.scene, ordered, geometry["triangles"])
    scattering = mirrors = None
    if shapes:
        scattering = Scattering(materials, exterior_indices(shapes, paths=True), Texturing(loaded, ordered))
        wanted = loaded.description.mirrorlight and loaded.description.nbounces > 1 and scattering.smooth
        if wanted and geometry["structure"] is None:
            mirrors = Mirrors.of(shapes, emitters)
    return PathScene(
        **geometry,
        scattering=scattering,
        lighting=Lighting.of(loaded, ordered, geometry["triangles"], emitters),
        mirrors=mirrors,
        roulette=loaded.description.roulette,
        file_indices=Rows([[index] for index, _ in ordered], UInt32) if shapes else None,
    )
