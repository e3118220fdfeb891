"""Tries an LLVM library in a process of its own, because a bad one kills the process that loads it.

The trial compiles a minimum, a maximum and a clip: exactly what LLVM 15 and 16 die of. The kernel cache is switched to
an empty folder, since a kernel compiled earlier would hide a library that cannot compile.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass

from renderer.core import llvm

TIME_LIMIT = 60.0  # seconds; a trial takes one, also on a busy machine less than ten
ANSWER = "works with version "  # what the trial program prints before the version
PROGRAM = """
import sys
import drjit as dr
from drjit.{backend} import Float
x = dr.arange(Float, 64)
y = dr.minimum(x, 5) + dr.maximum(x, 7) + dr.clip(x, 2, 3)
dr.eval(y)
if list(y) != [min(i, 5) + max(i, 7) + min(max(i, 2), 3) for i in range(64)]:
    sys.exit("it computes wrong results")
print("{answer}" + ".".join(map(str, dr.detail.{backend}_version())))
"""


DEBIAN_PACKAGES = {"libatomic.so.1": "libatomic1", "libstdc++.so.6": "libstdc++6", "libgcc_s.so.1": "libgcc-s1"}


@dataclass(frozen=True)
class Trial:
    """What a trial showed: whether Dr.Jit computes with the library, the version it reports, else why not."""

    works: bool
    version: str = ""
    reason: str = ""


def try_llvm(path: str, *, python: str = sys.executable, time_limit: float = TIME_LIMIT) -> Trial:
    """Return how Dr.Jit fares with the LLVM library at `path`, under the interpreter `python`. Never raises."""
    return _try("llvm", {llvm.VARIABLE: path}, python, time_limit)


def try_cuda(*, python: str = sys.executable, time_limit: float = TIME_LIMIT) -> Trial:
    """Return how Dr.Jit fares with the NVIDIA driver of this machine. Never raises."""
    return _try("cuda", {}, python, time_limit)


def missing_library(*, python: str = sys.executable, time_limit: float = TIME_LIMIT) -> str | None:
    """Return the name of a system library that Dr.Jit lacks (a bare Debian has no libatomic), or None. Never raises."""
    environment = {name: value for name, value in os.environ.items() if name != llvm.VARIABLE}
    try:
        done = subprocess.run([python, "-c", "import drjit"], env=environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, errors="replace", timeout=time_limit)
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return None
    return missing_in(done.stderr)


def missing_in(messages: str) -> str | None:
    """Return the library that the system's loader could not find, according to its message, or None."""
    match = re.search(r"(?:ImportError: |^)(\w\S*\.so\S*): cannot open shared object file", messages)
    return match and match[1]


def _try(backend: str, settings: dict[str, str], python: str, time_limit: float) -> Trial:
    """Return the outcome of the trial program under one backend."""
    program = PROGRAM.format(backend=backend, answer=ANSWER)
    try:
        with tempfile.TemporaryDirectory() as folder:
            environment = {**os.environ, **settings, "DRJIT_CACHE_DIR": folder}
            done = subprocess.run([python, "-c", program], env=environment, cwd=folder, stdin=subprocess.DEVNULL,
                                  capture_output=True, text=True, errors="replace", timeout=time_limit)
    except subprocess.TimeoutExpired:
        return Trial(False, reason=f"no answer within {time_limit:g} seconds")
    except (OSError, ValueError) as error:
        return Trial(False, reason=f"the trial could not be started: {error}")
    if done.returncode == 0 and ANSWER in done.stdout:
        return Trial(True, version=done.stdout.split(ANSWER)[1].split()[0])
    return Trial(False, reason=_explain(done.returncode, done.stderr))


def _explain(status: int, messages: str) -> str:
    """Return one line about a trial that ended badly."""
    lines = [line.strip() for line in messages.splitlines() if line.strip()]
    if status < 0:
        try:
            name = signal.Signals(-status).name
        except ValueError:
            name = f"signal {-status}"
        told = next((line.split(": 0x")[0] for line in lines if line.startswith("LLVM ERROR")), "")
        return f"the process was killed by {name}" + (f" ({told})" if told else "")
    library = missing_in(messages)
    if library:
        return f"Dr.Jit needs the system library {library}, which is not there"
    if any("No module named 'drjit'" in line for line in lines):
        return "Dr.Jit is not installed"
    if any("backend is inactive" in line for line in lines):
        return "Dr.Jit cannot load it"
    if any("CUDA backend hasn't been initialized" in line for line in lines):
        return "no NVIDIA driver or device"
    return lines[-1] if lines else f"the trial ended with status {status}"
