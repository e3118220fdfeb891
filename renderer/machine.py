"""What the machine offers, as far as it tells: cores, free memory, the name of the GPU. Nothing here raises."""

from __future__ import annotations

import os
from pathlib import Path

TOOL_LIMIT = 20.0  # seconds for the driver's own tool


def usable_cores() -> int:
    """Return how many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except (AttributeError, OSError):  # not on every system
        return os.cpu_count() or 1


def available_memory() -> int | None:
    """Return the bytes that can be had without swapping, within the limit of a container; None where unknown."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        free = next(int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration, ValueError, IndexError):
        return None
    try:
        limit, used = (int(Path("/sys/fs/cgroup", name).read_text()) for name in ("memory.max", "memory.current"))
        return min(free, max(limit - used, 0))
    except (OSError, ValueError):  # no container, or "max"
        return free


def gpu_name() -> str:
    """Return what the driver's tool says the GPU is."""
    import subprocess  # a few milliseconds, and renders ask for memory only

    try:
        done = subprocess.run(["nvidia-smi", "--query-gpu=name,memory.total", "--format=csv,noheader"],
                              timeout=TOOL_LIMIT, capture_output=True, text=True, errors="replace",
                              stdin=subprocess.DEVNULL)
        return done.stdout.strip().splitlines()[0] if done.returncode == 0 else "unnamed"
    except (OSError, IndexError, subprocess.TimeoutExpired):
        return "unnamed"
