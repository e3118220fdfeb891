"""The choice of LLVM: cheap, deaf to nothing the user said, and never an old version that would kill the process."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from renderer.core import llvm

BUDGET = 0.002  # seconds: `prepare` runs at every start


@pytest.fixture
def unset(monkeypatch):
    """No choice of the user's in the environment."""
    monkeypatch.setenv(llvm.VARIABLE, "")  # so that what a test finds is forgotten afterwards
    monkeypatch.delenv(llvm.VARIABLE)
    monkeypatch.delenv("LD_LIBRARY_PATH", raising=False)


@pytest.fixture
def only(monkeypatch, unset, tmp_path):
    """A machine whose only folder of libraries is the `lib` of an empty environment; returns a maker of libraries."""
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(llvm, "_library_folders", tuple)
    monkeypatch.setattr(llvm, "_system_folders", lambda version: ())
    (tmp_path / "lib").mkdir()
    head = Path(sys.executable).read_bytes()[:20]

    def make(name, content=head):
        path = tmp_path / "lib" / name
        path.write_bytes(content)
        return str(path)

    return make


def test_user_choice_is_left_alone(monkeypatch):
    """Even a bad choice of the user's stays what it is: it is judged, not replaced."""
    monkeypatch.setenv(llvm.VARIABLE, "/no/such/libLLVM.so")
    assert llvm.prepare() == "/no/such/libLLVM.so" == os.environ[llvm.VARIABLE]


def test_own_choice_is_not_taken_for_the_users(only, monkeypatch):
    """What `prepare` put into the environment does not bind set-up as the user's word does."""
    path = only("libLLVM-19.so")
    llvm.prepare()
    assert llvm.users_choice() is None
    monkeypatch.setenv(llvm.VARIABLE, path + ".mine")
    assert llvm.users_choice() == path + ".mine"


def test_empty_choice_counts_as_none(only, monkeypatch):
    """A variable set to nothing is how some shells unset it."""
    path = only("libLLVM-19.so")
    monkeypatch.setenv(llvm.VARIABLE, "")
    assert llvm.prepare() == path


def test_choice_reaches_the_environment(only):
    """Dr.Jit reads the variable when it is imported."""
    path = only("libLLVM-19.so")
    assert llvm.prepare() == path == os.environ[llvm.VARIABLE]
    assert llvm.problem() is None


@pytest.mark.parametrize("version", range(llvm.OLDEST, llvm.NEWEST + 1))
def test_every_good_version_is_found(only, version):
    """Each version that works is accepted under the name that Debian gives it."""
    assert llvm.prepare() is None
    path = only(f"libLLVM-{version}.so")
    assert llvm.prepare() == path


@pytest.mark.parametrize("version", llvm.TOO_OLD)
def test_old_version_is_reported_and_not_taken(only, version):
    """What kills the process is listed with the reason, and never chosen."""
    path = only(f"libLLVM-{version}.so")
    assert llvm.prepare() is None
    assert "no LLVM library" in llvm.problem()
    (found,) = llvm.candidates()
    assert (found.path, found.version) == (path, version)
    assert f"LLVM {version} is too old" in found.problem


def test_measured_version_is_preferred(only):
    """The version that everything was measured with wins over newer ones; unusable files come last."""
    for name in ("libLLVM-15.so", "libLLVM-23.so", "libLLVM-19.so"):
        only(name)
    assert [found.version for found in llvm.candidates()] == [19, 23, 15]


def test_recorded_library_comes_first(only, tmp_path):
    """What set-up has tried is taken before anything else, also if its name tells no version."""
    only("libLLVM-19.so")
    tried = only("libLLVM.so")
    (tmp_path / llvm.RECORD).write_text(tried + "\n")
    assert llvm.prepare() == tried


def test_record_of_a_vanished_library_is_ignored(only, tmp_path):
    """A library may be removed after set-up."""
    path = only("libLLVM-19.so")
    (tmp_path / llvm.RECORD).write_text("/removed/libLLVM-19.so\n")
    assert llvm.prepare() == path


def test_nameless_library_is_not_trusted(only):
    """A file whose name tells no version may be an old one: it is a candidate to try, not a choice."""
    path = only("libLLVM.so")
    assert llvm.prepare() is None
    assert [found.path for found in llvm.candidates()] == [path]


