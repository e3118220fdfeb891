"""Turned things for our scenes: profiles, and meshes around +y with smooth normals."""

import math

import numpy as np

AROUND = 96  # corners of a mesh on a circle


def curve(points, pieces=6):
    """Return a Catmull-Rom curve through (M, 2) points, with so many pieces between two of them; ends are kept."""
    points = np.asarray(points, float)
    padded = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    t = (np.arange(pieces) / pieces)[:, None]
    spans = [0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)
             for a, b, c, d in zip(padded, padded[1:], padded[2:], padded[3:])]
    return np.vstack([*spans, points[-1:]])


def thick(outer, wall, floor):
    """Return the closed profile of a vessel, from the axis below to the axis above its floor.

    `outer` is the profile (M, 2) from the foot's edge to the rim, `wall` its thickness, `floor` its floor's height.
    """
    along = np.gradient(outer, axis=0)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)
    inner = outer + wall * across
    inner = inner[inner[:, 1] > floor + 0.6 * wall][::-1]
    angle = np.linspace(0, math.pi, 9)[1:-1, None]
    middle, half = (outer[-1] + inner[0]) / 2, (outer[-1] - inner[0]) / 2
    up = np.array([-half[1], half[0]])
    rim = middle + half * np.cos(angle) + up * np.sin(angle)
    edge = inner[-1, 0]
    well = [(edge * s, floor + (inner[-1, 1] - floor) * s**6) for s in (0.93, 0.8, 0.6, 0.35, 0.0)]
    foot = [(outer[0, 0] * s, outer[0, 1]) for s in (0.0, 0.5, 0.9)]
    return np.vstack([foot, outer, rim, inner, well])


def turned(profile, around=AROUND):
    """Return vertices, normals (V, 3), uv (V, 2) and triangles (T, 3) of a profile turned around +y.

    Normals point to the right of the profile's direction: outwards where it runs from the axis below upwards. u runs
    around with a seam, v along the profile.
    """
    profile = np.asarray(profile, float)
    along = np.gradient(profile, axis=0)
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    across[profile[:, 0] == 0, 0] = 0
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    angle = 2 * math.pi * (np.arange(around + 1) % around) / around
    turn = np.stack([np.cos(angle), np.zeros(around + 1), np.sin(angle)], axis=1)
    up = np.array([0.0, 1.0, 0.0])
    points = profile[:, None, :1] * turn + profile[:, None, 1:] * up
    normals = across[:, None, :1] * turn + across[:, None, 1:] * up
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    uv = np.stack(np.broadcast_arrays((np.arange(around + 1) / around)[None], (length / length[-1])[:, None]), axis=-1)
    corner = np.arange(len(profile) * (around + 1)).reshape(len(profile), around + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]
    lower, upper = np.stack([a, c, b], -1)[profile[:-1, 0] > 0], np.stack([b, c, d], -1)[profile[1:, 0] > 0]
    triangles = np.vstack([lower.reshape(-1, 3), upper.reshape(-1, 3)])
    return points.reshape(-1, 3), normals.reshape(-1, 3), uv.reshape(-1, 2), triangles
