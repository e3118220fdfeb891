"""Quantities that keys of the scene file stand for: ranges and words, shared by the records of schema and materials."""

from __future__ import annotations

from renderer.scene.composed import OneOf, Record, Texturable, TextureSource
from renderer.scene.nodes import Node, key, node
from renderer.scene.values import Choice, Number, Vector

REAL = Number()
POSITIVE = Number(low=0.0, low_open=True)
NON_NEGATIVE = Number(low=0.0)
FRACTION = Number(low=0.0, high=1.0)
DEGREES = Number(low=0.0, high=180.0, low_open=True, high_open=True)
POINT = Vector(3, REAL, "a point [x, y, z]")
DIRECTION = Vector(3, REAL, "a direction [x, y, z]")
UV = Vector(2, REAL, "texture coordinates [u, v]")
COLOUR = Vector(3, NON_NEGATIVE, "a colour [r, g, b]")
HALF_SPACE = Vector(4, REAL, "a half-space [nx, ny, nz, d]")
REFLECTANCE = Vector(3, FRACTION, "a reflectance [r, g, b]")
BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
LENGTH = "scene units"


def kind(name):
    """Return the declaration of a `type` key that must read `name`."""
    return key(Choice("type", (name,)), f'`"{name}"`', default=name, required=True)


@node
class Checkerboard(Node):
    """Two colours in squares; `scale` squares along each texture axis."""

    type: str = kind("checkerboard")
    color1: tuple = key(COLOUR, "colour of the square at uv = (0, 0)", default=BLACK)
    color2: tuple = key(COLOUR, "colour of its neighbours", default=WHITE)
    scale: float = key(POSITIVE, "squares along each axis for uv from 0 to 1", default=8.0)


TEXTURE = TextureSource(OneOf("texture", {"checkerboard": Record(Checkerboard)}))
TEXTURABLE_REFLECTANCE = Texturable(REFLECTANCE, TEXTURE)
TEXTURABLE_FRACTION = Texturable(FRACTION, TEXTURE)
