"""Normal maps and bump maps: the shading frame of a surface whose texture tells which way it faces.

A normal map gives the normal in the frame (t, b, n) of the shading normal with t along dp_du. A bump map gives heights
h along the shading normal n: its normal is that of the moved surface p + h n, dp_du + n (dh/du - n.dp_du) crossed with
the same by v, where what h changes by how n bends is left out [Blinn1978]. Both as in Mitsuba.

Directions on different sides of the surface's and of the map's normal are not possible: their light must not count.
"""

from __future__ import annotations

import drjit as dr

from renderer.core.backend import Float, Vector2f, Vector3f
from renderer.core.frame import Frame
from renderer.core.numeric import TINY, greater
from renderer.scene.texturing import AS_WRITTEN, use_of

FLAT = (0.5, 0.5, 1.0)  # what a normal map holds where there is none


class Relief:
    """The maps of a scene's shapes, by their number in the compiled order."""

    def __init__(self, texturing, materials):
        """Hold the maps that the Materials of the shapes name, which `texturing` has read."""
        self._normals = texturing.slot([use_of(material, material, "normalmap") for material in materials], AS_WRITTEN)
        bumps = [use_of(material, material, "bumpmap") for material in materials]
        self._heights = texturing.heights(bumps, [material.bumpscale for material in materials])

    @property
    def flat(self):
        """Whether no shape has a map, so that nothing needs to be asked."""
        return self._normals is None and self._heights is None

    def frame(self, shape, surface, active):
        """Return the shading frame of each lane's surface (with uv and tangents), t along dp_du.

        Where a shape has both maps, the heights count on top of the mapped normal.
        """
        frame = Frame.along(surface.n_shade, surface.dp_du)
        if self._normals is not None:
            value = self._normals.value(self._normals.rows.row(shape, active), surface.uv, active, Vector3f(*FLAT))
            local = dr.fma(value, 2, -1)
            n = frame.to_world(local * dr.rsqrt(greater(dr.squared_norm(local), Float(TINY))))
            frame = Frame.along(n, surface.dp_du)
        if self._heights is not None:
            slope = self._heights.value(self._heights.rows.row(shape, active), surface.uv, active, Vector2f(0))
            frame = Frame.along(bumped(frame.n, surface, slope), surface.dp_du)
        return frame


def bumped(n, surface, slope):
    """Return the normal of a surface moved along its shading normal n by heights with the derivatives `slope` by uv.

    The normal is turned to the side of n.
    """
    along_u, along_v = (dr.fma(n, slope[axis] - dr.dot(n, tangent), tangent)
                        for axis, tangent in enumerate((surface.dp_du, surface.dp_dv)))  # fmt: skip
    across = dr.cross(along_u, along_v)
    across *= dr.rsqrt(greater(dr.squared_norm(across), Float(TINY)))
    return dr.select(dr.dot(across, n) < 0, -across, across)
