"""Ctrl-C that answers at once, also while a kernel runs.

Python raises KeyboardInterrupt only between its own instructions, and a kernel may keep the main thread away from
them for minutes. The operating system's signal still arrives: a thread waits for it, gives the program a moment to
leave in order, and otherwise ends the process. That is safe because output files are only ever renamed into place.
"""

import os
import signal
import threading
from contextlib import contextmanager

from renderer.core.errors import EXIT_INTERRUPTED
from renderer.io.files import remove_unfinished

GRACE = 0.5  # seconds for an orderly exit
MESSAGE = "interrupted; no picture was left unfinished"


@contextmanager
def prompt_interrupt():
    """While the block runs, Ctrl-C ends the process within GRACE seconds with the status EXIT_INTERRUPTED.

    Does nothing outside the main thread, where Python does not deliver signals, and where Ctrl-C is ignored.
    """
    in_main = threading.current_thread() is threading.main_thread()
    if not in_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    receiving, sending = os.pipe()
    os.set_blocking(sending, False)  # a signal handler must not wait
    finished = threading.Event()
    former = signal.set_wakeup_fd(sending, warn_on_full_buffer=False)
    watcher = threading.Thread(target=_watch, args=(receiving, finished), daemon=True)
    watcher.start()
    try:
        yield
    finally:
        finished.set()
        signal.set_wakeup_fd(former)
        os.close(sending)
        watcher.join()
        os.close(receiving)


@contextmanager
def interrupt_held_back():
    """Ctrl-C waits until the block ends: Dr.Jit aborts the process if its import is interrupted.

    Raises: KeyboardInterrupt at the end of the block if the signal came while it ran.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received = []
    former = signal.signal(signal.SIGINT, lambda *_: received.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, former)
        if received and callable(former):
            raise KeyboardInterrupt


def _watch(receiving, finished):
    """Wait for the signal or the end of the block; end the process if the one is not soon followed by the other."""
    while received := os.read(receiving, 1):
        if received[0] == signal.SIGINT and not finished.wait(GRACE):
            remove_unfinished()
            try:
                os.write(2, f"\n{MESSAGE}\n".encode())
            finally:
                os._exit(EXIT_INTERRUPTED)
