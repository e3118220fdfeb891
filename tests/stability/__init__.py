"""Numerical stability on hard cases: `python -m tests.stability` measures, `pytest tests/stability` judges.

A module here that defines CASES takes part by being there; its docstring introduces its part of the table.
"""

import functools
import importlib
import inspect
from pathlib import Path


@functools.cache
def modules():
    """Return [(module name, docstring, cases)] in the order of the names."""
    sources = sorted(Path(__file__).parent.glob("*.py"))
    names = [path.stem for path in sources if "\nCASES = " in path.read_text()]
    loaded = [importlib.import_module(f"tests.stability.{name}") for name in names]
    return [(name, inspect.getdoc(module), module.CASES) for name, module in zip(names, loaded)]


def all_cases():
    """Return the cases of all modules."""
    return [case for _, _, cases in modules() for case in cases]
