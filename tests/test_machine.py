"""What the machine tells, and what is made of it when it tells nothing."""

import os
from pathlib import Path

import pytest

from renderer import machine


@pytest.fixture
def files(monkeypatch):
    """Stand-ins for the system's files, by path; what is not named is not there."""
    texts = {}

    def read_text(path, *arguments, **options):
        if str(path) not in texts:
            raise FileNotFoundError(str(path))
        return texts[str(path)]

    monkeypatch.setattr(Path, "read_text", read_text)
    return texts


def test_cores_are_those_that_may_be_used():
    """A process bound to fewer cores has fewer."""
    if not hasattr(os, "sched_getaffinity"):
        pytest.skip("this system does not bind processes to cores")
    assert machine.usable_cores() == len(os.sched_getaffinity(0))


def test_free_memory_is_in_bytes(files):
    """The kernel counts in kibibytes."""
    files["/proc/meminfo"] = "MemTotal: 8000 kB\nMemAvailable:    2000 kB\n"
    assert machine.available_memory() == 2000 * 1024


def test_limit_of_a_container_counts(files):
    """A container may hold less than its machine has."""
    files["/proc/meminfo"] = "MemAvailable: 2000 kB\n"
    files["/sys/fs/cgroup/memory.max"], files["/sys/fs/cgroup/memory.current"] = "900000\n", "400000\n"
    assert machine.available_memory() == 500000


def test_container_without_limit_does_not_count(files):
    """`max` is what a group without a limit says."""
    files["/proc/meminfo"] = "MemAvailable: 2000 kB\n"
    files["/sys/fs/cgroup/memory.max"], files["/sys/fs/cgroup/memory.current"] = "max\n", "400000\n"
    assert machine.available_memory() == 2000 * 1024


@pytest.mark.parametrize("text", [None, "", "MemAvailable:\n", "MemAvailable: many kB\n"])
def test_silence_is_not_a_number(files, text):
    """Where the system does not tell, nothing is made up."""
    if text is not None:
        files["/proc/meminfo"] = text
    assert machine.available_memory() is None


def test_missing_driver_tool_is_survived(monkeypatch):
    """A GPU without its tool has no name, and that is all."""
    monkeypatch.setenv("PATH", "")
    assert machine.gpu_name() == "unnamed"
