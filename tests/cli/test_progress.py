"""Progress is one tidy line on a terminal, plain lines in a pipe, and nothing where nobody wants it."""

import io
import os
import re

import pytest

from renderer.progress import ERASE_LINE, PLAIN_INTERVAL, SHOW_AFTER, Progress


class Screen(io.StringIO):
    """A stream that says that it is a terminal, of unknown width."""

    encoding = "utf-8"

    def isatty(self):
        return True


class Clock:
    """Seconds that pass when told."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def steps(stream, times, total):
    """Report one sample more at each of the times (seconds from the start); returns the progress."""
    clock = Clock()
    progress = Progress(stream, clock)
    for done, seconds in enumerate(times, 1):
        clock.now = 100.0 + seconds
        progress(done, total)
    return progress


def test_piped_progress_is_lines():
    """A log gets readable lines every few seconds, without control characters."""
    log = io.StringIO()
    steps(log, [PLAIN_INTERVAL * 0.5 * count for count in range(1, 7)], 12).close()
    assert log.getvalue() == (
        " 17 % rendered, 5 s elapsed, 25 s left\n"
        " 33 % rendered, 10 s elapsed, 20 s left\n"
        " 50 % rendered, 15 s elapsed, 15 s left\n")


def test_time_left_does_not_count_the_compilation():
    """A minute before the first sample says nothing about the speed of the others."""
    log = io.StringIO()
    steps(log, [60, 66], 10)
    assert log.getvalue().splitlines()[-1].endswith("1 min 06 s elapsed, 48 s left")


def test_short_first_pass_tells_no_time_left():
    """Compilation for a hundredth of the picture is no reason to announce an hour."""
    log, screen = io.StringIO(), Screen()
    for stream in (log, screen):
        steps(stream, [36], 100)
    assert log.getvalue() == "  1 % rendered, 36 s elapsed, time left unknown\n"
    assert re.fullmatch(r"  1 % \|.+\| 00:36", screen.getvalue().split(ERASE_LINE)[-1])


def test_long_first_pass_tells_time_left():
    """Whoever renders two samples of ten minutes is told after the first one."""
    log = io.StringIO()
    steps(log, [600], 2)
    assert log.getvalue() == " 50 % rendered, 10 min 00 s elapsed, 10 min 00 s left\n"


@pytest.mark.parametrize("seconds, words", [(59.6, "1 min 00 s"), (125, "2 min 05 s"), (7260, "2 h 01 min")])
def test_long_times_are_written_for_people(seconds, words):
    """Nobody wants to divide by 60."""
    log = io.StringIO()
    steps(log, [seconds], 2)
    assert f", {words} elapsed" in log.getvalue()


def test_short_render_shows_nothing():
    """What takes less than a second needs no bar."""
    screen = Screen()
    steps(screen, [0.2, 0.5, SHOW_AFTER * 0.99], 9).close()
    assert screen.getvalue() == ""


def test_terminal_shows_one_line_in_place():
    """Every update overwrites the one before, with percent, elapsed and remaining time."""
    screen = Screen()
    steps(screen, [1, 2, 3], 10)
    shown = screen.getvalue().split(ERASE_LINE)
    assert len(shown) == 4 and "\n" not in screen.getvalue()
    assert re.fullmatch(r" 30 % \|.+\| 00:03, 00:07 left", shown[-1])
    assert len(shown[-1]) < 80


def test_bar_is_removed_at_the_end():
    """The line after it starts on a clean one, also after a failure in the middle."""
    screen = Screen()
    steps(screen, [1, 2], 10).close()
    assert screen.getvalue().endswith(ERASE_LINE)


def test_bar_of_a_plain_terminal_is_ascii():
    """A terminal without Unicode is not sent blocks."""
    screen = Screen()
    screen.encoding = "ascii"
    steps(screen, [2, 3], 10)
    assert screen.getvalue().isascii() and "#" in screen.getvalue()


def test_updates_are_not_too_many():
    """Thousands of short passes do not become thousands of writes."""
    screen = Screen()
    steps(screen, [SHOW_AFTER + 0.001 * count for count in range(1000)], 2000)
    assert 5 <= screen.getvalue().count(ERASE_LINE) <= 11


def test_quiet_progress_writes_nowhere(capsys):
    """Without a stream, calls cost nothing and change nothing."""
    steps(None, [1, 20, 300], 5).close()
    assert capsys.readouterr() == ("", "")


def test_lost_reader_does_not_stop_the_render():
    """A log that cannot be written is given up."""
    class Lost(io.StringIO):
        def write(self, text):
            raise BrokenPipeError

    steps(Lost(), [10, 20, 30], 5).close()


def test_real_terminal_gets_a_bar_of_its_width():
    """Through a pseudo terminal of 50 columns."""
    import fcntl
    import struct
    import termios

    master, terminal = os.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 50, 0, 0))
    with open(terminal, "w", encoding="utf-8") as stream:
        steps(stream, [2, 3], 10)
        shown = os.read(master, 4096).decode().split(ERASE_LINE)[-1]
    os.close(master)
    assert len(shown) == 49


def test_bar_is_imported_only_when_shown(run_python):
    """A short render does not pay for the library."""
    code = """
import sys
from renderer.progress import Progress
Progress(sys.stderr)(1, 2)
print("tqdm" in sys.modules)
"""
    assert run_python(code).stdout == "False\n"


def test_progress_may_be_a_share():
    """Renders that stop by time or error tell how near they are, in shares of 1."""
    log, clock = io.StringIO(), Clock()
    progress = Progress(log, clock)
    for seconds, share in ((1, 0.1), (6, 0.6)):
        clock.now = 100.0 + seconds
        progress(share, 1.0)
    assert log.getvalue() == " 60 % rendered, 6 s elapsed, 4 s left\n"
