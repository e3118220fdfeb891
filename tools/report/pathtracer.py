"""Figures and numbers of the part `pathtracer` of the report."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks import path_scenes as measured_scenes
from benchmarks.feature_patches import patched
from renderer.engine.render import render
from renderer.scene.loader import override
from tools.report import drawing, pairs, path_scenes
from tools.report.results import THIN, UNASKED, cost, digits, median, row, table, times, words

WIDE = {"bsdfs": ((480, 240), 192), "lights": ((480, 200), 256)}  # pixels, and samples a pixel
TABLE_SIZE, TABLE_SAMPLES = (240, 160), 128  # of the scenes whose agreement is told in tables
TRIOS = {  # name: scene, size, samples a pixel
    "lens": ("features/camera_thinlens", pairs.SIZE, 64),
    "cornell": ("cornell", pairs.SIZE, 192),
    "scene": ("scene_pathtracer", pairs.SIZE, 96),
    "mesh": ("studio", pairs.SIZE, 96),
    "environment": ("features/light_environment", pairs.SIZE, 128),
    "filter": ("features/filter_mitchell", pairs.SIZE, 32),
}
BSDFS = {"diffuse": "diffuse", "mirror": "mirror", "plastic": "plastic", "conductor": "conductor",
         "roughconductor": "roughconductor", "dielectric": "dielectric",
         "roughdielectric": "roughdielectric", "principled": "principled",
         "textured": "parameters from images"}  # fmt: skip
LIGHTS = {"pointlight": ("light_pointlight_paths", "pointlight"), "spot": ("light_spot", "spot"),
          "directional": ("light_directional", "directional"), "arealight": ("light_arealight", "arealight"),
          "disklight": ("light_disklight", "disklight"), "environment": ("light_environment", "environment"),
          "sphere": ("emission_sphere", "shining spheres"), "mesh": ("emission_mesh", "shining mesh"),
          "sheets": ("emission_sheets", "shining rectangle, disk, triangle"),
          "solids": ("emission_solids", "shining box, cylinder, convex volume")}  # fmt: skip
FILTERS = ("box", "tent", "gaussian", "mitchell")
CROP = slice(62, 112), slice(80, 155)  # rows and columns that show filters
ENLARGED = 4  # pixels for each of theirs
FILTER_SAMPLES = 16  # a pixel there
CURVE_SIZE, MOST = (150, 100), 9  # pixels, and doublings of samples
REFERENCE = 4096  # samples a pixel of the picture compared with
SEEDS = 3  # of each point of a curve
CURVES = {"lens": "thin lens", "metal": "rough conductors, environment", "box": "Cornell box, glass and mirror"}
MANY, MANY_REFERENCE = "1,000 lights", 512  # samples a pixel
STRATEGIES = {"lights": "lights alone", "bsdfs": "BSDFs alone", "both": ""}
STRATEGY_SAMPLES = 16  # a pixel
DARK = 0.01  # added to squared means, so that the error of black pixels stays finite


def make(folder: Path) -> dict:
    """Return the part's numbers."""
    numbers = {}
    one_or_many(folder)
    for name, (scene, size, samples) in TRIOS.items():
        numbers |= pairs.pair(folder, name, scene, size=size, samples=samples)
    for name, (size, samples) in WIDE.items():
        document = getattr(path_scenes, name)()
        numbers |= pairs.pair(folder, name, path_scenes.FOLDER, document=document, size=size, samples=samples)
    filters(folder)
    numbers["bsdfs"] = [agreement_row(f"bsdf_{key}", f"bsdf_{key}", said) for key, said in BSDFS.items()]
    numbers["bsdfs"].insert(2, coursework_row())
    numbers["lights"] = [agreement_row(scene, f"light_{key}", said) for key, (scene, said) in LIGHTS.items()]
    numbers |= samplers(folder) | strategies(folder) | switches() | choices() | flat_mesh()
    return numbers | costs() | speeds()


def one_or_many(folder):
    """Draw the same picture with one ray a pixel and with many."""
    for name, samples in (("one", 1), ("many", 64)):
        pairs.picture(folder, name, "features/samples", size=(240, 160), samples=samples)


