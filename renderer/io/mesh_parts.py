"""What the readers of mesh files have in common."""

from __future__ import annotations

import numpy as np

# Vertices may not be beyond this in size, as all lengths in a scene file: squares of them must fit a float32.
LARGEST = 1e18
LEAST_CORNERS = 3  # of a face
SHOWN = 40  # characters of a file's word that a message quotes


class Malformed(Exception):
    """What is wrong with a mesh file, and in a text file where (0: unknown)."""

    def __init__(self, message, line=0, column=0):
        super().__init__(message)
        self.line, self.column = line, column


def fans(indices, counts):
    """Return the triangles (F, 3) of polygons: `indices` are their corners one after the other, `counts` (P,) >= 3.

    Each polygon is a fan around its first corner, in the order of the file.
    """
    if not len(counts):
        return np.empty((0, 3), np.int64)
    if (counts == counts[0]).all():
        corners = indices.reshape(-1, counts[0])
        first = np.broadcast_to(corners[:, :1], (len(corners), counts[0] - 2))
        return np.stack([first, corners[:, 1:-1], corners[:, 2:]], -1).reshape(-1, 3)
    starts = np.cumsum(counts) - counts
    triangles = counts - 2
    first = np.repeat(starts, triangles)
    step = np.arange(triangles.sum()) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack([indices[first], indices[first + step + 1], indices[first + step + 2]], -1)


def as_number(word):
    """Return a word of a file (bytes) as a float, None if it is no number; 1_000 is one in Python alone."""
    try:
        return None if b"_" in word else float(word)
    except ValueError:
        return None


def shown(word):
    """Return a word of a file (bytes) in quotes, readable and short."""
    text = repr(word[:SHOWN].decode("latin-1"))
    return text if len(word) <= SHOWN else text[:-1] + "...'"
