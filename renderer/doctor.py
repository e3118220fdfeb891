"""`python -m renderer doctor`: what rendering needs, what is there, what is wrong, and the command that mends it.

It has to work where nothing else does: it uses only the standard library, imports Dr.Jit and the other packages in
processes of their own (a bad LLVM kills the process that loads it), and survives the failure of any of its own steps.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from renderer import machine
from renderer.core import llvm, llvm_trial
from renderer.extras import install_command

ROOT = Path(__file__).resolve().parent.parent
OK, NOTE, WARNING, PROBLEM = "ok", "note", "warning", "problem"
OLDEST_PYTHON = (3, 11)
IMPORT_NAMES = {"drjit": "drjit", "numpy": "numpy", "OpenEXR": "OpenEXR", "pillow": "PIL", "scipy": "scipy",
                "tqdm": "tqdm"}
IMPORT_LIMIT = 60.0  # seconds
LITTLE_MEMORY = 2**30  # bytes; the largest of the coursework's pictures takes less than half of this
MEBIBYTE, GIBIBYTE = 2**20, 2**30
USAGE = "usage: python -m renderer doctor\nTells what rendering needs, what is wrong, and how to mend it."


@dataclass(frozen=True)
class Finding:
    """One line of the report, and the command that mends it where something is wrong."""

    mark: str
    subject: str
    text: str
    mend: str = ""


@dataclass(frozen=True)
class Checked:
    """A library with the outcome of its trial."""

    candidate: llvm.Candidate
    trial: llvm_trial.Trial
    chosen: bool


def main(argv: list[str] | None = None) -> int:
    """Print the report and return 0 where rendering will work, else 1 (2 for arguments that it does not have)."""
    if argv:
        print(USAGE)
        return 0 if argv[0] in ("-h", "--help") else 2
    findings = examine()
    try:
        print(report(findings), flush=True)
    except (OSError, ValueError):
        pass  # nobody is reading
    return 1 if any(finding.mark == PROBLEM for finding in findings) else 0


def examine() -> list[Finding]:
    """Return what was found, one finding a line. Never raises."""
    findings = []
    for step in (python_version, packages, backends, processor, kernel_cache, memory):
        try:
            findings += step()
        except Exception as error:  # the doctor itself must not be what fails
            what = step.__name__.replace("_", " ")
            findings.append(Finding(WARNING, what, f"could not be examined: {type(error).__name__}: {error}"))
    return findings


def report(findings: list[Finding]) -> str:
    """Return the findings as aligned lines, then what to do, then the verdict."""
    width = max(len(finding.subject) for finding in findings)
    lines = [f"{finding.mark:8} {finding.subject:{width}}  {finding.text}" for finding in findings]
    commands = list(dict.fromkeys(finding.mend for finding in findings if finding.mend))
    if commands:
        lines += ["", "What to do:", *(f"  {command}" for command in commands)]
    wrong = any(finding.mark == PROBLEM for finding in findings)
    return "\n".join([*lines, "", "Rendering will not work yet." if wrong else "Rendering will work."])


def python_version() -> list[Finding]:
    """Return whether this Python is new enough."""
    text = f"{platform.python_version()}, {sys.executable or 'an interpreter without a file'}"
    if sys.version_info[:2] >= OLDEST_PYTHON:
        return [Finding(OK, "Python", text)]
    return [Finding(PROBLEM, "Python", f"{text}: 3.11 or newer is needed", "make setup PYTHON=/path/to/python3.11")]


def packages() -> list[Finding]:
    """Return whether the pinned packages are there, in their versions, and can be imported."""
    pins = read_pins(ROOT / "requirements" / "run.txt")
    if not pins:
        return [Finding(WARNING, "packages", "requirements/run.txt is not there: nothing to compare versions with")]
    mend, missing, findings, broken = mend_for_packages(), [], [], unimportable()
    for name, pinned in pins.items():
        installed = installed_version(name)
        if installed is None:
            missing.append(name)
        elif name in broken:
            findings.append(unusable(name, broken[name], mend))
        elif installed != pinned:
            findings.append(Finding(WARNING, name, f"{installed} is installed, {pinned} was tested", mend))
    if missing:
        findings.append(Finding(PROBLEM, "packages", f"not installed: {', '.join(missing)}", mend))
    good = len(pins) - len(missing) - sum(finding.subject in pins for finding in findings)
    return [Finding(OK if good else NOTE, "packages", f"{good} of {len(pins)} are installed as tested"), *findings]


def mend_for_packages() -> str:
    """Return the command that brings the pinned packages, or that names the Python which has them."""
    own = ROOT / ".venv" / "bin" / "python"
    if own.exists() and not in_own_environment():
        return f"{own} -m renderer doctor   # the Python that `make setup` prepared; this is another"
    if sys.prefix == sys.base_prefix:  # distributions forbid installing into their own Python
        return f"make -C {ROOT} setup && {own} -m renderer doctor"
    return install_command("run")


def in_own_environment() -> bool:
    """Return whether this Python is the one of the folder `.venv` that `make setup` makes."""
    return Path(sys.prefix).resolve() == (ROOT / ".venv").resolve()


def unusable(name: str, message: str, mend: str) -> Finding:
    """Return the finding about a package that is installed but cannot be imported."""
    library = llvm_trial.missing_in(message)
    if library is None:
        return Finding(PROBLEM, name, f"is installed but cannot be imported: {message}", f"{mend} --force-reinstall")
    package = llvm_trial.DEBIAN_PACKAGES.get(library)
    known = package and Path("/usr/bin/apt-get").exists()
    command = as_root(f"apt-get install {package}") if known else f"install the system package that holds {library}"
    return Finding(PROBLEM, name, f"needs the system library {library}, which is not there", command)


def unimportable() -> dict[str, str]:
    """Return the packages whose import fails, with the message; tried in one process outside this one."""
    program = ("import importlib, sys\nfor item in sys.argv[1:]:\n    package, name = item.split('=')\n    try:\n"
               "        importlib.import_module(name)\n    except BaseException as error:\n"
               "        print(package, ' '.join(str(error.__context__ or error).split()), sep='\\t', flush=True)\n")
    items = [f"{package}={name}" for package, name in IMPORT_NAMES.items()]
    try:
        done = subprocess.run([sys.executable, "-c", program, *items], capture_output=True, text=True, errors="replace",
                              stdin=subprocess.DEVNULL, timeout=IMPORT_LIMIT)
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return {}
    return dict(line.split("\t", 1) for line in done.stdout.splitlines() if "\t" in line)


def backends() -> list[Finding]:
    """Return whether Dr.Jit can compute on the CPU (LLVM) or on a GPU (CUDA), and whether the one wished for works."""
    wish = os.environ.get("RENDERER_BACKEND") or None
    if installed_version("drjit") is None:
        return [Finding(PROBLEM, "LLVM", "not tried, because Dr.Jit is missing")]
    checked = check_libraries()
    gpu = llvm_trial.try_cuda()
    cpu_works = any(one.chosen and one.trial.works for one in checked)
    needed = wish == "llvm" or not gpu.works
    findings = [library_finding(one, needed) for one in checked]
    if not any(one.chosen for one in checked):
        text = f"no usable library (version {llvm.OLDEST} to {llvm.NEWEST}) was found"
        findings.append(Finding(PROBLEM if needed else NOTE, "LLVM", text, mend_for_llvm() if needed else ""))
    elif not cpu_works:
        findings = [with_mend(finding, mend_for_choice(checked)) for finding in findings]
    if gpu.works:
        findings.append(Finding(OK, "CUDA", f"works, version {gpu.version}: {machine.gpu_name()}"))
    else:
        mend = "unset RENDERER_BACKEND" if wish == "cuda" else ""
        findings.append(Finding(PROBLEM if wish == "cuda" else NOTE, "CUDA", f"not used: {gpu.reason}", mend))
    if wish not in (None, "llvm", "cuda"):
        text = f"RENDERER_BACKEND is '{wish}'; there are llvm and cuda"
        findings.append(Finding(PROBLEM, "backend", text, "unset RENDERER_BACKEND"))
    return findings


def check_libraries() -> list[Checked]:
    """Return every LLVM library of this machine with the outcome of its trial; the one Dr.Jit will load is marked."""
    own_choice = llvm.users_choice()
    chosen = llvm.prepare()
    found = llvm.candidates()
    if chosen and not any(one.path == chosen for one in found):
        origin = llvm.VARIABLE if own_choice else "chosen by set-up"
        found.insert(0, llvm.Candidate(chosen, origin, llvm.version_of(chosen), llvm.check(chosen) or ""))
    with ThreadPoolExecutor(max_workers=2) as pool:
        trials = list(pool.map(lambda one: llvm_trial.try_llvm(one.path), found))
    return [Checked(one, trial, one.path == chosen) for one, trial in zip(found, trials)]


def library_finding(one: Checked, needed: bool) -> Finding:
    """Return the line about one library."""
    place = f"{one.candidate.path} ({one.candidate.origin})"
    if one.trial.works:
        return Finding(OK, "LLVM", f"{one.trial.version} works: {place}" + ("" if one.chosen else ", not needed"))
    reason = "; ".join(part for part in (one.candidate.problem, f"tried: {one.trial.reason}") if part)
    if one.chosen:
        return Finding(PROBLEM if needed else WARNING, "LLVM", f"{place} cannot be used: {reason}")
    return Finding(NOTE, "LLVM", f"{place} is not used: {reason}")


def with_mend(finding: Finding, mend: str) -> Finding:
    """Return a finding with a command, if it is one of something wrong."""
    wrong = finding.mark in (PROBLEM, WARNING)
    return Finding(finding.mark, finding.subject, finding.text, mend) if wrong else finding


def mend_for_choice(checked: list[Checked]) -> str:
    """Return the command that replaces a chosen library that does not work."""
    if any(one.chosen and one.candidate.origin == "chosen by set-up" for one in checked):
        return f"rm {Path(sys.prefix) / llvm.RECORD} && make setup"
    working = [one.candidate.path for one in checked if one.trial.works]
    if working:
        return f"export {llvm.VARIABLE}={working[0]}"
    return f"unset {llvm.VARIABLE} && {mend_for_llvm()}"


def mend_for_llvm() -> str:
    """Return the command that brings an LLVM for this Python."""
    if in_own_environment():
        return f"make -C {ROOT} setup"
    if sys.platform == "darwin":
        return "brew install llvm"
    if platform.machine() == "x86_64":
        return install_command("llvm")
    return as_root("apt-get install libllvm19   # or what your distribution calls it")


def processor() -> list[Finding]:
    """Return how many cores this process may use."""
    usable = machine.usable_cores()
    return [Finding(OK, "processor", f"{usable} core{'s' if usable != 1 else ''}, {platform.machine()}")]


def kernel_cache() -> list[Finding]:
    """Return whether compiled kernels can be kept, so that the next start is quick."""
    named, home = os.environ.get("DRJIT_CACHE_DIR"), os.environ.get("HOME")
    advice = f"export DRJIT_CACHE_DIR={Path(tempfile.gettempdir()) / 'drjit-kernels'}"
    slow = "kernels will be compiled again at every start"
    if not named and not home:
        return [Finding(WARNING, "kernel cache", f"HOME is not set: {slow}", advice)]
    folder = Path(named) if named else Path(home) / ".drjit"
    existing = next((place for place in (folder, *folder.parents) if place.exists()), folder)
    try:
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        return [Finding(WARNING, "kernel cache", f"{folder} cannot be written ({error.strerror}): {slow}", advice)]
    sizes = [entry.stat().st_size for entry in folder.glob("*.bin")] if folder.exists() else []
    return [Finding(OK, "kernel cache", f"{folder}, {sum(sizes) / MEBIBYTE:.1f} MiB of kernels")]


def memory() -> list[Finding]:
    """Return how much memory is free, as far as the system tells."""
    free = machine.available_memory()
    if free is None:
        return [Finding(NOTE, "memory", "this system does not tell how much is free")]
    text = f"{free / GIBIBYTE:.1f} GiB free"
    if free < LITTLE_MEMORY:
        return [Finding(WARNING, "memory", f"{text}: large pictures may fail; try a smaller --size")]
    return [Finding(OK, "memory", text)]


def read_pins(path: Path) -> dict[str, str]:
    """Return the versions that a list of pinned packages names; empty where there is no such list."""
    try:
        lines = [line.split("#")[0].split(";")[0].strip() for line in path.read_text(encoding="utf-8").splitlines()]
    except (OSError, ValueError):
        return {}
    return dict(line.split("==", 1) for line in lines if "==" in line)


def installed_version(name: str) -> str | None:
    """Return the version of an installed package, or None."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def as_root(command: str) -> str:
    """Return a command in the form in which this user has to type it."""
    return command if hasattr(os, "geteuid") and os.geteuid() == 0 else f"sudo {command}"
