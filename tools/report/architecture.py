"""The size of the parts, the kinds that there are, and what of them a scene needs (benchmark `needs`)."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

from tests.test_architecture import LEVELS, TOP
from tools.report import results

FAMILIES = {"shapes": "KINDS", "bsdfs": "KINDS", "lights": "KINDS", "cameras": "KINDS", "samplers": "KINDS"}
ALL = "everything", "everything and a mesh"  # what a scene is rendered with beside itself, the first that there is


def make(folder: Path) -> dict[str, str | list]:
    """Return counts of modules, lines, kinds and tests, the levels, and the table of what scenes need."""
    told = {f"{name}_kinds": results.words(kinds(name)) for name in FAMILIES}
    for room in ("renderer", "converters", "tests"):
        lengths = [len(path.read_text().splitlines()) for path in sources(room)]
        told |= {f"{room}_modules": str(len(lengths)), f"{room}_lines": f"{sum(lengths):,}"}
    modules = sorted(len(path.read_text().splitlines()) for path in sources("renderer"))
    told |= {"median_lines": str(modules[len(modules) // 2]), "longest": str(modules[-1]), "tests": f"{tests():,}",
             "features": str(len(list((results.ROOT / "scenes" / "features").glob("*.json"))))}  # fmt: skip
    return told | {"levels": levels()} | needs()


def sources(room):
    """Return the modules of a folder of the repository."""
    return sorted((results.ROOT / room).rglob("*.py"))


def kinds(family):
    """Return how many kinds of a family scene files can name."""
    importlib.import_module(f"renderer.{family}")
    return len(getattr(importlib.import_module(f"renderer.{family}.base"), FAMILIES[family]))


def tests():
    """Return how many test functions there are; many are run with several inputs."""
    trees = (ast.parse(path.read_text()) for path in sources("tests"))
    functions = (node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return sum(function.name.startswith("test_") for function in functions)


def levels():
    """Return [level, folders] as tests/test_architecture.py enforces them."""
    rooms = {}
    for room, level in LEVELS.items():
        rooms.setdefault(level, []).append(room)
    return [[str(level), ", ".join(rooms[level])] for level in sorted(rooms)] + [[str(TOP), "cli.py"]]


def needs():
    """Return the table of what scenes need, and the least and the most that is saved."""
    rows, saved = [], []
    for scene in dict.fromkeys(row["scene"] for row in results.table("needs", "kernels")):
        found = {row["with"]: row for row in results.table("needs", "kernels") if row["scene"] == scene}
        alone, full = found["nothing else"], next(found[name] for name in ALL if name in found)
        saved.append(results.median(full["time, x as it is"]))
        compiled = (results.seconds(results.median(row["compile (s)"])) for row in (alone, full))
        rows.append([scene.replace("_", " "), *(f"{row['operations']:,}" for row in (alone, full)), *compiled,
                     results.digits(saved[-1])])  # fmt: skip
    return {"needs": rows, "saved_least": results.digits(min(saved)), "saved_most": results.digits(max(saved)),
            "scenes": results.words(len(rows))}  # fmt: skip
