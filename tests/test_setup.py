"""Set-up: the lists of packages agree with each other, what is done is not done again, what is half done is redone."""

import importlib.util
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from renderer import doctor
from renderer.core import llvm, llvm_trial

ROOT = Path(__file__).resolve().parent.parent
LISTS = sorted(path.stem for path in (ROOT / "requirements").glob("*.txt"))


def load_setup():
    """Return `tools/setup.py` as a module: it is a program, outside every package."""
    spec = importlib.util.spec_from_file_location("project_setup", ROOT / "tools" / "setup.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


setup = load_setup()


def pins(name):
    """Return the versions in one list, by package in lower case."""
    return {package.lower().replace("_", "-"): version
            for package, version in doctor.read_pins(ROOT / "requirements" / f"{name}.txt").items()}


@pytest.fixture
def quiet_machine(monkeypatch, tmp_path):
    """A machine without network, root or LLVM: what set-up would install is recorded instead."""
    asked = []
    monkeypatch.setenv(llvm.VARIABLE, "")
    monkeypatch.setattr(setup, "apt", lambda *arguments: asked.append(arguments) or False)
    monkeypatch.setattr(setup, "can_install_packages", lambda: False)
    monkeypatch.setattr(setup.Environment, "pip_install", lambda self, path: asked.append(path.stem))
    monkeypatch.setattr(llvm, "candidates", lambda **options: [])
    monkeypatch.setattr(llvm_trial, "missing_library", lambda **options: None)
    monkeypatch.setattr(llvm_trial, "try_cuda", lambda **options: llvm_trial.Trial(False))
    environment = setup.Environment(tmp_path / "venv")
    environment.notes.mkdir(parents=True)
    return environment, asked


def offer(monkeypatch, outcomes, needs=None):
    """Make libraries appear on the machine; `outcomes` tells which work, `needs` when they are there."""
    def candidates(*, prefix, system):
        there = [path for path in outcomes if (system or path.startswith(prefix)) and (needs is None or needs(path))]
        return [llvm.Candidate(path, "test", 19) for path in there]

    monkeypatch.setattr(llvm, "candidates", candidates)
    monkeypatch.setattr(llvm_trial, "try_llvm", lambda path, **options: llvm_trial.Trial(outcomes[path], "19.1.7"))


@pytest.mark.parametrize("name", LISTS)
def test_every_version_is_fixed(name):
    """A set-up of next year installs what was tested today."""
    lines = (ROOT / "requirements" / f"{name}.txt").read_text().splitlines()
    assert all(line.startswith("#") or re.fullmatch(r"[\w.-]+==[\w.]+(; .+)?", line) for line in lines)


def test_lists_agree():
    """A package in two lists has one version."""
    versions = {}
    for name in LISTS:
        for package, version in pins(name).items():
            assert versions.setdefault(package, version) == version


@pytest.mark.parametrize("name", ["run", "test", "bench", "compare", "report", "llvm"])
def test_direct_dependencies_are_pinned(name):
    """What `pyproject.toml` asks for is in the list of its name, in a version that it allows."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    asked = project["dependencies"] if name == "run" else project["optional-dependencies"][name]
    for requirement in asked:
        package, relation, version = re.fullmatch(r"([\w.-]+)(==|>=)([\d.]+)(?:; .+)?", requirement).groups()
        pinned = pins(name)[package.lower()]
        numbers = [tuple(map(int, text.split("."))) for text in (pinned, version)]
        assert numbers[0] == numbers[1] if relation == "==" else numbers[0] >= numbers[1]


@pytest.mark.parametrize("name", ["run", "test", "bench", "compare", "report"])
def test_lists_hold_all_that_is_needed(name):
    """No package of a list needs one that is in none: otherwise its version would be left to chance."""
    from importlib import metadata

    known = pins("run") | pins(name)
    for package in pins(name):
        for requirement in metadata.requires(package) or ():
            if ";" not in requirement:
                assert re.match(r"[\w.-]+", requirement)[0].lower().replace("_", "-") in known


def test_no_index_is_named():
    """Where packages come from is the user's setting."""
    others = [ROOT / name for name in ("pyproject.toml", "Makefile", "tools/setup.py")]
    for path in [*(ROOT / "requirements").glob("*.txt"), *others]:
        assert not re.search(r"https?://|index-url|find-links", path.read_text())


def test_finished_setup_is_left_alone(tmp_path, monkeypatch):
    """The second call installs nothing."""
    environment = setup.Environment(tmp_path / "venv")
    asked = []
    monkeypatch.setattr(setup.Environment, "venv_options", ("--without-pip",))
    monkeypatch.setattr(setup.Environment, "pip_install", lambda self, path: asked.append(path.stem))
    for _ in range(2):
        environment.create()
        environment.install("run")
    assert asked == ["run"]


def test_changed_list_is_installed_again(quiet_machine):
    """A new version in a list reaches an environment that was finished."""
    environment, asked = quiet_machine
    (environment.notes / "run").write_text("digest of an older list")
    environment.install("run")
    assert asked == ["run"]


def test_half_done_environment_is_made_afresh(tmp_path, monkeypatch):
    """What a killed set-up left is not trusted."""
    monkeypatch.setattr(setup.Environment, "venv_options", ("--without-pip",))
    environment = setup.Environment(tmp_path / "venv")
    environment.create()
    (environment.notes / "unfinished").touch()
    (environment.notes / "run").write_text("claims to be complete")
    environment.create()
    assert environment.python.exists()
    assert not (environment.notes / "unfinished").exists() and not (environment.notes / "run").exists()


def test_environment_of_the_user_is_not_deleted(tmp_path):
    """A folder that set-up did not make stays, also if it is of no use."""
    (tmp_path / "venv").mkdir()
    (tmp_path / "venv" / "precious.txt").write_text("mine")
    with pytest.raises(setup.SetupError, match="Move it away"):
        setup.Environment(tmp_path / "venv").create()
    assert (tmp_path / "venv" / "precious.txt").read_text() == "mine"


@pytest.mark.parametrize("ours", [True, False])
def test_cleaning_keeps_what_is_the_users(tmp_path, ours):
    """`make clean` removes an environment only if set-up made it, and pictures never."""
    shutil.copy(ROOT / "Makefile", tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "picture.ppm").write_text("mine")
    (tmp_path / ".venv" / "setup").mkdir(parents=True)
    if ours:
        (tmp_path / ".venv" / "setup" / "made-here").touch()
    subprocess.run(["make", "clean"], cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "out" / "picture.ppm").read_text() == "mine"
    assert (tmp_path / ".venv").exists() is not ours


def test_bad_choice_of_library_stops_setup(quiet_machine, monkeypatch):
    """A choice of the user's is not replaced silently."""
    environment, asked = quiet_machine
    monkeypatch.setenv(llvm.VARIABLE, "/no/such/libLLVM-19.so")
    with pytest.raises(setup.SetupError, match=f"unset {llvm.VARIABLE}"):
        setup.provide_llvm(environment, "any")
    assert asked == []


def test_library_that_is_there_is_taken(quiet_machine, monkeypatch):
    """The first library that computes is recorded; nothing is installed; the next call does not even try it."""
    environment, asked = quiet_machine
    offer(monkeypatch, {"/broken/libLLVM-19.so": False, sys.executable: True})
    setup.provide_llvm(environment, "any")
    assert llvm.recorded(str(environment.folder)) == sys.executable and asked == []
    monkeypatch.setattr(llvm_trial, "try_llvm", None)
    setup.provide_llvm(environment, "any")


def test_root_installs_from_the_distribution(quiet_machine, monkeypatch):
    """As root on Debian, the distribution's library is installed, the measured version first."""
    environment, asked = quiet_machine
    monkeypatch.setattr(setup, "can_install_packages", lambda: True)
    monkeypatch.setattr(setup, "apt", lambda *arguments: asked.append(arguments) or True)
    listing = subprocess.CompletedProcess([], 0, "libllvm14\nlibllvm22\nlibllvm19\n")
    monkeypatch.setattr(setup.subprocess, "run", lambda *arguments, **options: listing)
    offer(monkeypatch, {"/system/libLLVM-19.so": True}, needs=lambda path: asked)
    setup.provide_llvm(environment, "any")
    assert [arguments[-1] for arguments in asked] == ["libllvm19"]


def test_wheel_is_the_last_resort(quiet_machine, monkeypatch):
    """Without root, the wheel is installed into the environment."""
    environment, asked = quiet_machine
    path = str(environment.folder / "lib" / "libLLVM-19.so")
    offer(monkeypatch, {path: True}, needs=lambda path: "llvm" in asked)
    monkeypatch.setattr(setup, "succeeds", lambda command: True)
    setup.provide_llvm(environment, "any")
    assert asked == ["llvm"] and llvm.recorded(str(environment.folder)) == path


def test_failure_says_what_to_do(quiet_machine, monkeypatch):
    """Where nothing helps, the message names the variable by which the user can."""
    environment, _asked = quiet_machine
    monkeypatch.setattr(setup, "succeeds", lambda command: True)
    with pytest.raises(setup.SetupError, match=f"export {llvm.VARIABLE}="):
        setup.provide_llvm(environment, "any")


def test_missing_system_library_is_told(quiet_machine, monkeypatch):
    """Without root, the command that installs what Dr.Jit lacks is in the message."""
    environment, _asked = quiet_machine
    monkeypatch.setattr(llvm_trial, "missing_library", lambda **options: "libatomic.so.1")
    monkeypatch.setattr(setup.shutil, "which", lambda name: f"/usr/bin/{name}")
    with pytest.raises(setup.SetupError, match="sudo apt-get install libatomic1"):
        setup.provide_llvm(environment, "any")


def test_old_python_is_told_what_is_needed(monkeypatch, capsys):
    """A Python that is too old, with no newer one beside it, is named with its version."""
    monkeypatch.setattr(setup.sys, "version_info", (3, 9, 2))
    monkeypatch.setattr(setup.shutil, "which", lambda name: None)
    assert setup.main([]) == 1
    assert "3.11 or newer is needed" in capsys.readouterr().err


def test_unknown_set_is_refused(capsys):
    """A misspelt set of packages is an error, not an empty set-up."""
    with pytest.raises(SystemExit):
        setup.main(["tset"])
    assert "unknown package set tset" in capsys.readouterr().err


@pytest.mark.parametrize("target", ["help", "setup", "run", "compare", "test", "test-all",
                                    "testsuite", "bench", "report", "docs", "doctor"])
def test_makefile_has_the_target(target):
    """Every target that the README or `make help` names can be planned by make."""
    done = subprocess.run(["make", "-n", target], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("given", [[], ["A=one.ppm"], ["B=one.ppm"]])
def test_comparison_of_no_two_pictures_installs_nothing(given):
    """`make compare` says what it needs before it sets anything up."""
    done = subprocess.run(["make", "compare", "PYTHON=/nonexistent", *given], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 2 and "make compare A=mine.ppm B=scene.exr" in done.stderr
    assert "/nonexistent" not in done.stderr


def test_names_with_blanks_reach_the_renderer_whole():
    """A scene and a picture whose names are of two words."""
    done = subprocess.run(["make", "-n", "run", "SCENE=my scene.json", "OUT=my out/x.png"],
                          cwd=ROOT, capture_output=True, text=True)
    assert '"my scene.json" -o "my out/x.png"' in done.stdout and "mkdir -p my" not in done.stdout


@pytest.mark.slow
def test_wheel_computes(tmp_path):
    """The wheel's library works in an environment of its own, on a machine told to ignore its own libraries."""
    command = [sys.executable, str(ROOT / "tools" / "setup.py"), "--venv", str(tmp_path / "venv"), "--llvm", "wheel"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert llvm.recorded(str(tmp_path / "venv")) == str(tmp_path / "venv" / "lib" / "libLLVM-19.so")
