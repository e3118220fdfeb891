"""Figures and numbers of the title page and of the basic ray tracer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from renderer.integrators.phong import STACK_SIZE
from tools import testsuite
from tools.report import pairs
from tools.report.results import (
    ROOT, THIN, UNASKED, cost, digits, figure, hard_case, hard_share, machine, median, percent, picture_cost, row,
    seconds, table, unit, words,
)  # fmt: skip

COURSEWORK = ("binary_primitives", "simple_phong", "scene", "mirror_image")
FULL_SIZE = 1200, 800  # of the coursework's pictures
TRIOS = {"camera": ("mirror_image", "normals"), "binary": ("binary_primitives", None), "phong": ("simple_phong", None),
         "shadows": ("scene", None), "reflection": ("mirror_image", None),
         "refraction": ("features/material_refractive", None)}  # fmt: skip
TEASER = ("studio", "cornell", "scene_pathtracer")
CURVES = ("linear", "reinhard", "filmic")
FEATURES = {  # of the table: name, scene and mode, and the feature whose cost is told
    "camera, by normals": ("mirror_image", "normals", "camera"),
    "sphere": ("features/shape_sphere", None, "sphere"),
    "triangle": ("features/shape_triangle", None, "triangle"),
    "cylinder, oblique": ("features/shape_cylinder", None, "cylinder"),
    "Blinn-Phong, one light": ("simple_phong", None, "phong"),
    "its highlight": ("features/material_phong", None, "highlight"),
    "shadows of two lights": ("scene", None, "shadows"),
    **{f"tone curve, {curve}": (f"features/tonemap_{curve}", None, f"tonemap_{curve}") for curve in CURVES},
    "reflection": ("mirror_image", None, "reflection"),
    "refraction": ("features/material_refractive", None, "refraction"),
}
HARD = {"camera": "pixels of a field of view of 0.1 degrees", "steep": "views 1e-3 to 1e-7 from straight up",
        "sphere": "sphere of 1e-4 from 1e3 radii: distance",
        "needles": "needles and triangles seen edge-on: distance of hits from their plane",
        "highlight": "highlight of exponent 1e5, mode phong",
        "fresnel": "Fresnel, all angles, glass", "bounces": "100 bounces between two mirrors, mode phong"}  # fmt: skip
SHARES = {"edges": "corners and edges of triangle shapes, met exactly",
          "rims": "cylinders: rays from within that aim at a rim",
          "scene_shadows": "shadows at first hits of the coursework's scene, at three scales",
          "critical": "total reflection decided, up to 64 ulps from the critical angle"}  # fmt: skip
SCHLICK_INDEX = 1.5  # of window glass


def make(folder: Path) -> dict:
    """Return the part's numbers, and write its pictures."""
    numbers = {}
    for name, (scene, mode) in TRIOS.items():
        numbers |= pairs.pair(folder, name, scene, mode=mode)
    for curve in CURVES:
        pairs.picture(folder, curve, f"features/tonemap_{curve}")
    numbers["agreement"] = [agreement_row(name, *facts) for name, facts in FEATURES.items()]
    teaser(folder)
    return numbers | headlines() | coursework() | costs() | hard_cases()


def teaser(folder):
    """Write the pictures of the title page, as `make testsuite` rendered them."""
    for name in TEASER:
        picture = Image.open(ROOT / "TestSuite" / f"{name}.png").convert("RGB")
        picture.save(folder / f"{name}.jpg", quality=testsuite.QUALITY)


def agreement_row(name, scene, mode, feature) -> list[str]:
    """Return how far a feature's scene agrees with Mitsuba, and what the feature costs."""
    found = pairs.both(pairs.prepared(scene, mode))
    told = pairs.agreement("it", found.ours - found.theirs, found)
    if feature.startswith("tonemap"):  # is done once a picture
        price = {"ns": picture_cost(f"basic.{feature}"), "ratio": UNASKED}
    else:
        price = cost(f"basic.{feature}")
    return [name, told["it_pixels"], told["it_greatest"].split(THIN)[0], price["ns"], price["ratio"]]


def headlines() -> dict[str, str]:
    """Return the results on the title page."""
    ordered = sorted(figure("error", f"{one['scene']}, speed at equal error beside Mitsuba's best")
                     for one in table("error", "at equal error"))  # fmt: skip
    process = row("whole_process", "processes", scene="scene")
    return {
        "error_scenes": words(len(ordered)), "error_least": digits(ordered[0]), "error_most": digits(ordered[-1]),
        "error_mean": digits(float(np.exp(np.mean(np.log(ordered))))),
        "warm": seconds(median(process["warm start (s)"])), "cold": seconds(median(process["cold start (s)"])),
        "memory": unit(figure("whole_process", "scene, peak memory"), "MB"),
        "cpu": machine("cpu"), "cores": words(int(machine("cores"))), "date": machine("date"),
        "mitsuba": machine("mitsuba"), "drjit": machine("drjit"),
    }


def coursework() -> dict[str, str]:
    """Return how many pixels of the coursework's scenes, at their full size, differ from Mitsuba's."""
    apart, counted = 0, 0
    for name in COURSEWORK:
        found = pairs.both(pairs.prepared(name, size=FULL_SIZE))
        levels = pairs.LEVELS * np.abs(found.ours - found.theirs).max(-1)
        apart, counted = apart + int((levels > 1.5).sum()), counted + levels.size
    return {"pixels_apart": f"{apart:,}", "pixels": f"{counted:,}"}


def costs() -> dict[str, str]:
    """Return what features cost, and speeds of the coursework's scenes."""
    rates = [median(one["both, x Mitsuba"]) for one in table("against_mitsuba", "ratios")]
    stages = row("whole_process", "stages", stage="tone mapping and writing")
    importing = {one["a process that imports"]: median(one["wall (s)"]) for one in table("whole_process", "imports")}
    return {f"{name}_{key}": text for name in ("camera", "phong", "shadows", "reflection", "refraction")
            for key, text in cost(f"basic.{name}").items()} | {
        "schlick": schlick(), "stack": str(STACK_SIZE),
        "numpy": seconds(importing["numpy"] - importing["sys"]),
        "ppm_cost": picture_cost("basic.image_ppm"), "png_cost": picture_cost("basic.image_png"),
        "writing": seconds(median(stages["warm (s)"])),
        "rays_least": digits(min(rates)), "rays_most": digits(max(rates)),
    }  # fmt: skip


def hard_cases() -> dict[str, str]:
    """Return worst errors of ours and of the textbook's formula in hard cases; of shares the mean."""
    numbers = {f"hard_{name}_{who}": found[0] for name, case in HARD.items() for who, found in hard_case(case).items()}
    return numbers | {f"hard_{name}_{who}": hard_share(case, who)
                      for name, case in SHARES.items() for who in hard_case(case)}  # fmt: skip


def schlick() -> str:
    """Return by how much Schlick's approximation misses the reflectance of glass at most, seen from outside."""
    cosine = np.linspace(0, 1, 100_001)
    transmitted = np.sqrt(1 - (1 - cosine**2) / SCHLICK_INDEX**2)
    s = (cosine - SCHLICK_INDEX * transmitted) / (cosine + SCHLICK_INDEX * transmitted)
    p = (SCHLICK_INDEX * cosine - transmitted) / (SCHLICK_INDEX * cosine + transmitted)
    normal = ((1 - SCHLICK_INDEX) / (1 + SCHLICK_INDEX)) ** 2
    return percent(np.abs(normal + (1 - normal) * (1 - cosine) ** 5 - (s**2 + p**2) / 2).max())
