"""The command line as a process of its own: pipes, signals, imports, and no traceback whatever happens."""

import os
import re
import signal
import subprocess
import sys
import time

import OpenEXR
import pytest

HEAVY = ("numpy", "drjit", "pydantic", "PIL", "OpenEXR", "tqdm", "mitsuba")
ENDLESS = ["--samples", "16000000", "--size", "300x200"]  # hours of work
# Ctrl-C while the binary part of Dr.Jit defines its enumerations: an exception there aborts the process.
WHILE_IMPORTING = """
import runpy, signal, sys

def interrupt(frame, event, argument):
    if event == "call" and frame.f_code.co_filename.endswith("enum.py"):
        sys.setprofile(None)
        signal.raise_signal(signal.SIGINT)

class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == "drjit._drjit_ext":
            sys.setprofile(interrupt)

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Interrupting())
sys.argv = ["renderer", "small.json"]
runpy.run_module("renderer", run_name="__main__", alter_sys=True)
"""
# A stand-in engine with a first pass, and a second that hangs.
STUBBORN = """
import hashlib, sys
from renderer import cli

def block(loaded, *, interrupted, **settings):
    interrupted()
    print("a pass is done", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"x", b"y", 2**31 - 1)

cli._load_engine = lambda backend, threads: block
sys.exit(cli.main(["small.json"]))
"""
# A stand-in engine that keeps the main thread inside a call of C, as a long kernel does.
BLOCKED = """
import hashlib, sys
from renderer import cli

def block(loaded, **settings):
    print("blocked", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"x", b"y", 2**31 - 1)

cli._load_engine = lambda backend, threads: block
sys.exit(cli.main(["small.json"]))
"""


def finished(process, timeout=60):
    """Return exit status, standard output and standard error, once the process is done; it never shows a traceback."""
    try:
        out, err = process.communicate(timeout=timeout)
    finally:
        process.kill()
    said = err.decode()
    assert "Traceback" not in said and "Exception ignored" not in said
    return process.returncode, out, said


def test_picture_is_rendered(scene, start):
    """From a scene file to a PPM, through the real engine."""
    status, _, said = finished(start(scene))
    assert status == 0, said
    assert re.match(r"small\.ppm: 6 x 4, phong, 1 sample a pixel; built in ", said)
    assert os.path.getsize("small.ppm") == len(b"P6\n6 4\n255\n") + 6 * 4 * 3


def test_standard_output_gets_the_picture_and_nothing_else(scene, start):
    """`-o -` gives the very bytes of the file."""
    status, out, said = finished(start(scene, "-o", "-", "-o", "copy.ppm", stdout=subprocess.PIPE))
    assert status == 0, said
    with open("copy.ppm", "rb") as file:
        assert out == file.read()
    assert said.startswith("standard output, copy.ppm: ")


def test_closed_pipe_is_no_crash(scene, start):
    """The reader of the picture goes away before it is written."""
    process = start(scene, "--size", "600x400", "-o", "-", stdout=subprocess.PIPE)
    process.stdout.close()
    process.stdout = None
    status, _, said = finished(process)
    assert (status, said) == (1, "standard output: its reader closed it before everything was written\n")


@pytest.mark.parametrize("unbuffered", ["", "1"], ids=["buffered", "unbuffered"])
@pytest.mark.parametrize("arguments", [["--help"], ["schema"], ["small.json", "-o", "-"]], ids=" ".join)
def test_full_standard_output_is_told(scene, start, arguments, unbuffered):
    """A disk that is full is an error, not silence."""
    with open("/dev/full", "wb") as full:
        status, _, said = finished(start(*arguments, stdout=full, env={"PYTHONUNBUFFERED": unbuffered}))
    assert (status, said) == (1, "standard output: cannot be written: No space left on device\n")


def test_threads_and_backend_are_taken(scene, start):
    """One thread on LLVM gives the same picture as all of them."""
    assert finished(start(scene, "-o", "all.ppm"))[0] == 0
    status, _, said = finished(start(scene, "-o", "one.ppm", "--threads", "1", "--backend", "llvm"))
    assert status == 0, said
    with open("all.ppm", "rb") as everything, open("one.ppm", "rb") as one:
        assert everything.read() == one.read()


def test_unknown_backend_of_the_environment_is_told(scene, start):
    """The failure to set Dr.Jit up is a sentence, with status 1."""
    status, _, said = finished(start(scene, env={"RENDERER_BACKEND": "abacus"}))
    assert status == 1 and len(said.splitlines()) == 1 and "abacus" in said
    assert not os.path.exists("small.ppm")


