"""Code in a process of its own: what a wrong kernel does to it must not end the tests."""

import subprocess
import sys

SECONDS = 100


class Died(Exception):
    """The process was ended by a signal: it read outside of its memory, or LLVM refused the kernel."""


def run_alone(code, root):
    """Run Python code in the checkout; raises Died, or AssertionError with what it told where it failed otherwise."""
    run = subprocess.run([sys.executable, "-c", code], cwd=root, timeout=SECONDS, capture_output=True, text=True)
    if run.returncode < 0:
        raise Died(f"signal {-run.returncode}")
    assert run.returncode == 0, run.stderr[-2000:]
