"""Where and when the numbers were taken."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
import subprocess

from benchmarks.measure import ROOT, run_process

PACKAGES = ("drjit", "mitsuba", "numpy")


def describe():
    """Return the machine, the versions of what was used, the date and the commit."""
    return {
        "cpu": _cpu(), "cores": len(os.sched_getaffinity(0)), "system": platform.system(),
        "llvm": _llvm(), "python": platform.python_version(), **{name: _version(name) for name in PACKAGES},
        "date": datetime.date.today().isoformat(), "commit": _commit(), "load_before": round(os.getloadavg()[0], 2),
    }  # fmt: skip


def _cpu():
    """Return the name of the processor and the widest vectors that it has."""
    name, flags = platform.processor(), ()
    with open("/proc/cpuinfo") as lines:
        for line in lines:
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                name = value.strip()
            if key.strip() == "flags":
                flags = value.split()
    widest = next((text for flag, text in (("avx512f", "AVX-512"), ("avx2", "AVX2")) if flag in flags), None)
    return f"{name} ({widest})" if widest else name


def _llvm():
    """Return the version of the LLVM library that Dr.Jit uses, asked in a process that may die of it."""
    program = "import renderer.core.backend, drjit; print(*drjit.detail.llvm_version(), sep='.')"
    return run_process("-c", program).output


def _version(package):
    """Return the version of an installed package, None if it is not there."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _commit():
    """Return the commit that was measured, with a plus where files differ from it; None outside a repository."""
    try:
        command = ["git", "describe", "--always", "--dirty=+", "--abbrev=12", "--exclude=*"]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None
