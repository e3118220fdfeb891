"""Plastic: light that goes back and forth between coat and base.

A white base under a coat that absorbs nothing reflects all light. It does so only if the coat's mean reflectance from
inside is the one that belongs to its Fresnel factor: of dense coats all but a hundredth comes back, and what is wrong
in the third digit is multiplied by a hundred. Indices run from 1.05 to 20.
"""

import functools

import numpy as np

from renderer.scene.materials import Plastic
from tests.stability.case import ULP, Case
from tests.stability.fresnel import exact
from tests.stability.rough import evaluated, theirs

INDICES = 1.05, 1.33, 1.5, 1.8, 2.4, 3.0, 5.0, 20.0
COSINES = 0.02, 0.1, 0.3, 0.6, 1.0
NODES = 128


@functools.cache
def outgoing():
    """Return float32 directions (N, 3), and the solid angle of each: the cosine by Gauss and Legendre."""
    t, weight = np.polynomial.legendre.leggauss(NODES)
    cos = ((t + 1) / 2).astype(np.float32).astype(float)
    return np.c_[np.sqrt((1 - cos) * (1 + cos)), 0 * cos, cos].astype(np.float32), weight * np.pi


def lost(value):
    """Return by how much the albedo differs from 1: the coat's Fresnel factor and the base; value(ior, wi, wo)."""
    wo, area = outgoing()
    found = []
    for ior in INDICES:
        for cos in COSINES:
            wi = np.array([[np.sqrt((1 - cos) * (1 + cos)), 0, cos]], np.float32)
            coat = exact(wi[:, 2], np.array([ior], np.float32))[0][0]
            found.append(coat + value(ior, np.repeat(wi, NODES, 0), wo).astype(float) @ area - 1)
    return found


def ours(ior, wi, wo):
    """Return the renderer's value times cosine."""
    return evaluated(Plastic(ior=ior, reflectance=(1.0, 1.0, 1.0)), wi, wo)[0]


def textbook(ior, wi, wo):
    """Return the same with the usual fit of the mean reflectance from inside [Egan1973]."""
    eta = 1 / ior
    inside = -1.4399 * eta**2 + 0.7099 * eta + 0.6681 + 0.0636 / eta
    passed = [1 - exact(w[:, 2], np.full(len(w), ior, np.float32))[0] for w in (wi, wo)]
    return passed[0] * passed[1] * wo[:, 2] / (np.pi * ior**2 * (1 - inside))


def plugin(ior, wi, wo):
    """Return Mitsuba's value times cosine."""
    made = {"type": "plastic", "int_ior": ior, "ext_ior": 1.0, "nonlinear": False,
            "diffuse_reflectance": {"type": "rgb", "value": 1.0}}  # fmt: skip
    return theirs(made, wi, wo)[0] * np.ones(len(wi))


CASES = (
    Case("furnace of white plastic, index 1.05 to 20", "share of light", 16 * ULP,
         "16 roundings: two complements of F, cosine, factor and sum",
         lambda: lost(ours), lambda: lost(textbook), "the fit of [Egan1973] for the mean reflectance from inside",
         lambda: lost(plugin)),
)
