"""An output file is whole or not there, and nothing else in its folder changes."""

import os
import stat

import pytest

from renderer.core.errors import RenderError, UsageError
from renderer.io import files


def listing(folder):
    """Return the names in a folder."""
    return sorted(os.listdir(folder))


def test_new_file_appears_when_the_block_ends(tmp_path):
    """Until then the folder shows no file of that name."""
    target = tmp_path / "new.ppm"
    with files.replacing(target) as file:
        file.write(b"whole")
        assert not target.exists()
    assert target.read_bytes() == b"whole"
    assert listing(tmp_path) == ["new.ppm"]


@pytest.mark.parametrize("trouble", [ValueError, KeyboardInterrupt, SystemExit, MemoryError])
def test_failure_in_the_middle_keeps_the_old_file(tmp_path, trouble):
    """Whatever ends the block early, the old contents stay and no temporary file does."""
    target = tmp_path / "old.ppm"
    target.write_bytes(b"old")
    with pytest.raises(trouble), files.replacing(target) as file:
        file.write(b"half of the new")
        file.flush()
        raise trouble
    assert target.read_bytes() == b"old"
    assert listing(tmp_path) == ["old.ppm"]


def test_failing_rename_leaves_no_temporary(tmp_path, monkeypatch):
    """The last step may fail too."""
    def refuse(source, target):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(RenderError, match="out.ppm: cannot be written: Operation not permitted"):
        with files.replacing(tmp_path / "out.ppm") as file:
            file.write(b"x")
    assert listing(tmp_path) == []


def test_folder_removed_meanwhile_is_an_error(tmp_path):
    """A folder that vanished while rendering is a failure with the path, not a crash."""
    with pytest.raises(RenderError, match="gone/out.ppm: cannot be written"):
        with files.replacing(tmp_path / "gone" / "out.ppm"):
            pass


def test_new_file_has_the_users_usual_permissions(tmp_path):
    """The umask counts, unlike with the usual temporary files, which only their owner can read."""
    former = os.umask(0o027)
    try:
        with files.replacing(tmp_path / "out.ppm"):
            pass
    finally:
        os.umask(former)
    assert stat.S_IMODE((tmp_path / "out.ppm").stat().st_mode) == 0o640


def test_existing_file_keeps_its_permissions(tmp_path):
    """A picture that was private stays private."""
    target = tmp_path / "out.ppm"
    target.write_bytes(b"")
    target.chmod(0o600)
    with files.replacing(target) as file:
        file.write(b"x")
    assert stat.S_IMODE(target.stat().st_mode) == 0o600


def test_symbolic_link_is_followed(tmp_path):
    """The link stays a link and the file it points to gets the new contents."""
    (tmp_path / "far").mkdir()
    (tmp_path / "link.ppm").symlink_to(tmp_path / "far" / "real.ppm")
    with files.replacing(tmp_path / "link.ppm") as file:
        file.write(b"x")
    assert (tmp_path / "link.ppm").is_symlink()
    assert (tmp_path / "far" / "real.ppm").read_bytes() == b"x"


def test_device_is_written_not_replaced():
    """Renaming a picture over /dev/null would break the machine."""
    with files.replacing("/dev/null") as file:
        file.write(b"x")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


def test_file_name_of_greatest_length_works(tmp_path):
    """The temporary name is not longer than what the folder accepts."""
    target = tmp_path / ("x" * 251 + ".ppm")
    files.check_writable(target)
    with files.replacing(target) as file:
        file.write(b"x")
    assert target.read_bytes() == b"x"


def test_unfinished_writes_can_be_removed_from_outside(tmp_path):
    """A process that must leave at once cleans up what is half-written."""
    with pytest.raises(RenderError), files.replacing(tmp_path / "out.ppm") as file:
        file.write(b"half")
        assert len(listing(tmp_path)) == 1
        files.remove_unfinished()
        assert listing(tmp_path) == []
    assert listing(tmp_path) == []


def test_check_changes_nothing(tmp_path):
    """Asking whether a file can be written neither creates nor touches it."""
    old = tmp_path / "old.ppm"
    old.write_bytes(b"old")
    before = old.stat()
    files.check_writable(old)
    files.check_writable(tmp_path / "new.ppm")
    assert listing(tmp_path) == ["old.ppm"]
    assert (old.read_bytes(), old.stat().st_mtime_ns, old.stat().st_ino) == (b"old", before.st_mtime_ns, before.st_ino)


@pytest.mark.parametrize("name, message", [
    ("nowhere/out.ppm", "there is no folder"),
    (".", "it is a folder"),
    ("new/", "it is a folder"),
    ("x" * 256 + ".ppm", "File name too long"),
    ("plain.txt/out.ppm", "Not a directory"),
], ids=["missing folder", "folder", "trailing slash", "long name", "file as folder"])
def test_unusable_place_is_told(tmp_path, name, message):
    """Each reason has its message, with the path as given."""
    (tmp_path / "plain.txt").write_text("")
    path = os.path.join(tmp_path, name)
    with pytest.raises(UsageError) as caught:
        files.check_writable(path)
    assert str(caught.value).startswith(f"{path}: cannot be written: ")
    assert message in str(caught.value)


def test_write_protected_file_is_told(tmp_path, monkeypatch):
    """A file that its owner protected is not replaced behind his back (root may, so the answer is put in by hand)."""
    target = tmp_path / "out.ppm"
    target.write_bytes(b"")
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    with pytest.raises(UsageError, match="write-protected"):
        files.check_writable(target)


def test_folder_that_refuses_new_files_is_told():
    """/proc refuses new files to everybody, root included."""
    with pytest.raises(UsageError, match="/proc/out.ppm: cannot be written: the folder takes no new files"):
        files.check_writable("/proc/out.ppm")
