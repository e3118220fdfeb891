"""The room plan, enforced: who may import whom, read from the sources without running them.

`complaints` judges one module's text. The second half of this file feeds it modules that break each rule, so that a
rule which has stopped to bite is noticed.
"""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LEVELS = {"core": 0, "io": 1, "accel": 1, "textures": 1, "shapes": 2, "bsdfs": 2, "cameras": 2, "samplers": 2,
          "lights": 3, "scene": 4, "integrators": 5, "engine": 6}
TOP = 7  # the modules of renderer/ itself: cli, doctor and what they use
FAMILIES = ("textures", "shapes", "bsdfs", "cameras", "samplers", "lights", "integrators")
SHARED = ("base", "glass", "microfacet", "mis")  # what the kinds of a family may have in common
BACKEND = "renderer.core.backend"
DESCRIPTION = ("schema", "materials", "quantities", "values", "composed", "transform", "loaded", "loader", "locate",
               "aliases", "aliases_light", "aliases_material", "aliases_mesh", "checks", "checks_lights",
               "checks_shapes", "reference", "reference_paths")
ALLOWED = {("renderer", "renderer.core.llvm")}  # chosen first of all: Dr.Jit may be imported by any module next
FOR_CONVERTERS = ("renderer.scene.schema", "renderer.scene.materials", "renderer.scene.quantities",
                  "renderer.scene.transform", "renderer.scene.loader", "renderer.scene.loaded", "renderer.io",
                  "renderer.core.errors")
LINE = 120  # characters
MITSUBA_ROOMS = ("converters", "benchmarks", "tests")
OUTSIDE = ("converters", "benchmarks", "tests", "tools")  # nothing of this is there where the renderer is installed


def module_name(path):
    """Return the dotted name of a source file of the checkout."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def source_files():
    """Return the project's sources: of the checkout's folders, not of what was installed in it."""
    rooms = [ROOT / room for room in ("renderer", *OUTSIDE)]
    return sorted(path for room in rooms for path in room.rglob("*.py") if "__pycache__" not in path.parts)


FILES = {module_name(path): path for path in source_files()}
PACKAGES = {name for name, path in FILES.items() if path.name == "__init__.py"}


def imports(source, module, modules):
    """Return `(imported module, whether at module level)` of every import; names of a module count as the module."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        for child in ast.iter_child_nodes(node):
            child.inside = isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) or getattr(node, "inside", False)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, not node.inside
        elif isinstance(node, ast.ImportFrom):
            base = absolute(node, module)
            for alias in node.names:
                full = f"{base}.{alias.name}"
                yield (full if full in modules or full.startswith("drjit.") else base), not node.inside


def absolute(node, module):
    """Return the absolute name of what a `from` import is from."""
    if not node.level:
        return node.module
    package = module.split(".") if module in PACKAGES else module.split(".")[:-1]
    parents = package[: len(package) - node.level + 1]
    return ".".join([*parents, *([node.module] if node.module else [])])


def complaints(module, source, modules=frozenset(FILES)):
    """Return what is wrong with one module's imports, a sentence each."""
    wrong = []
    for name, at_top in imports(source, module, modules):
        wrong += [f"{module} imports {name}: {reason}" for reason in judge(module, name, at_top)]
    return wrong + [f"{module} {reason}" for reason in names_backend(module, source)]


def judge(module, name, at_top):
    """Yield the rules that one import breaks."""
    room, target = module.split(".")[0], name.split(".")[0]
    if target == "mitsuba" and room not in MITSUBA_ROOMS:
        yield "Mitsuba is what the renderer is checked against, and not part of it"
    if room == "renderer":
        yield from judge_renderer(module, name, at_top)
    if room == "converters" and target == "renderer" and not within(name, FOR_CONVERTERS):
        yield "converters know the description of a scene and nothing that renders it"


