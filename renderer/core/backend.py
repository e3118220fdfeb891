"""The one place that names a Dr.Jit backend: the array types every lane function is written in.

The environment variable RENDERER_BACKEND (`llvm` or `cuda`) chooses; unset, CUDA is taken where it works, else LLVM.
The types carry no derivatives, which halves the cost of tracing a kernel.
"""

import os

import drjit as dr

from renderer.core import llvm
from renderer.core.errors import RenderError

BACKENDS = ("llvm", "cuda")


def _trouble(name):
    """Return why a backend does not work here, or None where it does."""
    if name == "cuda":
        return None if dr.has_backend(dr.JitBackend.CUDA) else "no NVIDIA GPU with a driver was found"
    # judged by name first: an LLVM that is too old loads, and ends the process by a signal later
    trouble = llvm.problem()
    if trouble or not dr.has_backend(dr.JitBackend.LLVM):
        return trouble or "LLVM was not found, or cannot be loaded"
    return llvm.check_version(dr.detail.llvm_version())


def _select():
    """Return the name of the backend to use; raises RenderError where the wish cannot be met."""
    wish = os.environ.get("RENDERER_BACKEND") or None
    if wish is not None and wish not in BACKENDS:
        raise RenderError(f"backend '{wish}' is unknown; there are: {', '.join(BACKENDS)}")
    troubles = {}
    for name in (wish,) if wish else ("cuda", "llvm"):
        trouble = _trouble(name)
        if trouble is None:
            return name
        troubles[name] = trouble
    told = "; ".join(f"{name}: {trouble}" for name, trouble in troubles.items())
    raise RenderError(f"no backend works here ({told}); 'python -m renderer doctor' tells what to do")


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
ArrayXf = _types.ArrayXf  # for gathers of whole records
ArrayXu = _types.ArrayXu
Vector2f = _types.Array2f
Vector3f = _types.Array3f


def new_scope():
    """Let what follows be ordered in its kernel as if nothing had been recorded before.

    Kernels place literals by when these were first used; recorded again without this, the same kernel may not be found.
    """
    dr.detail.new_scope(dr.JitBackend.LLVM if NAME == "llvm" else dr.JitBackend.CUDA)


def from_host(kind, host):
    """Return a contiguous numpy array as an evaluated, aligned one of the type `kind`.

    `kind(host)` borrows numpy's memory, which need not be aligned: packet gathers from it become single ones.
    """
    array = kind(host) + dr.opaque(kind, 0)
    dr.eval(array)
    return array


def host_bytes(array):
    """Return the raw bytes of an evaluated flat array, without a detour over numpy where memory is shared."""
    return bytes(array.memview()) if NAME == "llvm" else array.numpy().tobytes()
