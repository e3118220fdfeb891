"""What the README says is done: its commands run, its files are there, its make targets exist."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
LINES = [line.split("#")[0].strip() for block in re.findall(r"```sh\n(.*?)```", TEXT, re.DOTALL)
         for line in block.splitlines()]
PYTHON = ".venv/bin/python "
SMALL = ["--size", "30x20"]  # added to renders: the last size given counts


@pytest.mark.parametrize("line", [line for line in LINES if line.startswith(PYTHON)])
def test_command_runs(line, tmp_path):
    """Each command ends well in a folder with the scenes, and writes the files that it names."""
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    command = shlex.split(line)
    if "scenes" in line and "renderer" in command:
        command += SMALL
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, *command[1:]], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for place, word in enumerate(command[:-1]):
        assert word != "-o" or (tmp_path / command[place + 1]).stat().st_size > 0


@pytest.mark.parametrize("line", [line for line in LINES if line.startswith("make ")])
def test_make_target_exists(line):
    """Each target can be planned."""
    assert subprocess.run([*shlex.split(line), "-n"], cwd=ROOT, capture_output=True).returncode == 0


def test_no_command_is_left_out():
    """Every line of a block of commands is of a form that these tests know."""
    assert LINES and all(line.startswith((PYTHON, "make ")) for line in LINES)


@pytest.mark.parametrize("name", sorted(set(re.findall(r"\]\(([^)#]+)\)", TEXT) + re.findall(r"^(\w+/) ", TEXT, re.M))))
def test_named_file_is_there(name):
    """Links, the picture and the folders of the tree lead somewhere."""
    assert (ROOT / name).exists()
