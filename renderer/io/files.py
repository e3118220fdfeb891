"""Output files that are either complete or not there: written beside their place, then renamed into it.

A reader of the folder sees the old picture until the new one is whole. Devices and pipes (`/dev/null`, a FIFO) are
written directly: renaming something over them would destroy them.
"""

import itertools
import os
import stat
from contextlib import contextmanager

from renderer.core.errors import RenderError, UsageError

NEW_FILE_MODE = 0o666  # less the user's umask, as for any file a program creates
_number = itertools.count()
_unfinished = set()


def check_writable(path):
    """Return nothing if a file can be put at `path`; nothing is left behind and an existing file is not touched.

    Raises: UsageError naming the path and the reason (no such folder, a folder, no permission, name too long).
    """
    try:
        if _is_special(path):
            return
        if os.path.exists(path) and not os.access(path, os.W_OK):
            raise UsageError(f"{path}: cannot be written: the file is write-protected")
        temporary, descriptor = _create_beside(os.path.realpath(path))
        os.close(descriptor)
        _remove(temporary)
    except IsADirectoryError:
        raise UsageError(f"{path}: cannot be written: it is a folder") from None
    except FileNotFoundError:
        folder = os.path.dirname(os.path.realpath(path))
        why = f"there is no folder {folder}" if not os.path.isdir(folder) else "the folder takes no new files"
        raise UsageError(f"{path}: cannot be written: {why}") from None
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {reason(error)}") from None


@contextmanager
def replacing(path):
    """Yield a binary file that takes the place of `path` when the block ends, and vanishes if the block fails.

    An existing file keeps its permissions, a symbolic link keeps pointing to the new contents.

    Raises: RenderError naming the path and the reason if the system refuses (disk full, folder removed).
    """
    try:
        if _is_special(path):
            with open(path, "wb") as file:
                yield file
            return
        target = os.path.realpath(path)
        temporary, descriptor = _create_beside(target)
        try:
            with os.fdopen(descriptor, "wb") as file:
                yield file
                if os.path.exists(target):
                    os.fchmod(file.fileno(), stat.S_IMODE(os.stat(target).st_mode))
            os.replace(temporary, target)
            _unfinished.discard(temporary)
        except BaseException:  # Ctrl-C included: no half picture stays behind
            _remove(temporary)
            raise
    except BrokenPipeError:
        raise  # whoever reads a FIFO has gone: not a failure of ours
    except OSError as error:
        raise RenderError(f"{path}: cannot be written: {reason(error)}") from error


def remove_unfinished():
    """Remove the temporary files of writes still under way: for a process about to leave without unwinding."""
    for temporary in tuple(_unfinished):
        _remove(temporary)


def reason(error):
    """Return what the system said about an OSError, without number and file name: `No space left on device`."""
    return error.strerror or str(error) or type(error).__name__


def _is_special(path):
    """Return whether `path` is a device, pipe or socket; IsADirectoryError if it is a folder or names none."""
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        if not os.path.basename(path):  # "pictures/"
            raise IsADirectoryError(path) from None
        return False
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(path)
    return not stat.S_ISREG(mode)


def _create_beside(target):
    """Return path and descriptor of a new empty file in the folder of `target` (a rename must not cross disks)."""
    # A short name of its own: the target's name may already have the greatest length.
    temporary = os.path.join(os.path.dirname(target), f".render-{os.getpid()}-{next(_number)}.part")
    os.lstat(os.path.dirname(target) or ".")
    try:
        os.lstat(target)  # a name that is too long is refused here rather than by the rename at the end
    except FileNotFoundError:
        pass
    _unfinished.add(temporary)
    try:
        return temporary, os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, NEW_FILE_MODE)
    except BaseException:
        _unfinished.discard(temporary)
        raise


def _remove(temporary):
    _unfinished.discard(temporary)
    try:
        os.unlink(temporary)
    except FileNotFoundError:
        pass
