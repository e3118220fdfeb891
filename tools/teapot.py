"""`python -m tools.teapot`: cut the Utah teapot's patches into triangles, as scenes/meshes/teapot.ply.

The surface is a set of bicubic Bezier patches S(s, t) = sum_ij B_i(s) B_j(t) P_ij with normals along S_t x S_s. The
classic model is no closed solid: the lid lies in the mouth with a gap around it, and handle and spout are tubes
open at both ends, which the body hides at the inner ones. Every other edge has two triangles.

y points up and the pot stands on y = 0, in the units of the control points: 3.15 high, spout towards +x. Texture
coordinates run once around each part (u) and from its top, or start, to its end (v). Vertices are shared where
position and texture coordinates agree; elsewhere (u = 0 and 1, between parts) positions agree to the last bit.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from renderer.io import mesh_ply

MESHES = Path(__file__).resolve().parent.parent / "scenes" / "meshes"
DIVISIONS = 14  # of each edge of a patch: 364 kB
AROUND = {"rim": 4, "body": 4, "handle": 2, "spout": 2, "lid": 4, "bottom": 4}  # patches that make a ring
SAME_PLACE = 1e-5  # the least distance between control points is 0.03
DEGENERATE = 1e-9  # length of S_t x S_s: only where an edge of a patch is a point


def basis(x):
    """Return the cubic Bernstein polynomials and their derivatives at x: two lists of four arrays."""
    y = 1 - x
    values = [y * y * y, 3 * x * y * y, 3 * x * x * y, x * x * x]
    slopes = [-3 * y * y, 3 * y * y - 6 * x * y, 6 * x * y - 3 * x * x, 3 * x * x]
    return values, slopes


def patch(control, divisions):
    """Return positions and unit normals, (n + 1, n + 1, 3) each, of a patch with control points (4, 4, 3)."""
    s, t = np.meshgrid(*[np.arange(divisions + 1) / divisions] * 2, indexing="ij")
    (by_s, slope_s), (by_t, slope_t) = basis(s[..., None]), basis(t[..., None])

    def total(first, second):  # summed in a fixed order: the file has to come out the same on every machine
        return sum(first[i] * second[j] * control[i, j] for i in range(4) for j in range(4))

    along = total(slope_s, by_t)
    normals = cross(total(by_s, slope_t), along)
    lengths = np.sqrt((normals * normals).sum(-1, keepdims=True))
    # Where the edge s = 0 is a point, S_t vanishes like s S_st, and the normal's limit lies along S_st x S_s.
    limits = cross(total(slope_s, slope_t), along)
    normals = np.where(lengths > DEGENERATE, normals, limits)
    return total(by_s, by_t), normals / np.sqrt((normals * normals).sum(-1, keepdims=True))


def cross(a, b):
    """Return cross products along the last axis."""
    return a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]


def tessellate(teapot, divisions=DIVISIONS):
    """Return (vertices, faces, normals, uv) of the parsed data file, with y upwards."""
    control = np.array(teapot["vertices"], float)
    corners, positions, normals, uv = [], [], [], []
    for name, (first, count) in teapot["parts"].items():
        around = AROUND[name]
        for number in range(count):
            place, turned = patch(control[np.reshape(teapot["patches"][first + number], (4, 4))], divisions)
            v, u = np.meshgrid(*[np.arange(divisions + 1) / divisions] * 2, indexing="ij")
            ring, step = divmod(number, around)
            corners.append(len(positions) * (divisions + 1) ** 2 + squares(divisions))
            positions.append(place.reshape(-1, 3))
            normals.append(turned.reshape(-1, 3))
            uv.append(np.stack([(step + u) / around, (ring + v) * around / count], -1).reshape(-1, 2))
    upright = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # z up to y up, without a mirror
    positions, normals = ((np.concatenate(rows)[:, None, :] * upright).sum(-1) for rows in (positions, normals))
    return shared(positions, np.concatenate(corners), normals, np.concatenate(uv))


def squares(divisions):
    """Return the triangles (2 n^2, 3) of a patch's grid, counterclockwise seen from where S_t x S_s points."""
    a = (np.arange(divisions)[:, None] * (divisions + 1) + np.arange(divisions)).reshape(-1)
    b, c, d = a + 1, a + divisions + 2, a + divisions + 1
    return np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])


def shared(positions, faces, normals, uv):
    """Return (vertices, faces, normals, uv) with equal vertices made one, and triangles dropped that are lines."""
    places = number_of(positions, SAME_PLACE)
    first = np.unique(places, return_index=True)[1]
    positions = positions[first][places]  # equal to the last bit from here on
    kept = faces[[len({*row}) == 3 for row in places[faces].tolist()]]
    keys = np.stack([places, number_of(uv, SAME_PLACE)], -1)  # within a part the surface is smooth: so are the normals
    used = np.unique(kept)
    _, chosen, index = np.unique(keys[used], axis=0, return_index=True, return_inverse=True)
    chosen = used[chosen]
    new = np.empty(len(positions), np.int64)
    new[used] = index.reshape(-1)
    return positions[chosen], new[kept], normals[chosen], uv[chosen]


def number_of(rows, tolerance):
    """Return a number for each row (N,), the same for rows that differ by less than the tolerance in each column."""
    numbers = np.zeros(len(rows), np.int64)
    for column in rows.T:  # sorted, a step of more than the tolerance begins a new value
        order = np.argsort(column, kind="stable")
        values = np.empty(len(rows), np.int64)
        values[order] = np.cumsum(np.diff(column[order], prepend=column[order[0]]) > tolerance)
        numbers = np.unique(np.stack([numbers, values], -1), axis=0, return_inverse=True)[1].reshape(-1)
    return numbers


def main(arguments=None):
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("-o", "--output", default=MESHES / "teapot.ply", help="file to write (default: %(default)s)")
    parser.add_argument("-n", "--divisions", type=int, default=DIVISIONS, help="of each edge (default: %(default)s)")
    given = parser.parse_args(arguments)
    teapot = json.loads((MESHES / "teapot.json").read_text(encoding="utf-8"))
    mesh_ply.write(given.output, *tessellate(teapot, given.divisions), comments=[teapot["source"], teapot["licence"]])


if __name__ == "__main__":
    main()
