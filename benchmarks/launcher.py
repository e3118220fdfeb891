"""Runs a command and prints, as a last line of JSON, how long it took and how much memory it needed.

A program of its own because Linux counts the memory of the process that starts another one among the other's peak:
started from a process that holds Mitsuba, the smallest program would seem to need 500 MB. This one imports next to
nothing. It is run as a file, without the rest of this package.
"""

import json
import os
import sys
import time


def main(command):
    """Run the command and return its exit status."""
    spawned = time.monotonic()
    child = os.posix_spawn(command[0], command, os.environ)
    _, status, usage = os.wait4(child, 0)
    ended = time.monotonic()
    measured = {"wall": ended - spawned, "cpu": usage.ru_utime + usage.ru_stime, "peak": usage.ru_maxrss * 1024 / 1e6,
                "spawned": spawned, "ended": ended}  # fmt: skip
    print(json.dumps(measured))
    return os.waitstatus_to_exitcode(status)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
