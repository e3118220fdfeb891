"""The one place that names a Dr.Jit backend: the array types every lane function is written in.

The environment variable RENDERER_BACKEND (`llvm` or `cuda`) chooses; unset, CUDA is taken where it works, else LLVM.
The types carry no derivatives, which halves the cost of tracing a kernel.
"""

import os

from renderer.core import llvm
from renderer.core.errors import RenderError

BACKENDS = ("llvm", "cuda")

llvm.prepare()

import drjit as dr  # noqa: E402  (LLVM has to be found first)


def _select():
    """Return the name of the backend to use; raises RenderError where the wish cannot be met."""
    wish = os.environ.get("RENDERER_BACKEND") or None
    working = {"llvm": dr.JitBackend.LLVM, "cuda": dr.JitBackend.CUDA}
    if wish is not None and wish not in working:
        raise RenderError(f"backend '{wish}' is unknown; there are: {', '.join(BACKENDS)}")
    for name in (wish,) if wish else ("cuda", "llvm"):
        if dr.has_backend(working[name]):
            return name
    missing = f"the backend '{wish}' does not work" if wish else "neither CUDA nor LLVM works"
    raise RenderError(f"{missing} here; 'python -m renderer doctor' tells why and what to do")


NAME = _select()

if NAME == "cuda":
    import drjit.cuda as _types
else:
    import drjit.llvm as _types

Bool = _types.Bool
Float = _types.Float
Float64 = _types.Float64
Int32 = _types.Int32
UInt8 = _types.UInt8
UInt32 = _types.UInt32
Vector2f = _types.Array2f
Vector3f = _types.Array3f


def host_bytes(array):
    """Return the raw bytes of an evaluated one-dimensional array, without a detour over numpy where memory is shared."""
    return bytes(array.memview()) if NAME == "llvm" else array.numpy().tobytes()
