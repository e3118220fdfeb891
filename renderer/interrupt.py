"""Ctrl-C that answers at once, also while a kernel runs.

Python raises KeyboardInterrupt only between its own instructions, and a kernel may keep the main thread away from
them for minutes. The operating system's signal still arrives: a thread waits for it, gives the program a moment to
leave in order, and otherwise ends the process. That is safe because output files are only ever renamed into place.

As soon as there is a picture worth keeping, the first Ctrl-C asks the render to stop after its pass, and the second one
is like the first before.
"""

import os
import signal
import threading
from contextlib import contextmanager

from renderer.core.errors import EXIT_INTERRUPTED
from renderer.io.files import remove_unfinished

GRACE = 0.5  # seconds for an orderly exit
MESSAGE = "interrupted; no picture was left unfinished"
STOPPING = "interrupted; writing the picture so far (Ctrl-C again leaves without it)"


class Interrupt:
    """Whether Ctrl-C was pressed while there was something to keep."""

    def __init__(self):
        self._keeps = False  # whether there is a picture to keep
        self._heard = False  # by the thread that waits for signals
        self.asked = False  # whether to stop

    def after_pass(self):
        """Return whether to stop after the pass that has just ended; from now on there is a picture to keep."""
        self._keeps = True
        return self.asked

    def handle(self, number, frame):
        """Handle the signal in the main thread."""
        if not self._keeps or self.asked:
            raise KeyboardInterrupt
        self.asked = True
        try:
            os.write(2, f"\n{STOPPING}\n".encode())
        except OSError:  # nobody listens
            pass

    def is_patient(self):
        """Return whether the signal that the waiting thread has just received leaves the render its time."""
        patient, self._heard = self._keeps and not self._heard, True
        return patient


@contextmanager
def prompt_interrupt():
    """While the block runs, Ctrl-C ends the process within GRACE seconds with the status EXIT_INTERRUPTED.

    Yields the Interrupt that a render asks after its passes. Does nothing outside the main thread, where Python does
    not deliver signals, and where Ctrl-C is ignored.
    """
    in_main = threading.current_thread() is threading.main_thread()
    if not in_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield Interrupt()
        return
    interrupt = Interrupt()
    receiving, sending = os.pipe()
    os.set_blocking(sending, False)  # a signal handler must not wait
    finished = threading.Event()
    former = signal.set_wakeup_fd(sending, warn_on_full_buffer=False)
    watcher = threading.Thread(target=_watch, args=(receiving, finished, interrupt), daemon=True)
    watcher.start()
    before = signal.signal(signal.SIGINT, interrupt.handle)
    try:
        yield interrupt
    finally:
        signal.signal(signal.SIGINT, before)
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


def _watch(receiving, finished, interrupt):
    """Wait for the signal or the end of the block; end the process if the one is not soon followed by the other."""
    while received := os.read(receiving, 1):
        if received[0] != signal.SIGINT or interrupt.is_patient():
            continue
        if not finished.wait(GRACE):
            remove_unfinished()
            try:
                os.write(2, f"\n{MESSAGE}\n".encode())
            finally:
                os._exit(EXIT_INTERRUPTED)