def judge_renderer(module, name, at_top):
    """Yield the rules that one import in the renderer breaks."""
    if name.split(".")[0] in OUTSIDE:
        yield "the renderer stands alone"
    if within(name, ("drjit.llvm", "drjit.cuda", "drjit.auto")) and module != BACKEND:
        yield f"only {BACKEND} names a backend of Dr.Jit"
    if within(module, tuple(f"renderer.scene.{part}" for part in DESCRIPTION)):
        if at_top and within(name, ("drjit", "numpy", "scipy", BACKEND)):
            yield "the description of a scene is read without Dr.Jit and numpy"
    upwards = name.startswith("renderer.") and room_of(name) != room_of(module) and level(name) >= level(module)
    if upwards and (module, name) not in ALLOWED:
        if not level(name) == level(module) == TOP:
            yield f"imports point down, and this one goes from level {level(module)} to {level(name)}"
    if name.startswith("renderer.") and room_of(name) == room_of(module) in FAMILIES:
        registers = module == f"renderer.{room_of(module)}"
        if not registers and name != module and name.split(".")[2:] not in [[shared] for shared in SHARED]:
            yield "kinds of one family do not know each other"


def names_backend(module, source):
    """Yield a complaint about Dr.Jit's enumeration of backends outside its room."""
    attributes = {node.attr for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Attribute)}
    if module.startswith("renderer") and module != BACKEND and "JitBackend" in attributes:
        yield f"names a backend of Dr.Jit, which only {BACKEND} does"


def within(name, rooms):
    """Return whether a dotted name is one of the rooms or lies in one."""
    return any(name == room or name.startswith(f"{room}.") for room in rooms)


def room_of(name):
    """Return the folder of `renderer` that a module lies in; empty for the modules of `renderer` itself."""
    parts = name.split(".")
    is_folder = len(parts) > 2 or name in PACKAGES or parts[1:2] and parts[1] in LEVELS
    return parts[1] if len(parts) > 1 and is_folder else ""


def level(name):
    """Return the level of a module of the renderer; the bare package holds only the version and may be read by all."""
    if name == "renderer":
        return -1
    return LEVELS[room_of(name)] if room_of(name) else TOP