def interrupted(process, after):
    """Send Ctrl-C some seconds after the start; return status, message and the seconds it took to end."""
    time.sleep(after)
    assert process.poll() is None, process.stderr.read().decode()
    process.send_signal(signal.SIGINT)
    sent = time.monotonic()
    status, _, said = finished(process)
    return status, said, time.monotonic() - sent


def test_interrupt_keeps_the_picture_so_far(scene, interruptible):
    """Ctrl-C gives 130 soon, a whole picture, and the number of its samples."""
    process = interruptible(sys.executable, "-m", "renderer", scene, *ENDLESS, "-o", "x.exr", "-o", "x.ppm")
    status, said, seconds = interrupted(process, 3.0)
    assert status == 130
    assert "interrupted; writing the picture so far" in said
    samples = re.search(r"interrupted after (\d+) samples a pixel\n$", said)[1]
    assert 1 < int(samples) < 16_000_000
    assert seconds < 10  # hours, were the signal lost
    assert sorted(os.listdir(".")) == [scene, "x.exr", "x.ppm"]
    assert OpenEXR.File("x.exr").header()["renderer.samples"] == samples
    assert os.path.getsize("x.ppm") == len(b"P6\n300 200\n255\n") + 300 * 200 * 3


def test_second_interrupt_leaves_nothing_behind(scene, interruptible):
    """Whoever presses Ctrl-C again does not want the picture."""
    process = interruptible(sys.executable, "-c", STUBBORN, stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"a pass is done\n"
    process.send_signal(signal.SIGINT)
    time.sleep(1.5)  # three times the grace that a signal without a picture has
    status, said, seconds = interrupted(process, 0.0)
    assert (status, said.splitlines()[-1]) == (130, "interrupted; no picture was left unfinished")
    assert seconds < 10
    assert os.listdir(".") == [scene]


def test_interrupt_while_importing_is_orderly(scene, run_python):
    """Ctrl-C in the first moments is not a crash either."""
    process = run_python(WHILE_IMPORTING)
    assert (process.returncode, process.stderr) == (130, "interrupted; no picture was left unfinished\n")


def test_interrupt_does_not_wait_for_a_kernel(scene, interruptible):
    """Also a main thread that is stuck in a kernel for minutes is left at once."""
    process = interruptible(sys.executable, "-c", BLOCKED, stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"blocked\n"
    status, said, seconds = interrupted(process, 0.2)
    assert (status, said) == (130, "\ninterrupted; no picture was left unfinished\n")
    assert seconds < 10
    assert os.listdir(".") == [scene]


def test_ignored_interrupt_stays_ignored(scene, run_python):
    """Under nohup or in a script's background Ctrl-C is not meant for us."""
    code = """
import signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
from renderer.interrupt import prompt_interrupt
with prompt_interrupt():
    signal.raise_signal(signal.SIGINT)
print(signal.set_wakeup_fd(-1))
"""
    assert run_python(code).stdout == "-1\n"


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["x.json", "--mode", "no"], ["absent.json"]], ids=" ".join)
def test_nothing_heavy_is_imported_without_need(run_python, tmp_path, arguments):
    """Help and complaints must not wait for libraries."""
    code = f"""
import sys
from renderer import cli
try:
    cli.main(sys.argv[1:])
except SystemExit:
    pass
print("loaded:", [name for name in {HEAVY} if name in sys.modules])
"""
    assert run_python(code, *arguments, cwd=tmp_path).stdout.endswith("loaded: []\n")


def test_ppm_needs_no_image_library(scene, run_python):
    """The common run loads neither numpy nor Pillow nor OpenEXR."""
    code = """
import sys
from renderer import cli
status = cli.main(["small.json"])
print(status, [name for name in ("numpy", "PIL", "OpenEXR", "tqdm", "pydantic") if name in sys.modules])
"""
    assert run_python(code).stdout == "0 []\n"


def test_terminal_is_not_filled_with_bytes(scene, start):
    """A picture is not written to a terminal."""
    master, terminal = os.openpty()
    try:
        status, _, said = finished(start(scene, "-o", "-", stdout=terminal))
    finally:
        os.close(terminal)
        os.close(master)
    assert status == 2 and said.startswith("standard output is a terminal")
