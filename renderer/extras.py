"""Packages that only some commands need, and how this Python gets them."""

import shlex
import sys
from pathlib import Path

REQUIREMENTS = Path(__file__).resolve().parent.parent / "requirements"


def install_command(name):
    """Return the command that brings the pinned packages of `requirements/<name>.txt` to the Python that runs this."""
    return shlex.join([sys.executable, "-m", "pip", "install", "-r", str(REQUIREMENTS / f"{name}.txt")])