def test_text_file_is_not_taken(only):
    """A file that only has the name of a library is passed over."""
    only("libLLVM-19.so", b"GROUP ( libLLVM-19.so.1 )")
    good = only("libLLVM-17.so")
    assert llvm.prepare() == good


def test_system_can_be_ignored(unset, tmp_path):
    """Asked for the environment only, the finder does not see the system's libraries."""
    assert llvm.candidates(prefix=str(tmp_path), system=False) == []


@pytest.mark.parametrize("content, told", [
    (None, "no such file"),
    (b"not a library", "not a shared library"),
    (b"", "not a shared library"),
    (b"\x7fELF\x02\x01\x01" + b"\0" * 11 + b"\xff\xff", "another kind of processor"),
])
def test_bad_file_is_told_in_words(tmp_path, content, told):
    """Each way in which a file can be no library has its own sentence."""
    path = tmp_path / "libLLVM-19.so"
    if content is not None:
        path.write_bytes(content)
    assert told in llvm.check(str(path))


@pytest.mark.parametrize("path", ["/tmp", "/no/such/folder/libLLVM-19.so", "/a\0b/libLLVM-19.so", "/" + "x" * 5000])
def test_strange_paths_do_not_raise(path):
    """Whatever the variable holds, there is a sentence about it."""
    assert llvm.check(path)
    assert llvm.version_of(path) in (None, 19)


def test_problem_names_the_variable_and_the_file(monkeypatch):
    """The user learns what was set to what, and why it will not do."""
    monkeypatch.setenv(llvm.VARIABLE, "/usr/lib/libLLVM-15.so")
    assert llvm.VARIABLE in llvm.problem() and "/usr/lib/libLLVM-15.so" in llvm.problem()
    assert "LLVM 15 is too old" in llvm.problem()


def test_name_without_folder_is_left_to_the_loader():
    """Dr.Jit hands such a name to the system's loader; only its version can be judged."""
    assert llvm.check("libLLVM-19.so") is None
    assert "too old" in llvm.check("libLLVM-15.so")


@pytest.mark.parametrize("path, version", [
    ("/x/libLLVM-19.so", 19), ("/x/libLLVM.so.19.1", 19), ("/x/libLLVM-14.so.1", 14), ("/x/libLLVM-15.0.6.so.1", 15),
    ("/x/libLLVM.so", None), ("/usr/lib/llvm-18/lib/libLLVM.so", 18), ("/usr/lib64/llvm17/lib/libLLVM.so", 17),
    ("/opt/homebrew/Cellar/llvm/22.1.0/lib/libLLVM.dylib", 22), ("/opt/homebrew/opt/llvm@20/lib/libLLVM.dylib", 20),
    ("/x/libLLVM.21.1.dylib", 21), ("", None),
])
def test_version_is_read_from_names(path, version):
    """Debian, Fedora, Alpine and Homebrew each put the version elsewhere."""
    assert llvm.version_of(path) == version


def test_version_is_read_through_links(only, tmp_path):
    """`libLLVM.so` is a link to a name with the version."""
    only("libLLVM.so.22.1")
    (tmp_path / "lib" / "libLLVM.so").symlink_to("libLLVM.so.22.1")
    assert llvm.version_of(str(tmp_path / "lib" / "libLLVM.so")) == 22


@pytest.mark.parametrize("version, refused", [((14, 0, 6), True), ((16,), True), ((17, 0), False), ((19, 1, 7), False)])
def test_loaded_version_is_judged(version, refused):
    """What Dr.Jit reports after loading settles what a name could not tell."""
    assert bool(llvm.check_version(version)) == refused


def test_finding_is_quick(unset):
    """The best of several calls stays within the budget of every start."""
    took = []
    for _ in range(5):
        os.environ.pop(llvm.VARIABLE, None)
        begun = time.perf_counter()
        llvm.prepare()
        took.append(time.perf_counter() - begun)
    assert min(took) < BUDGET


def test_only_cheap_modules_are_imported():
    """The finder runs before everything, also where nothing is installed."""
    program = "import sys; import renderer.core.llvm; print(*sys.modules)"
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-S", "-c", program], cwd=root, capture_output=True, text=True, check=True)
    assert not {"subprocess", "ctypes", "drjit", "numpy", "glob", "tempfile"} & set(done.stdout.split())
