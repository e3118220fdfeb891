"""A hierarchy that is none: it keeps a known number of bytes a triangle, and needs more of them for a while.

So does its mesh, which is made beforehand and not counted.
"""

import numpy as np

KEPT, FOR_A_WHILE = 64, 128  # bytes a triangle
MESH, FOR_THE_MESH = 100, 400


def mesh_of(vertices, faces):
    """Return what `build` takes."""
    for_a_while = np.full(FOR_THE_MESH * len(faces), 1, np.uint8)
    return np.full((len(faces), MESH), for_a_while[0], np.uint8)


def build(mesh):
    """Return ones, not zeros, so that they are resident."""
    for_a_while = np.full(FOR_A_WHILE * len(mesh), 1, np.uint8)
    return np.full(KEPT * len(mesh), for_a_while[0], np.uint8)
