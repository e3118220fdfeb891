"""What every test stands on: a usable LLVM, the coursework's files, and a checkout that no test writes to."""

import os
import sys
from pathlib import Path

import pytest

from renderer.core import llvm, llvm_trial

ROOT = Path(__file__).resolve().parent.parent
COURSEWORK = ROOT.parent / "shared" / "coursework"
WRITABLE = {".pytest_cache", ".hypothesis", "__pycache__", ".venv"}  # what tools keep in the checkout
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_guard = {"active": False}


def pytest_addoption(parser):
    """Offer Dr.Jit's own checks of every read and write."""
    parser.addoption("--jit-debug", action="store_true", help="run with Dr.Jit's debug mode, which checks all accesses")


def pytest_configure(config):
    """Choose LLVM before anything imports Dr.Jit, and keep the suite's kernels out of the user's cache."""
    llvm.prepare()
    if llvm.problem() and os.environ.get("RENDERER_BACKEND") != "cuda":
        pytest.exit(f"{llvm.problem()}; `make test` sees to it", returncode=pytest.ExitCode.USAGE_ERROR)
    if hasattr(config, "cache"):
        os.environ.setdefault("DRJIT_CACHE_DIR", str(config.cache.mkdir("kernels")))
    if config.getoption("--jit-debug"):
        import drjit as dr

        dr.set_flag(dr.JitFlag.Debug, True)


def pytest_collection_modifyitems(items):
    """Skip what needs a GPU where there is none."""
    on_gpu = [item for item in items if item.get_closest_marker("gpu")]
    trial = llvm_trial.try_cuda() if on_gpu else None
    for item in on_gpu if trial and not trial.works else ():
        item.add_marker(pytest.mark.skip(reason=f"no GPU: {trial.reason}"))


def pytest_sessionstart():
    """Start to watch for files that are opened for writing inside the checkout."""
    sys.addaudithook(_refuse_writes_into_checkout)
    _guard["active"] = True


def pytest_sessionfinish():
    """Stop watching: an audit hook cannot be removed."""
    _guard["active"] = False


def is_forbidden_write(path, flags):
    """Return whether a test opens a file of the checkout for writing."""
    if not isinstance(path, (str, bytes, os.PathLike)) or not flags & WRITING:
        return False
    try:
        inside = Path(os.path.abspath(os.fsdecode(path))).relative_to(ROOT)
    except ValueError:
        return False
    return not WRITABLE & set(inside.parts)


def _refuse_writes_into_checkout(event, arguments):
    """Fail the test that writes anywhere but to `tmp_path`: such files end up in commits and in other tests."""
    if event == "open" and _guard["active"] and is_forbidden_write(arguments[0], arguments[2]):
        raise PermissionError(f"tests write only to tmp_path, not to {arguments[0]}")


@pytest.fixture(scope="session")
def root():
    """The checkout."""
    return ROOT


@pytest.fixture(scope="session")
def coursework():
    """The folder with the coursework's four original scene files."""
    if not COURSEWORK.is_dir():
        pytest.skip(f"the coursework's original files are not beside this checkout ({COURSEWORK})")
    return COURSEWORK