@pytest.mark.parametrize("module", FILES)
def test_imports_follow_the_room_plan(module):
    """Every module imports only what its room allows."""
    assert complaints(module, FILES[module].read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("family", [family for family in FAMILIES if f"renderer.{family}" in FILES])
def test_every_kind_is_registered(family):
    """A module of a family that its folder does not import would never be found by name."""
    folder = f"renderer.{family}"
    imported = {name for name, _ in imports(FILES[folder].read_text(encoding="utf-8"), folder, FILES)}
    kinds = {name for name in FILES if name.startswith(f"{folder}.") and name.split(".")[2] not in SHARED}
    assert kinds <= imported


def test_every_folder_of_the_renderer_has_a_level():
    """A new room has to find its place in the plan."""
    folders = {path.parent.relative_to(ROOT / "renderer").parts[0] for path in (ROOT / "renderer").rglob("*/*.py")}
    assert folders - {"__pycache__"} <= set(LEVELS)


def test_description_is_read_without_heavy_libraries():
    """Not even indirectly does reading a scene import Dr.Jit or numpy: a wrong scene is refused at once."""
    program = "import sys, renderer.scene.loader; print(*{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not {"drjit", "numpy", "scipy", "mitsuba", "PIL"} & set(done.stdout.split())


def test_llvm_is_chosen_before_dr_jit_is_imported():
    """Dr.Jit reads the choice once, when it is imported, by whichever module comes first."""
    program = """
import os, sys
class Witness:
    def find_spec(self, name, path=None, target=None):
        if name == "drjit":
            print("chosen" if os.environ.get("DRJIT_LIBLLVM_PATH") else "too late")
sys.meta_path.insert(0, Witness())
import renderer.engine.render
"""
    environment = {name: value for name, value in os.environ.items() if name != "DRJIT_LIBLLVM_PATH"}
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.stdout.split() == ["chosen"], done.stdout + done.stderr


@pytest.mark.parametrize("module, source, told", [
    ("renderer.shapes.torus", "import mitsuba as mi", "checked against"),
    ("renderer.engine.loop", "def late():\n    import mitsuba", "checked against"),
    ("renderer.scene.tables", "from mitsuba import Ray3f", "checked against"),
    ("tools.pictures", "import mitsuba", "checked against"),
    ("renderer.cli", "import tests.support", "stands alone"),
    ("renderer", "from renderer.core import backend", "level -1 to 0"),
    ("renderer.io.image", "from converters import solids", "stands alone"),
    ("renderer.core.numeric", "from drjit.llvm import Float", "only renderer.core.backend"),
    ("renderer.shapes.box", "import drjit.cuda", "only renderer.core.backend"),
    ("renderer.engine.loop", "from drjit import llvm", "only renderer.core.backend"),
    ("renderer.engine.loop", "import drjit.auto as auto", "only renderer.core.backend"),
    ("renderer.doctor", "import drjit as dr\nworks = dr.has_backend(dr.JitBackend.LLVM)", "names a backend"),
    ("renderer.core.frame", "from renderer.io import image", "level 0 to 1"),
    ("renderer.io.image", "from renderer.textures import bitmap", "level 1 to 1"),
    ("renderer.shapes.box", "from renderer.lights.base import LightSample", "level 2 to 3"),
    ("renderer.cameras.pinhole", "from renderer.samplers.sobol import Sobol", "level 2 to 2"),
    ("renderer.integrators.phong", "def late():\n    from renderer.engine import loop", "level 5 to 6"),
    ("renderer.scene.checks", "from renderer import cli", "level 4 to 7"),
    ("renderer.scene.checks", "from ..engine import loop", "level 4 to 6"),
    ("renderer.shapes.box", "from renderer.shapes import plane", "do not know each other"),
    ("renderer.shapes.box", "from renderer.shapes.plane import PLANE", "do not know each other"),
    ("renderer.shapes.box", "from . import plane", "do not know each other"),
    ("renderer.shapes.box", "from renderer.shapes import KINDS", "do not know each other"),
    ("renderer.scene.schema", "import numpy as np", "without Dr.Jit and numpy"),
    ("renderer.scene.loader", "import drjit", "without Dr.Jit and numpy"),
    ("renderer.scene.loader", "if True:\n    import numpy", "without Dr.Jit and numpy"),
    ("renderer.scene.checks", "from scipy.optimize import linprog", "without Dr.Jit and numpy"),
    ("renderer.scene.aliases", "from renderer.core.backend import Float", "without Dr.Jit and numpy"),
    ("converters.mitsuba.plan", "from renderer.shapes.sphere import SPHERE", "description of a scene"),
    ("converters.mitsuba.plan", "from renderer.scene import tables", "description of a scene"),
    ("converters.solids", "from renderer.core.vectors import cross", "description of a scene"),
    ("converters.solids", "import renderer.engine.render", "description of a scene"),
])
def test_broken_rule_is_noticed(module, source, told):
    """Each rule bites: this text in that module is complained about, for that reason."""
    assert any(told in complaint for complaint in complaints(module, source))


@pytest.mark.parametrize("module, source", [
    ("renderer.shapes.box", "from renderer.shapes.base import register"),
    ("renderer.shapes.box", "from renderer.core.backend import Float\nimport drjit as dr"),
    ("renderer.shapes", "from renderer.shapes import box, plane"),
    ("renderer.scene.checks", "def late():\n    from scipy.optimize import linprog"),
    ("renderer.scene.tables", "from renderer.lights import KINDS"),
    ("renderer.scene.tables", "import numpy as np"),
    ("renderer", "from renderer.core import llvm"),
    ("renderer.cli", "from renderer import __version__, doctor"),
    ("renderer.core.backend", "import drjit.llvm as types"),
    ("converters.mitsuba.plan", "from renderer.scene import schema\nfrom renderer.io.image import read_texture"),
    ("converters.mitsuba.as_dict", "import mitsuba as mi\nimport numpy as np"),
    ("tests.oracle.test_masks", "import mitsuba\nfrom renderer.engine.render import render"),
])
def test_kept_rule_is_not_complained_about(module, source):
    """The rules allow what the design asks for."""
    assert complaints(module, source) == []


@pytest.mark.parametrize("name", FILES)
def test_lines_fit(name):
    """A line has 120 characters at most."""
    lines = FILES[name].read_text(encoding="utf-8").splitlines()
    assert not [number for number, line in enumerate(lines, start=1) if len(line) > LINE]
