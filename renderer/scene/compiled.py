"""The scene as a kernel sees it: what is asked of it in lanes, with only the kinds that it has compiled in.

Tables are by shape, in the compiled order of tables.py.
"""

from __future__ import annotations

from dataclasses import dataclass

from renderer.core.rows import Rows
from renderer.lights.base import LightKind
from renderer.lights.environment import Environment
from renderer.scene.geometry import Geometry
from renderer.scene.texturing import Slot

# columns of the material records
DIFFUSE, KD, SPECULAR, EXPONENT, SHARE, GLASS, ETA, ALPHA = 0, 3, 4, 7, 8, 9, 10, 11


@dataclass(frozen=True)
class LightGroup:
    """All lights of one kind."""

    kind: LightKind
    rows: Rows


@dataclass(frozen=True)
class CompiledScene(Geometry):
    """The geometry of a scene, its lights, and what it looks like; see the module docstring."""

    lights: tuple[LightGroup, ...]
    world: Rows  # one record: backgroundcolor, ambientlight
    looks: Rows | None  # by shape: its place in the next two; None where that is the shape's own number
    materials: Rows | None  # None without shapes
    texture: Slot | None  # in the place of diffuse colours; None where nothing is textured
    file_indices: Rows | None  # by shape: its place in the file
    has_mirrors: bool
    has_glass: bool
    has_rough_mirrors: bool  # with a material column ALPHA
    environment: Environment | None  # image of what is behind everything; None for a colour
    random: bool  # whether samples differ by more than their place in the pixel: lamps are more than points

    def behind(self, d):
        """Return the colour of what is behind everything in a direction."""
        return self.world[0].vector(0) if self.environment is None else self.environment.radiance(d)[0]

    @property
    def ambient(self):
        """Light from everywhere."""
        return self.world[0].vector(3)

    @property
    def light_count(self):
        """Number of lights."""
        return sum(group.rows.count for group in self.lights)

    def _look(self, hit):
        """Return the place of each hit's records in the tables of materials and textures."""
        shape = self.shape_of(hit)
        return shape if self.looks is None else self.looks.row(shape, hit.valid)[0]

    def material(self, hit):
        """Return the material record of each hit, in the columns above."""
        return self.materials.row(self._look(hit), hit.valid)

    def file_index(self, hit):
        """Return the place in the file of each hit's shape."""
        return self.file_indices.row(self.shape_of(hit), hit.valid)[0]

    def diffuse_colour(self, hit, surface, material):
        """Return the texture's colour where there is one, else the material's."""
        colour = material.vector(DIFFUSE)
        if self.texture is None:
            return colour
        row = self.texture.rows.row(self._look(hit), hit.valid)
        return self.texture.value(row, surface.uv, hit.valid, colour)
