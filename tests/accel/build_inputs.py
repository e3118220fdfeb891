"""Boxes to build hierarchies over, what a hierarchy costs, and a plain builder that tries every split as yardstick."""

import numpy as np

from renderer.core.backend import Float, Vector3f


def vector(points):
    """Return host points, (N, 3), as lanes."""
    return Vector3f(*(Float(np.ascontiguousarray(points[:, axis], np.float32)) for axis in range(3)))


def _bounds(triangles):
    return triangles.astype(np.float32).min(1), triangles.astype(np.float32).max(1)


def _surface_triangles(count):
    rows = int(round(np.sqrt(count / 4)))
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 2 * rows, endpoint=False), np.linspace(0.02, np.pi - 0.02, rows + 1))
    radius = 1 + 0.15 * np.sin(7 * u) * np.sin(5 * v) + 0.05 * np.sin(23 * u + 3) * np.sin(19 * v)
    radius += 0.02 * np.cos(61 * u) * np.sin(57 * v)
    points = radius[..., None] * np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], -1)
    here, below = points[:-1], points[1:]
    quads = here, below, np.roll(below, -1, 1), np.roll(here, -1, 1)
    corners = [np.stack([quads[0], quads[k], quads[k + 1]], -2).reshape(-1, 3, 3) for k in (1, 2)]
    return np.concatenate(corners)


def surface(count):
    """Return the bounds of triangles of a closed surface with bumps of three sizes."""
    return _bounds(_surface_triangles(count))


def soup(count):
    """Return the bounds of small triangles, anywhere and any way round, in a cube."""
    rng = np.random.default_rng(1)
    size = 1.5 * count ** (-1 / 3)
    return _bounds(rng.random((count, 1, 3)) + size * (rng.random((count, 3, 3)) - 0.5))


def stadium(count):
    """Return the bounds of a fine mesh among 200 triangles a hundred times its size."""
    rng = np.random.default_rng(2)
    fine = _surface_triangles(count - 200) * 0.01 + [0.3, 0.2, 0.1]
    return _bounds(np.concatenate([fine, rng.random((200, 1, 3)) * 10 - 5 + 4 * (rng.random((200, 3, 3)) - 0.5)]))


def needles(count):
    """Return the bounds of triangles a hundred times as long as wide."""
    rng = np.random.default_rng(3)
    along, centre = rng.normal(size=(count, 3)), rng.random((count, 3))
    length = 8 * count ** (-1 / 3)
    along *= length / np.linalg.norm(along, axis=1, keepdims=True)
    across = rng.normal(size=(count, 3)) * length * 0.01
    return _bounds(np.stack([centre - along / 2, centre + along / 2, centre + along / 2 + across], 1))


INPUTS = {"surface": surface, "soup": soup, "stadium": stadium, "needles": needles}


def half_areas(lo, hi):
    """Return half the surface areas of boxes, (..., 3) each."""
    x, y, z = np.moveaxis(hi.astype(np.float64) - lo.astype(np.float64), -1, 0)
    return x * y + y * z + z * x


def cost(tree):
    """Return how many inner nodes of a Tree a random ray through the scene visits."""
    areas = half_areas(np.array(tree.lo).T, np.array(tree.hi).T)
    return areas[np.array(tree.child_count) > 0].sum() / areas[0]


def yardstick_cost(lo, hi, width):
    """Return what the cheapest hierarchy made of a full-sweep builder's binary one costs."""
    children, areas = _sweep(lo.astype(np.float64), hi.astype(np.float64))
    costs = np.zeros((len(areas), width - 1))
    none = np.zeros(width - 1)
    for node in reversed(range(len(areas))):
        left, right = (costs[child] if child >= 0 else none for child in children[node])
        splits = [min(left[j - 1] + right[k - j - 1] for j in range(1, k)) for k in range(2, width + 1)]
        costs[node] = np.minimum.accumulate([areas[node] + splits[-1], *splits[:-1]])
    return costs[0, 0] / areas[0]


def _sweep(lo, hi):
    """Return children (inner nodes, -1 for primitives) and areas of a binary tree; parents precede their children."""
    children, areas = [], []
    waiting = [(np.arange(len(lo)), None, 0)]
    while waiting:
        members, parent, side = waiting.pop()
        if parent is not None:
            children[parent][side] = len(areas) if len(members) > 1 else -1
        if len(members) == 1:
            continue
        areas.append(half_areas(lo[members].min(0), hi[members].max(0)))
        children.append([-1, -1])
        node = len(areas) - 1
        waiting += [(part, node, side) for side, part in enumerate(_cheapest_split(members, lo, hi))]
    return children, np.array(areas)


def _cheapest_split(members, lo, hi):
    """Return the two parts with the least area times number, over all three orders of the centres."""
    counts = np.arange(1, len(members))
    best = np.inf, None
    for axis in range(3):
        order = members[np.argsort(lo[members, axis] + hi[members, axis], kind="stable")]
        forward = half_areas(np.minimum.accumulate(lo[order]), np.maximum.accumulate(hi[order]))[:-1]
        backward = half_areas(np.minimum.accumulate(lo[order[::-1]]), np.maximum.accumulate(hi[order[::-1]]))[-2::-1]
        costs = forward * counts + backward * counts[::-1]
        cut = int(costs.argmin())
        if costs[cut] < best[0]:
            best = costs[cut], (order[: cut + 1], order[cut + 1:])
    return best[1]
