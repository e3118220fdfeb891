"""The scenes that are measured, and what the fastest public C++ solutions of the coursework make of them."""

from __future__ import annotations

import copy
import json

from benchmarks.measure import ROOT
from renderer.scene import loader

COURSEWORK = ("binary_primitives", "simple_phong", "scene", "mirror_image")
LIT = COURSEWORK[1:]  # those with lights and shading
# The fastest of eleven public solutions, each compiled with full optimisation: seconds wall for the whole process at
# 1200 x 800 with one sample a pixel, and the best throughput in million samples per CPU second.
PUBLIC_WALL = {"binary_primitives": 0.12, "simple_phong": 0.16, "scene": 0.36, "mirror_image": 0.25}
PUBLIC_THROUGHPUT = {"simple_phong": 16.5, "scene": 3.6, "mirror_image": 5.8}
GLASS = {"isrefractive": True, "refractiveindex": 1.5}


def path(name):
    """Return the file of a scene, relative to the checkout."""
    return f"scenes/{name}.json"


def load(name, effort, samples=1):
    """Return a LoadedScene in phong mode at the effort's size; `NAME glass` has glass in the place of mirrors."""
    name, _, glass = name.partition(" ")
    document = json.loads((ROOT / path(name)).read_text())
    loaded = loader.from_dict(_glazed(document) if glass else document, directory=ROOT / "scenes", mode="phong")
    return loader.override(loaded, width=effort.width, height=effort.height, samples=samples)


def _glazed(document):
    """Return the document with glass in its reflecting spheres; triangles stay mirrors, they enclose nothing."""
    document = copy.deepcopy(document)
    mirrors = [shape for shape in document["scene"]["shapes"] if shape["material"].get("isreflective")]
    spheres = [shape for shape in mirrors if shape["type"] == "sphere"]
    assert spheres, "without such a sphere the variant would be the scene itself"
    for shape in spheres:
        shape["material"].update(GLASS)
    return document