def filters(folder):
    """Draw a part of a picture under each filter."""
    for name in FILTERS:
        document = path_scenes.file("features/filter_box") | {"filter": name}
        shown = pairs.alone(pairs.prepared(path_scenes.FOLDER, None, TABLE_SIZE, FILTER_SAMPLES, document))[CROP]
        pairs.write(folder / f"filter_{name}", shown.repeat(ENLARGED, 0).repeat(ENLARGED, 1), False)


def agreement_row(scene, feature, said, document=None):
    """Return how far a scene's picture agrees with Mitsuba's, and what its feature costs."""
    place = f"features/{scene}" if document is None else path_scenes.FOLDER
    found = pairs.both(pairs.prepared(place, None, TABLE_SIZE, TABLE_SAMPLES, document))
    told = pairs.agreement("it", pairs.testsuite.blocks(found.ours - found.theirs), found)
    price = dict.fromkeys(("ns", "times", "mitsuba"), UNASKED)  # diffuse is what others are compared with
    if feature != "bsdf_diffuse":
        price = cost(f"pathtracer.{feature}")
    return [said, told["it_means"], told["it_apart"], told["it_high"].split(THIN)[0], price["ns"], price["times"],
            price["mitsuba"]]  # fmt: skip


def coursework_row():
    """Return the row of the coursework's own material."""
    from benchmarks.feature_scenes import SCENES, document

    feature = SCENES["pathtracer.bsdf_coursework"]
    made = document(feature, feature.having, TABLE_SIZE, TABLE_SAMPLES)
    return agreement_row("", "bsdf_coursework", "the coursework's Blinn-Phong", made)


def _noise(loaded, seed=0, patch=""):
    """Return what stands for radiance in the tests: noise, another for each seed and number of samples."""
    size = loaded.description.camera.height, loaded.description.camera.width, 3
    return np.random.default_rng([seed, loaded.description.spp, len(patch)]).random(size)


@pairs.slow(_noise)
def radiance(loaded, seed=0, patch=""):
    """Return our linear radiance, (height, width, 3) float64; `patch` is one of benchmarks.feature_patches."""
    with patched(patch):
        channels = render(loaded, seed=seed).channels()
    return np.stack([channels[name] for name in "RGB"], axis=-1).astype(np.float64)


def error(picture, reference):
    """Return the relative root mean squared error, with DARK for what is black."""
    return float(np.sqrt(np.mean((picture - reference) ** 2 / (reference**2 + DARK))))


def small(document, samples, folder="", **keys):
    """Return a document as a loaded scene, small, under the box filter and with some keys set."""
    return pairs.prepared(str(folder), None, CURVE_SIZE, samples, document | {"filter": "box"} | keys)


def measured(name, folder):
    """Return the document of a scene of the benchmark `paths`; what it names lies in `folder`."""
    return measured_scenes.SCENES[name](folder)


def samplers(folder):
    """Plot error against samples for both samplers, and return slopes, and ratios at the most samples."""
    counts, found, numbers = [2**k for k in range(MOST)], {}, {"samplers_most": str(2 ** (MOST - 1))}
    for key, name in CURVES.items():
        document = measured(name, folder)
        reference = radiance(small(document, REFERENCE, folder, sampler="sobol"), seed=SEEDS)
        for sampler in ("independent", "sobol"):
            loaded = small(document, 1, folder, sampler=sampler)
            errors = [[error(radiance(override(loaded, samples=n), seed), reference) for seed in range(SEEDS)]
                      for n in counts]  # fmt: skip
            found[key, sampler] = np.sqrt(np.mean(np.square(errors), axis=1))
            slope = np.polyfit(np.log2(counts), np.log2(found[key, sampler]), 1)[0]
            numbers[f"slope_{key}_{sampler}"] = digits(float(slope))
        numbers[f"sampler_{key}"] = digits(float(found[key, "independent"][-1] / found[key, "sobol"][-1]))
    plotted(folder / "samplers.svg", counts, found)
    (folder / "sky.exr").unlink(missing_ok=True)
    return numbers


def plotted(path, counts, found):
    """Draw errors against numbers of samples, of {(key of CURVES, sampler): errors}."""
    with drawing.in_print():
        figure, axes = drawing.sheet(drawing.COLUMN, 2.0)
        for number, (key, name) in enumerate(CURVES.items()):
            for sampler, style in (("independent", "--"), ("sobol", "-")):
                axes.plot(counts, found[key, sampler], style, color=f"C{number}", label=name if style == "-" else None)
        axes.set(xlabel="samples a pixel", ylabel="relative error", xticks=counts[::2])
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        axes.legend()
        drawing.save(figure, path)


