"""`python -m benchmarks [NAME ...]`: measure, print tables, and say of each figure whether it reached its target.

With --check instead: whether a ratio against Mitsuba has fallen below that of the committed results.
"""

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

from benchmarks import regression, table
from benchmarks.machine import describe
from benchmarks.measure import FULL, QUICK, BenchmarkError
from benchmarks.targets import sentence

BENCHMARKS = {
    "whole_process": "wall time and memory of the command, warm and cold, and what a start consists of",
    "throughput": "samples per CPU second with many samples a pixel",
    "variants": "what the decisions behind the speed are worth",
    "against_mitsuba": "intersection and shadow tests beside Mitsuba's, same rays, same scenes",
    "structures": "hierarchy, grid and no structure on the same scenes, and from how many shapes on one pays",
    "growth": "no structure, grid, hierarchy and Mitsuba's Embree on meshes of ever more triangles",
    "paths": "path tracing beside Mitsuba: speed, and error at equal time",
    "error": "path tracing beside Mitsuba: error against time at rising numbers of samples, with plots",
    "meshes": "triangle meshes beside Mitsuba's Embree: rays, building, memory, diffuse paths",
    "needs": "what a scene's kernel contains, and what it would cost with everything in it",
    "features": "what each feature of the assignment sheets costs: scenes with it and without it",
}
NEED_MITSUBA = ("against_mitsuba", "paths", "error", "meshes")  # all of them have ratios against it
BESIDE_MITSUBA = (*NEED_MITSUBA, "growth", "features")  # in which it is measured, too
WITH_SCENES = {  # modules with SCENES, which import no Dr.Jit, of the benchmarks of which single scenes can be measured
    "paths": "benchmarks.path_scenes", "error": "benchmarks.error_scenes", "needs": "benchmarks.needs_scenes",
    "features": "benchmarks.feature_scenes",
}
PLOTTED = "error"  # the benchmark that plots are made of
LARGEST_MESH = 10_000_000  # triangles: the soup of so many takes 4.3 GB with Embree alone
BAD_INPUT, FAILED = 2, 1


def main(arguments=None):
    """Run what the arguments ask for and return the exit status; missed targets do not count as failures."""
    options = _parser().parse_args(arguments)
    if options.list:
        print("\n".join(f"{name:16} {summary}" for name, summary in BENCHMARKS.items()))
        return 0
    wanted = options.names or (NEED_MITSUBA if options.check else BENCHMARKS)
    names = [name for name in BENCHMARKS if name in wanted]
    try:
        complaint = _complaint(options, names)
        if complaint:
            print(f"benchmarks: {complaint}", file=sys.stderr)
            return BAD_INPUT
        results = _made_before(options.measured, names) if options.measured else run(names, _effort(options))
    except BenchmarkError as error:
        print(f"benchmarks: {error}", file=sys.stderr)
        return FAILED
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n")
    if options.check:
        return regression.check(results, json.loads(table.RESULTS.read_text()))
    _keep(results, options)
    return 0


def _keep(results, options):
    """Write what is to be kept: a full run, or one that was to be kept beside the others; print the tables."""
    if options.update:
        results = table.updated(results, list(BENCHMARKS))
    if options.update or not (options.names or options.quick or options.triangles or options.json):
        table.write(results)
        if PLOTTED in results["benchmarks"]:
            from benchmarks import plots

            plots.write(results)
    print(table.page(results))
    print(*map(sentence, table.figures(results)), sep="\n")


def _made_before(path, names):
    """Return the named benchmarks' part of results that --json wrote."""
    try:
        results = json.loads(path.read_text())
        found = results["benchmarks"]
        return {key: results[key] for key in ("machine", "effort")} | {
            "benchmarks": {name: found[name] for name in names if name in found}
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BenchmarkError(f"'{path}' has no results: {error}") from error


def _effort(options):
    """Return how much is to be measured."""
    effort = dataclasses.replace(QUICK if options.quick else FULL, scenes=tuple(options.scene))
    return effort if options.triangles is None else dataclasses.replace(effort, triangles=options.triangles)


def _parser():
    """Return the parser of the command line."""
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
    parser.add_argument("--scene", action="append", default=[], metavar="NAME",
                        help=f"only this scene of a benchmark that has some ({', '.join(WITH_SCENES)}); repeatable")
    parser.add_argument("--check", action="store_true",
                        help="compare ratios against Mitsuba with those of benchmarks/results.json, write nothing, and "
                        f"end with status 1 if one fell (default: of {', '.join(NEED_MITSUBA)})")
    parser.add_argument("--measured", type=Path, metavar="FILE",
                        help="with --check: compare these results, which --json wrote, instead of measuring")
    parser.add_argument("--triangles", type=int, metavar="N",
                        help=f"size of the largest mesh, 1 to {LARGEST_MESH} (default: {FULL.triangles})")
    parser.add_argument("--list", action="store_true", help="say what there is, and measure nothing")
    return parser


def _complaint(options, names):
    """Return what stands against a measurement, before minutes are spent on it; None if nothing does."""
    for name in options.names:
        if name not in BENCHMARKS:
            return _unknown("benchmark", name, BENCHMARKS)
    part = options.quick or options.triangles is not None or options.scene
    if options.update and (not options.names or part or options.json or options.check):
        return "--update goes with names of benchmarks, measured in full, and not with --json and --check"
    if options.measured and not options.check:
        return "--measured goes with --check"
    if options.check and not set(names) <= set(NEED_MITSUBA):
        return f"--check goes with benchmarks that have ratios against Mitsuba: {', '.join(NEED_MITSUBA)}"
    complaint = _complaint_about_scenes(options, names)
    if complaint:
        return complaint
    if options.json and (options.json.is_dir() or not os.access(options.json.resolve().parent, os.W_OK)):
        return f"cannot write to '{options.json}'"
    if options.triangles is not None and not 1 <= options.triangles <= LARGEST_MESH:
        return f"--triangles {options.triangles} is not between 1 and {LARGEST_MESH}"
    if set(BESIDE_MITSUBA) & set(names) and not options.measured and importlib.util.find_spec("mitsuba") is None:
        return "Mitsuba is not installed; `make bench` sees to it"
    if PLOTTED in names and not options.measured and importlib.util.find_spec("matplotlib") is None:
        return "matplotlib is not installed; `make bench` sees to it"
    return None


def _complaint_about_scenes(options, names):
    """Return what is wrong with the scenes that were named."""
    if not options.scene:
        return None
    if not options.names or not set(names) <= set(WITH_SCENES):
        return f"--scene goes with names of benchmarks that have scenes: {', '.join(WITH_SCENES)}"
    for benchmark in names:
        known = importlib.import_module(WITH_SCENES[benchmark]).SCENES
        for name in options.scene:
            if name not in known:
                return _unknown(f"scene of {benchmark}", name, known)
    return None


def _unknown(what, name, known):
    """Return the sentence about a name that does not exist, with the one that was probably meant."""
    near = difflib.get_close_matches(name, known, n=1)
    hint = f", did you mean '{near[0]}'?" if near else ""
    return f"unknown {what} '{name}'{hint} (there are: {', '.join(known)})"


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
