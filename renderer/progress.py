"""How far a render has come: one line kept up to date on a terminal, a plain line now and then elsewhere."""

import os
import time

SHOW_AFTER = 1.0  # seconds: shorter renders show nothing, and do not pay for the import of the bar
TERMINAL_INTERVAL = 0.1  # seconds between two updates on a terminal
PLAIN_INTERVAL = 5.0  # seconds between two lines in a pipe or log
FALLBACK_WIDTH = 80  # columns of a terminal that does not tell
FIRST_TELLS = 0.1  # of the render: a shorter first pass took most of its time to compile, and tells nothing of the rest
BAR_FORMAT = "{percentage:3.0f} % |{bar}| {elapsed}"
TIME_LEFT = ", {remaining} left"
ERASE_LINE = "\r\x1b[K"


class Progress:
    """Called with `(done, total)` between passes; `close()` removes what is on the terminal.

    `stream` is where to write (None for nowhere); `clock` returns seconds.
    """

    def __init__(self, stream, clock=time.monotonic):
        self._stream = stream
        self._clock = clock
        self._start = clock()
        self._on_terminal = stream is not None and stream.isatty()
        self._next = self._start + (SHOW_AFTER if self._on_terminal else PLAIN_INTERVAL)
        self._first = None  # (time, done) of the first call: what came before was set-up and compilation
        self._line_shown = False

    def __call__(self, done, total):
        now = self._clock()
        first_time, first_done = self._first = self._first or (now, done)
        if self._stream is None or now < self._next or done >= total:
            return
        elapsed = now - self._start
        if done > first_done:
            rate = (done - first_done) / (now - first_time)
        else:
            rate = done / elapsed if done >= FIRST_TELLS * total else None
        if self._on_terminal:
            self._next = now + TERMINAL_INTERVAL
            self._write(ERASE_LINE + self._bar(done, total, elapsed, rate))
            self._line_shown = True
        else:
            self._next = now + PLAIN_INTERVAL
            left = f"{_duration((total - done) / rate)} left" if rate else "time left unknown"
            self._write(f"{100 * done / total:3.0f} % rendered, {_duration(elapsed)} elapsed, {left}\n")

    def close(self):
        """Remove the bar from the terminal, so that the next message starts on a clean line."""
        if self._line_shown:
            self._write(ERASE_LINE)
            self._line_shown = False

    def _bar(self, done, total, elapsed, rate):
        """Return the line for a terminal, as wide as that is."""
        from tqdm import tqdm  # costs 0.08 s: only once a render has proved long

        try:
            width = os.get_terminal_size(self._stream.fileno()).columns
        except OSError:
            width = 0
        layout = BAR_FORMAT + TIME_LEFT if rate else BAR_FORMAT
        simple = "utf" not in (self._stream.encoding or "").lower()
        # The last column stays free: writing there makes some terminals start a new line.
        columns = (width or FALLBACK_WIDTH) - 1
        return tqdm.format_meter(done, total, elapsed, columns, rate=rate or None, bar_format=layout, ascii=simple)

    def _write(self, text):
        try:
            self._stream.write(text)
            self._stream.flush()
        except OSError:  # nobody reads it any more: no reason to stop rendering
            self._stream = None


def _duration(seconds):
    """Return seconds in words for people: `42 s`, `3 min 05 s`, `2 h 10 min`."""
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    minutes, seconds = divmod(seconds, 60)
    if minutes < 60:
        return f"{minutes} min {seconds:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
