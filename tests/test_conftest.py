"""The guard of the checkout is tested too: it must refuse what it is there for, and nothing else."""

import os

import pytest

from tests.conftest import WRITABLE, is_forbidden_write


def test_writing_into_the_checkout_is_refused(root):
    """Opening a file of the checkout for writing fails at the place where it is done."""
    with pytest.raises(PermissionError, match="only to tmp_path"):
        open(root / "left-behind.txt", "w")
    assert not (root / "left-behind.txt").exists()


def test_reading_the_checkout_is_allowed(root):
    """Tests read scenes and sources."""
    assert (root / "pyproject.toml").read_text().startswith("[build-system]")


def test_writing_to_tmp_path_is_allowed(tmp_path):
    """A test's own folder is writable."""
    (tmp_path / "mine.txt").write_text("kept")
    assert (tmp_path / "mine.txt").read_text() == "kept"


@pytest.mark.parametrize("folder", sorted(WRITABLE))
def test_caches_of_tools_are_writable(root, folder):
    """Compiled modules and pytest's cache lie in the checkout."""
    assert not is_forbidden_write(str(root / folder / "file"), os.O_WRONLY)
