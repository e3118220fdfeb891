"""A scene as the benchmark `needs` renders it.

As a program, `python -m benchmarks.needs_worker SCENE.json` tells in a line of JSON what its kernels are and, started
with an empty cache, how long they took to compile.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import drjit as dr
import numpy as np

from renderer.engine.passes import Until, refine
from renderer.engine.render import set_up
from renderer.scene import loader
from renderer.scene.schema import PATHTRACER


class Picture:
    """A compiled scene that can be rendered with any seed."""

    def __init__(self, loaded):
        self.description = loaded.description
        self.scene, self.view = set_up(loaded)

    def render(self, seed):
        """Return the (H, W, 3) float64 picture of linear radiance."""
        d, view = self.description, replace(self.view, seed=seed)
        exposure = refine(view, Until(d.spp))
        colour = exposure.film.mean(exposure.taken)
        dr.eval(colour)
        dr.sync_thread()
        channels = [channel.numpy().reshape(d.camera.height, d.camera.width) for channel in colour]
        return np.stack(channels, axis=-1).astype(np.float64)


def compiled_in(picture):
    """Return {what: names} of the features that the kernel of a Picture has, as its compiled scene tells them."""
    scene, mode = picture.scene, picture.description.rendermode
    shapes = [group.kind.name for group in scene.shapes]
    shapes += ["triangles"] if scene.triangles is not None else []
    found = _in_paths(scene) if mode == PATHTRACER else _in_phong(scene)
    others = [picture.view.camera[0].name] if picture.view.camera[0].has_lens else []
    others += [f"hierarchy ({type(scene.structure).__name__})"] if scene.structure is not None else []
    found = {"mode": [mode], "shapes": shapes} | found
    found["else"] = found["else"] + others
    return {key: ", ".join(dict.fromkeys(names)) or None for key, names in found.items()}


def _in_phong(scene):
    """Return lights, materials and the rest of a CompiledScene."""
    has = {"mirrors": scene.has_mirrors, "rough mirrors": scene.has_rough_mirrors, "glass": scene.has_glass}
    materials = ["Blinn-Phong"] if scene.materials is not None and scene.lights else []
    lights = [group.kind.name for group in scene.lights]
    return {"lights": lights + ["environment"] * (scene.environment is not None),
            "materials": materials + [name for name, there in has.items() if there],
            "else": ["textures"] * (scene.texture is not None)}  # fmt: skip


def _in_paths(scene):
    """Return the same of a PathScene."""
    scattering, lighting = scene.scattering, scene.lighting
    groups = scattering.groups if scattering else []
    materials = [group.kind.name + (f" ({', '.join(sorted(group.has))})" if group.has else "") for group in groups]
    lights = [_light(group) for group in lighting._groups]
    lights += ["shapes that shine"] * lighting.has_emitters
    others = {"textures": any(group.textured for group in groups),
              "tangents": bool(scattering) and scattering.with_tangents,
              "background": lighting.has_background and not lighting.has_image, "roulette": scene.roulette,
              "lamps in mirrors": scene.mirrors is not None}  # fmt: skip
    return {"lights": lights, "materials": materials, "else": [name for name, there in others.items() if there]}


def _light(group):
    """Return the name of a group of lights: its class's, or of plain records that of the module that samples them."""
    sample = getattr(group, "sample", None)
    name = getattr(sample, "__module__", "").rpartition(".")[2]
    return name or {"Surroundings": "environment", "MeshLights": "mesh"}[type(group).__name__]


def main(path):
    """Render the scene in a file once and print what its kernels were."""
    picture = Picture(loader.load(Path(path)))
    dr.eval()
    dr.sync_thread()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        picture.render(0)
        kernels = [kernel for kernel in dr.kernel_history() if "operation_count" in kernel]
    largest = max(kernels, key=lambda kernel: kernel["operation_count"])
    compiling = sum(kernel["codegen_time"] + kernel["backend_time"] for kernel in kernels) / 1000
    size = round(len(largest["ir"].getvalue()) / 1000)
    print(json.dumps({"operations": largest["operation_count"], "code (kB)": size, "compile (s)": compiling}))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
