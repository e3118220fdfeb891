"""How much memory a built hierarchy takes: a process of its own that builds one and looks at its own size.

`python -m benchmarks.mesh_memory MODULE VERTICES FACES` with files of numpy, which make no temporaries. MODULE has
`build`, and is Mitsuba's side if it has `mesh_of` too: then the mesh is made beforehand, and only the scene counts.
Prints as JSON by how many bytes resident memory has grown, and by how many at most while it was built. What is kept for
later use by allocators (Dr.Jit's, the C library's) is given back before. A small mesh is built first, so that
threads, kernels and libraries are there already.
"""

from __future__ import annotations

import ctypes
import gc
import importlib
import json
import sys
import tempfile
from pathlib import Path

import drjit as dr
import numpy as np

from benchmarks.measure import run_process
from benchmarks.mesh_scenes import bumpy

SMALL = 128  # triangles of the mesh that is built first


def grown(module, vertices, faces):
    """Return {kept, peak}: bytes that building in a process of its own takes; a float for tables."""
    with tempfile.TemporaryDirectory() as folder:
        files = Path(folder, "vertices.npy"), Path(folder, "faces.npy")
        for file, array in zip(files, (vertices, faces)):
            np.save(file, array)
        return json.loads(run_process("-m", "benchmarks.mesh_memory", module, *files).output)


def main(name, *files):
    """Build what the files hold, and print what it took."""
    module = importlib.import_module(name)
    _built(module, *bumpy(SMALL))
    made = _made(module, *map(np.load, files))
    _give_back()
    before = _resident("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here on
    accel = module.build(*made)
    dr.sync_thread()
    peak = _resident("VmHWM")
    _give_back()
    print(json.dumps({"kept": _resident("VmRSS") - before, "peak": peak - before}))
    del accel


def _made(module, vertices, faces):
    """Return the arguments of `build`."""
    return (module.mesh_of(vertices, faces),) if hasattr(module, "mesh_of") else (vertices, faces)


def _built(module, vertices, faces):
    """Build, and forget it."""
    module.build(*_made(module, vertices, faces))
    dr.sync_thread()


def _give_back():
    """Return to the system what allocators keep."""
    gc.collect()
    dr.sync_thread()
    dr.flush_malloc_cache()
    ctypes.CDLL(None).malloc_trim(0)


def _resident(field):
    """Return a number of bytes that Linux tells of this process."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(f"{field}:"))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
