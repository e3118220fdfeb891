"""Finds the LLVM library for Dr.Jit before Dr.Jit is imported.

Dr.Jit loads LLVM at run time and takes the first library it meets. Versions 15 and 16 then kill the process by a signal
at the first minimum or maximum, and the usual distributions offer 14 or 15. So this module chooses first: the user's
`DRJIT_LIBLLVM_PATH`, else the library that set-up has tried, else the virtual environment's, else the system's.
It runs at every start and is therefore cheap: it asks for files by name, never lists a folder, and loads nothing.
"""

from __future__ import annotations

import os
import re
import sys
from dataclasses import dataclass
from typing import Iterator

VARIABLE = "DRJIT_LIBLLVM_PATH"
OLDEST, NEWEST = 17, 23  # the versions that Dr.Jit 1.5 works with
# 19 is what set-up installs and every measurement was made with; 22 and 23 gave the same bits; the rest by age.
PREFERENCE = (19, 22, 23, 21, 20, 18, 17)
TOO_OLD = (16, 15, 14, 13, 12, 11)
TOO_OLD_REASON = f"Dr.Jit needs LLVM {OLDEST} or newer, and older ones kill the program"
RECORD = "libllvm.txt"  # written into the virtual environment by set-up: the path that it tried with success
ELF_MAGIC, ELF_MACHINE = b"\x7fELF", slice(18, 20)  # bytes 18 and 19 of an ELF file name the processor
MAC_MAGICS = (b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe")
_found: list[str] = []  # what `prepare` itself put into the environment


@dataclass(frozen=True)
class Candidate:
    """A library file that is there: its path, where it belongs, its version by name, and why it will not do.

    `version` is the major version, None where the name does not tell; `problem` is empty for a usable file.
    """

    path: str
    origin: str
    version: int | None
    problem: str = ""


def candidates(*, prefix: str | None = None, system: bool = True) -> list[Candidate]:
    """Return the LLVM libraries of this machine, best first: usable ones, then nameless, then unusable ones.

    `prefix` is the virtual environment to look into (default: the running one); `system=False` looks nowhere else.
    """
    found = {}
    for path, origin in _possible_files(prefix or sys.prefix, system=system):
        if os.path.exists(path):
            found.setdefault(os.path.realpath(path), (path, origin))
    entries = [Candidate(path, origin, version_of(path), check(path) or "") for path, origin in found.values()]
    return sorted(entries, key=lambda entry: (bool(entry.problem), entry.version is None))  # stable


def prepare() -> str | None:
    """Return the path of the LLVM that Dr.Jit will load and put it into the environment; None where there is none.

    What the user set is left alone, good or bad: `problem` judges it. Never raises. Call before `import drjit`.
    """
    chosen = os.environ.get(VARIABLE)
    if chosen:
        return chosen
    tried = recorded()
    for path, _origin in _possible_files(sys.prefix, too_old=False):
        if os.path.exists(path) and check(path) is None and (version_of(path) or path == tried):
            os.environ[VARIABLE] = path
            _found.append(path)
            return path
    return None


def users_choice() -> str | None:
    """Return the library that the user named in the environment, or None where it was `prepare` that did."""
    chosen = os.environ.get(VARIABLE) or None
    return None if chosen in _found else chosen


def problem() -> str | None:
    """Return in plain words why Dr.Jit's LLVM backend cannot be used as things stand, or None. Call after `prepare`."""
    chosen = os.environ.get(VARIABLE)
    if not chosen:
        return f"no LLVM library (version {OLDEST} to {NEWEST}) was found; `make setup` installs one"
    trouble = check(chosen)
    return trouble and f"the LLVM library {chosen} (named by {VARIABLE}) cannot be used: {trouble}"


def check(path: str) -> str | None:
    """Return why the file cannot be Dr.Jit's LLVM, or None. Reads 20 bytes; loads nothing; never raises.

    A name without a folder is left to the system's loader, as Dr.Jit does, and judged by its version only.
    """
    version = version_of(path)
    if version is not None and version < OLDEST:
        return f"LLVM {version} is too old: {TOO_OLD_REASON}"
    if os.path.dirname(path) == "":
        return None
    try:
        head = _head(path)
    except FileNotFoundError:
        return "there is no such file"
    except (OSError, ValueError) as error:
        return f"it cannot be read ({getattr(error, 'strerror', None) or error})"
    return _wrong_format(head)


def check_version(version: tuple[int, ...]) -> str | None:
    """Return why a loaded LLVM (`drjit.detail.llvm_version()`) is unfit, or None: names do not tell all."""
    if tuple(version)[:1] < (OLDEST,):
        return f"LLVM {'.'.join(map(str, version))} was loaded: {TOO_OLD_REASON}"
    return None


def version_of(path: str) -> int | None:
    """Return the major version that the file's name, its link's target or its folder tells, or None."""
    try:
        real = os.path.realpath(path)
    except (OSError, ValueError):
        real = path
    for name in (os.path.basename(path), os.path.basename(real)):
        match = re.match(r"libLLVM[-.](?:so\.|dylib\.)?(\d+)", name)
        if match:
            return int(match[1])
    match = re.search(r"llvm[-@/]?(\d+)(?:\.[\d.]+)?/", real, re.IGNORECASE)
    return int(match[1]) if match else None


def recorded(prefix: str | None = None) -> str | None:
    """Return the library that set-up tried with success in an environment (default: the running one), or None."""
    try:
        with open(os.path.join(prefix or sys.prefix, RECORD), encoding="utf-8") as file:
            return file.read().strip() or None
    except (OSError, ValueError):
        return None


def _possible_files(prefix: str, system: bool = True, too_old: bool = True) -> Iterator[tuple[str, str]]:
    """Yield `(path, origin)` of every place where an LLVM may lie, best first; most of them do not exist."""
    remembered = recorded(prefix)
    if remembered and system:
        yield remembered, "chosen by set-up"
    versions = PREFERENCE + (TOO_OLD if too_old else ())
    places = [(os.path.join(prefix, "lib"), "virtual environment")]
    if system:
        extra = os.environ.get("LD_LIBRARY_PATH", "").split(":")
        places += [(folder, "LD_LIBRARY_PATH") for folder in extra if folder]
    for folder, origin in places:
        for version in versions:
            yield from ((path, origin) for path in _names(folder, version))
    for version in versions if system else ():
        for folder in _system_folders(version):
            yield from ((path, "system") for path in _names(folder, version))
    places += [(folder, "system") for folder in _library_folders() if system]
    yield from ((os.path.join(folder, _plain_name()), origin) for folder, origin in places)


def _names(folder: str, version: int) -> tuple[str, ...]:
    """Return the paths under which distributions keep one version of LLVM in a folder."""
    if sys.platform == "darwin":
        names = (f"libLLVM-{version}.dylib", f"libLLVM.{version}.1.dylib", f"libLLVM.{version}.0.dylib")
    else:
        names = (f"libLLVM-{version}.so", f"libLLVM.so.{version}.1", f"libLLVM.so.{version}.0",
                 f"libLLVM-{version}.so.1")
    if str(version) in folder:
        names += (_plain_name(),)
    return tuple(os.path.join(folder, name) for name in names)


def _system_folders(version: int) -> tuple[str, ...]:
    """Return the folders of Debian, Fedora, Arch, Alpine, Gentoo and Homebrew for one version."""
    if sys.platform == "darwin":
        return tuple(f"{root}/opt/llvm@{version}/lib" for root in ("/opt/homebrew", "/usr/local")) + _library_folders()
    own = (f"/usr/lib/llvm-{version}/lib", f"/usr/lib/llvm{version}/lib", f"/usr/lib64/llvm{version}/lib")
    return _library_folders() + own + (f"/usr/lib/llvm/{version}/lib64",)


def _library_folders() -> tuple[str, ...]:
    """Return the folders in which the system's loader looks for libraries of this processor."""
    if sys.platform == "darwin":
        return tuple(f"{root}/opt/llvm/lib" for root in ("/opt/homebrew", "/usr/local"))
    triple = getattr(sys.implementation, "_multiarch", f"{os.uname().machine}-linux-gnu")
    return (f"/usr/lib/{triple}", "/usr/lib64", "/usr/local/lib64", "/usr/local/lib", "/usr/lib")


def _plain_name() -> str:
    return "libLLVM.dylib" if sys.platform == "darwin" else "libLLVM.so"


def _head(path: str) -> bytes:
    """Return the first 20 bytes of a file."""
    with open(path, "rb") as file:
        return file.read(20)


def _wrong_format(head: bytes) -> str | None:
    """Return what kind of file starts like this, if it is no library for the processor of the running Python."""
    if sys.platform == "darwin":
        return None if head[:4] in MAC_MAGICS else "it is not a shared library"
    if len(head) < ELF_MACHINE.stop or not head.startswith(ELF_MAGIC):
        return "it is not a shared library"
    try:
        own = _head(sys.executable)
    except (OSError, ValueError):
        return None  # an interpreter without a file: nothing to compare with
    if own.startswith(ELF_MAGIC) and own[ELF_MACHINE] != head[ELF_MACHINE]:
        return "it is a library for another kind of processor"
    return None
