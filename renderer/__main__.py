"""`python -m renderer`: the command line as a process. What it does is in `renderer.cli`."""

import os
import sys


def run():
    """Run the command line and end the process with its exit status."""
    try:
        from renderer.cli import main

        status = main()
    except KeyboardInterrupt:  # so early that nothing was there to catch it, or once more while leaving
        status = 130
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError, AttributeError):  # its reader has gone or it was never open: told already
            pass
    # Not sys.exit: Dr.Jit needs 0.04 s to take itself apart, a tenth of a short run, which the system does for nothing.
    os._exit(status)


if __name__ == "__main__":
    run()
