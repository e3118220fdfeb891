"""How things are measured: processes by a small launcher, work in this process by its CPU time, and spreads."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
LAUNCHER = Path(__file__).with_name("launcher.py")
TOLD = 5  # last lines of a failed process that are shown


class BenchmarkError(Exception):
    """A measurement that could not be made."""


@dataclass(frozen=True)
class Effort:
    """How much is measured."""

    repeats: int  # of everything that is repeated
    width: int  # of pictures, in pixels
    height: int
    samples: int  # rays a pixel where many are meant
    triangles: int = 1_000_000  # of the largest mesh
    scenes: tuple[str, ...] = ()  # only these, of the benchmarks that take names of scenes; none given: all


FULL = Effort(repeats=9, width=1200, height=800, samples=64)
QUICK = Effort(repeats=3, width=300, height=200, samples=16, triangles=100_000)


@dataclass(frozen=True)
class Finished:
    """A process that has ended well."""

    wall: float  # seconds
    cpu: float  # seconds, all threads, user and system
    peak: float  # largest resident memory, MB (10^6 bytes)
    spawned: float  # time.monotonic() just before it was started
    ended: float  # and when its end was noticed
    output: str


def spread(values):
    """Return {median, min, max} of some measurements."""
    return {"median": statistics.median(values), "min": min(values), "max": max(values)}


def run_process(*arguments, **environment):
    """Return a Finished run of `python ARGUMENTS` in the checkout, with additions to its environment.

    Raises: BenchmarkError with the end of what it said.
    """
    command = [sys.executable, "-I", "-S", str(LAUNCHER), sys.executable, *map(str, arguments)]
    settings = os.environ | {name: str(value) for name, value in environment.items()}
    done = subprocess.run(command, cwd=ROOT, env=settings, capture_output=True, text=True)
    if done.returncode:
        said = "\n".join((done.stdout + done.stderr).strip().splitlines()[-TOLD:])
        raise BenchmarkError(f"'python {' '.join(map(str, arguments))}' ended with status {done.returncode}: {said}")
    *output, told = done.stdout.splitlines()
    return Finished(**json.loads(told), output="\n".join(output))


def interleaved(actions, repeats, calls=1):
    """Return {name: CPU seconds of one call, a list over the repeats} of {name: action}.

    Every action is called once beforehand, so that kernels are compiled. The actions take turns, so that what else
    happens on the machine meets all of them alike.
    """
    for action in actions.values():
        action()
    seconds = {name: [] for name in actions}
    for _ in range(repeats):
        for name, action in actions.items():
            start = time.process_time()
            for _ in range(calls):
                action()
            seconds[name].append((time.process_time() - start) / calls)
    return seconds


def result(figures, **tables):
    """Return what a benchmark found as plain data: the judged figures, and tables as lists of rows."""
    return {"figures": [asdict(figure) for figure in figures], "tables": tables}
