"""The tree that an exported scene is: plain data, from which both the dictionary and the XML text are written."""

from __future__ import annotations

from dataclasses import dataclass, field


class Colour(tuple):
    """A linear RGB colour or spectrum-like value."""


class Point(tuple):
    """A position in world space."""


@dataclass(frozen=True)
class Pixels:
    """An 8-bit RGB image, rows from the top."""

    name: str  # file name stem for the XML's copy
    width: int
    height: int
    rgb: bytes


@dataclass(frozen=True)
class Environment:
    """An image of what is all around, and a factor of it."""

    path: str
    factor: tuple  # (3,)


@dataclass(frozen=True)
class Node:
    """One Mitsuba plugin: its family (the XML element), its type, and its parameters.

    Values are bool, int, float, str, Colour, Point, 3 x 3 or 4 x 4 arrays (transforms), Pixels, Environment,
    Mesh, MeshFile or Nodes.
    """

    family: str
    type: str
    values: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Plan:
    """A whole scene for Mitsuba, and what had to be replaced by a nearest counterpart, in words."""

    children: dict  # name -> Node
    warnings: tuple
