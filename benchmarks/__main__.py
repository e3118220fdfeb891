"""`python -m benchmarks [NAME ...]`: measure, print tables, and say of each figure whether it reached its target."""

from __future__ import annotations

import argparse
import dataclasses
import difflib
import importlib
import importlib.util
import inspect
import json
import os
import sys
from pathlib import Path

from benchmarks import table
from benchmarks.machine import describe
from benchmarks.measure import FULL, QUICK, BenchmarkError
from benchmarks.targets import sentence

BENCHMARKS = {
    "whole_process": "wall time and memory of the command, warm and cold, and what a start consists of",
    "throughput": "samples per CPU second with many samples a pixel",
    "variants": "what the decisions behind the speed are worth",
    "against_mitsuba": "intersection and shadow tests beside Mitsuba's, same rays, same scenes",
    "structures": "hierarchy, grid and no structure on the same scenes, and from how many shapes on one pays",
    "paths": "path tracing beside Mitsuba: speed, and error at equal time",
    "meshes": "triangle meshes beside Mitsuba's Embree: rays, building, memory, diffuse paths",
}
NEED_MITSUBA = ("against_mitsuba", "paths", "meshes")
LARGEST_MESH = 10_000_000  # triangles: the soup of so many takes 4.3 GB with Embree alone
BAD_INPUT, FAILED = 2, 1


def main(arguments=None):
    """Run what the arguments ask for and return the exit status; missed targets do not count as failures."""
    options = _parser().parse_args(arguments)
    if options.list:
        print("\n".join(f"{name:16} {summary}" for name, summary in BENCHMARKS.items()))
        return 0
    names = [name for name in BENCHMARKS if name in (options.names or BENCHMARKS)]
    complaint = _complaint(options, names)
    if complaint:
        print(f"benchmarks: {complaint}", file=sys.stderr)
        return BAD_INPUT
    try:
        results = run(names, _effort(options))
    except BenchmarkError as error:
        print(f"benchmarks: {error}", file=sys.stderr)
        return FAILED
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n")
    elif options.update:
        results = table.updated(results, list(BENCHMARKS))
        table.write(results)
    elif not (options.names or options.quick or options.triangles):
        table.write(results)
    print(table.page(results))
    print(*map(sentence, table.figures(results)), sep="\n")
    return 0


def _effort(options):
    """Return how much is to be measured."""
    effort = QUICK if options.quick else FULL
    return effort if options.triangles is None else dataclasses.replace(effort, triangles=options.triangles)


def _parser():
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", allow_abbrev=False,
        description="Measure speed and memory. A full run (none of the arguments) writes "
        "benchmarks/results.json, the tables made from it, and the numbers in the documents.",
    )
    parser.add_argument("names", nargs="*", metavar="NAME",
                        help=f"only these: {', '.join(BENCHMARKS)} (default: {', '.join(BENCHMARKS)})")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the results there instead")
    parser.add_argument("--update", action="store_true",
                        help="put the results of these in the place of theirs in benchmarks/results.json, tables and "
                        "documents, and say when they were taken")
    parser.add_argument("--quick", action="store_true", help="small pictures and few repeats: does it work?")
    parser.add_argument("--triangles", type=int, metavar="N",
                        help=f"size of the largest mesh, 1 to {LARGEST_MESH} (default: {FULL.triangles})")
    parser.add_argument("--list", action="store_true", help="say what there is, and measure nothing")
    return parser


def _complaint(options, names):
    """Return what stands against a measurement, before minutes are spent on it; None if nothing does."""
    for name in options.names:
        if name not in BENCHMARKS:
            near = difflib.get_close_matches(name, BENCHMARKS, n=1)
            hint = f", did you mean '{near[0]}'?" if near else ""
            return f"unknown benchmark '{name}'{hint} (there are: {', '.join(BENCHMARKS)})"
    if options.update and (not options.names or options.quick or options.triangles is not None or options.json):
        return "--update goes with names of benchmarks, measured in full, and not with --json"
    if options.json and (options.json.is_dir() or not os.access(options.json.resolve().parent, os.W_OK)):
        return f"cannot write to '{options.json}'"
    if options.triangles is not None and not 1 <= options.triangles <= LARGEST_MESH:
        return f"--triangles {options.triangles} is not between 1 and {LARGEST_MESH}"
    if set(NEED_MITSUBA) & set(names) and importlib.util.find_spec("mitsuba") is None:
        return "Mitsuba is not installed; `make bench` sees to it"
    return None


def run(names, effort):
    """Return {machine, effort, benchmarks} with what the named benchmarks found."""
    # CPU time says nothing about a GPU; set before anything imports the renderer
    os.environ["RENDERER_BACKEND"] = "llvm"
    results = {"machine": describe(), "effort": dataclasses.asdict(effort), "benchmarks": {}}
    if results["machine"]["load_before"] > table.QUIET_LOAD:
        print(f"the machine is not quiet: load {results['machine']['load_before']}", file=sys.stderr)
    for name in names:
        print(f"measuring {name}: {BENCHMARKS[name]}", file=sys.stderr)
        module = importlib.import_module(f"benchmarks.{name}")
        results["benchmarks"][name] = {"about": inspect.getdoc(module), **module.measure(effort)}
    return results


if __name__ == "__main__":
    sys.exit(main())