def strategies(folder):
    """Draw plates under spheres with light found by lights alone, by BSDFs alone, and by both; return the errors."""
    document, numbers = path_scenes.plates(), {}
    reference = radiance(pairs.prepared(path_scenes.FOLDER, None, (120, 80), REFERENCE, document), seed=1)
    for name, patch in STRATEGIES.items():
        with patched(patch):
            pairs.picture(folder, f"by_{name}", path_scenes.FOLDER, document=document, samples=STRATEGY_SAMPLES,
                          noisy=True)  # fmt: skip
        one = pairs.prepared(path_scenes.FOLDER, None, (120, 80), STRATEGY_SAMPLES, document)
        numbers[f"by_{name}"] = digits(error(radiance(one, patch=patch), reference))
        many = radiance(override(one, samples=REFERENCE), patch=patch)
        numbers[f"by_{name}_mean"] = digits(float(100 * abs(many.mean() / reference.mean() - 1)), 1) + f"{THIN}%"
    return numbers | {"by_samples": str(STRATEGY_SAMPLES)}


def switches():
    """Return the error with roulette and with lamps in mirrors, beside that without, at equal samples."""
    numbers = {}
    for key, scene, switch in (("roulette", "cornell", "roulette"), ("mirrors", "scene_pathtracer", "mirrorlight")):
        document = path_scenes.file(scene)
        reference = radiance(small(document, REFERENCE), seed=1)
        on, off = (error(radiance(small(document, 64, **{switch: value})), reference) for value in (True, False))
        numbers |= {f"{key}_error": times(on / off), f"{key}_variance": digits((off / on) ** 2)}
        if key == "roulette":
            numbers["roulette_squared"] = (on / off) ** 2
            early = error(radiance(small(document, 64), patch="early roulette"), reference)
            numbers["roulette_early"] = times(early / off)
    return numbers | {"roulette_equal": error_times_time("pathtracer.roulette", numbers.pop("roulette_squared"))}


def error_times_time(feature, squared):
    """Return squared error times time of a feature, beside those without it, as its CPU time was measured."""
    return times(squared * median(row("features", "features", feature=feature)["time, x without"]))


def choices():
    """Return how much more variance other choices among many lights have, at equal samples."""
    document, found = measured(MANY, None), {}
    reference = radiance(small(document, MANY_REFERENCE), seed=1)
    for patch in ("", "lights by power", "lights alike"):
        found[patch] = error(radiance(small(document, 16), patch=patch), reference) ** 2
    return {"choice_power": digits(found["lights by power"] / found[""]),
            "choice_alike": digits(found["lights alike"] / found[""])}  # fmt: skip


def flat_mesh():
    """Return how far the means of a shining mesh differ if the normals of its file are not used."""
    document = path_scenes.file("features/emission_mesh")
    for shape in document["scene"]["shapes"]:
        shape |= {"normals": "flat"} if shape["type"] == "mesh" else {}
    return {"flat_mesh": agreement_row("", "light_mesh", "", document)[1]}


def costs():
    """Return what single features cost."""
    names = ("samples", "samples_phong", "filter_tent", "filter_gaussian", "filter_mitchell", "sobol", "lens",
             "bounces", "mis", "roulette", "mirrorlight", "light_many")  # fmt: skip
    found = {f"{name}_{key}": text for name in names for key, text in cost(f"pathtracer.{name}").items()}
    return found | {f"mesh_price_{key}": text for key, text in cost("pathtracer.mesh").items()}


def speeds():
    """Return how fast scenes are beside Mitsuba, from the benchmark of path tracing."""
    rates = [median(one["speed with Mitsuba's estimator, x Mitsuba"]) for one in table("paths", "paths")]
    named = {"many": "1,000 lights", "lenses": "thin lens", "cornell": "Cornell box, glass and mirror",
             "mesh": "mesh of 100,000 triangles"}  # fmt: skip
    equal = {f"equal_{key}": digits(row("paths", "paths", scene=scene)["error x time, x Mitsuba"])
             for key, scene in named.items()}  # fmt: skip
    return equal | {"speed_least": digits(min(rates)), "speed_most": digits(max(rates)),
                    "speed_scenes": words(len(rates))}  # fmt: skip
