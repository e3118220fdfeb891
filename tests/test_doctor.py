"""The doctor must tell what is wrong and how to mend it, and must never be what fails."""

import os
import subprocess
import sys

import pytest

from renderer import doctor
from renderer.core import llvm, llvm_trial

WORKS, BROKEN = llvm_trial.Trial(True, "19.1.7"), llvm_trial.Trial(False, reason="the process was killed by SIGABRT")


def consult(root, python=sys.executable, **environment):
    """Run the doctor as the user does; a value of None takes a variable away. Returns the finished process."""
    settings = {**os.environ, **environment}
    settings = {name: str(value) for name, value in settings.items() if value is not None}
    return subprocess.run([python, "-m", "renderer", "doctor"], cwd=root, env=settings, capture_output=True, text=True,
                          timeout=120)


def lines_of(done, subject):
    """Return `(mark, text)` of the report's lines about a subject."""
    parts = [line.split(maxsplit=1) for line in done.stdout.splitlines()]
    return [(part[0], part[1]) for part in parts if len(part) == 2 and part[1].startswith(subject)]


@pytest.fixture
def libraries(monkeypatch):
    """A machine with one library, whose trial's outcome the test chooses; no GPU."""
    found = llvm.Candidate("/x/libLLVM-19.so", "system", 19)
    monkeypatch.setenv(llvm.VARIABLE, "")
    monkeypatch.delenv("RENDERER_BACKEND", raising=False)
    monkeypatch.setattr(llvm, "candidates", lambda: [found])
    monkeypatch.setattr(llvm, "prepare", lambda: found.path)
    monkeypatch.setattr(llvm_trial, "try_cuda", lambda: llvm_trial.Trial(False, reason="no GPU"))
    return lambda trial: monkeypatch.setattr(llvm_trial, "try_llvm", lambda path: trial)


def marks(findings, subject):
    """Return the marks of the lines about a subject."""
    return [finding.mark for finding in findings if finding.subject == subject]


def test_healthy_machine_is_called_so(root):
    """Where the tests run, rendering works."""
    done = consult(root)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith("Rendering will work.\n") and done.stderr == ""
    assert ("ok", "Python") in [(mark, text.split()[0]) for mark, text in lines_of(done, "Python")]


def test_text_is_aligned():
    """The third column starts at the same place in every line."""
    findings = [doctor.Finding("ok", "short", "first"), doctor.Finding("problem", "a long subject", "second")]
    first, second = doctor.report(findings).splitlines()[:2]
    assert first.index("first") == second.index("second")


def test_each_command_is_told_once():
    """Several findings with one remedy make one line of advice."""
    findings = [doctor.Finding("problem", name, "is missing", "make setup") for name in ("one", "two")]
    assert doctor.report(findings).count("make setup") == 1


@pytest.mark.parametrize("content, told", [(None, "no such file"), ("not a library", "not a shared library")])
def test_bad_choice_of_library_is_a_problem(root, tmp_path, content, told):
    """A choice of the user's that Dr.Jit cannot load is named, with its reason and a command."""
    path = tmp_path / "libLLVM-19.so"
    if content:
        path.write_text(content)
    done = consult(root, **{llvm.VARIABLE: path})
    assert done.returncode == 1 and "Traceback" not in done.stderr
    (problem,) = [text for mark, text in lines_of(done, "LLVM") if mark == "problem"]
    assert str(path) in problem and told in problem
    assert llvm.VARIABLE in done.stdout.split("What to do:")[1]


@pytest.mark.parametrize("version", [14, 15, 16])
def test_old_library_is_survived(root, version):
    """A library that kills the process that loads it does not kill the doctor."""
    old = [found.path for found in llvm.candidates() if found.version == version]
    if not old:
        pytest.skip(f"no LLVM {version} on this machine")
    done = consult(root, **{llvm.VARIABLE: old[0]})
    assert done.returncode == 1
    assert f"LLVM {version} is too old" in done.stdout and "Rendering will not work yet." in done.stdout


def test_command_for_a_bad_choice_mends_it(root, tmp_path):
    """Following the advice makes the doctor content."""
    (tmp_path / "libLLVM-19.so").write_text("not a library")
    done = consult(root, **{llvm.VARIABLE: tmp_path / "libLLVM-19.so"})
    advice = done.stdout.split("What to do:\n")[1].splitlines()[0].strip()
    name, value = advice.removeprefix("export ").split("=")
    assert name == llvm.VARIABLE and consult(root, **{name: value}).returncode == 0


def test_no_library_is_a_problem_with_a_command(libraries, monkeypatch):
    """Without LLVM and GPU the report says what to install."""
    monkeypatch.setattr(llvm, "candidates", list)
    monkeypatch.setattr(llvm, "prepare", lambda: None)
    (finding,) = [one for one in doctor.backends() if one.subject == "LLVM"]
    assert finding.mark == doctor.PROBLEM and finding.mend


def test_library_that_fails_its_trial_is_a_problem(libraries):
    """A good name is not enough: what is chosen has to compute."""
    libraries(BROKEN)
    (finding,) = [one for one in doctor.backends() if one.subject == "LLVM"]
    assert finding.mark == doctor.PROBLEM and "SIGABRT" in finding.text and finding.mend


def test_working_gpu_makes_llvm_optional(libraries, monkeypatch):
    """A GPU renders without LLVM; what is wrong with it is a warning then."""
    libraries(BROKEN)
    monkeypatch.setattr(llvm_trial, "try_cuda", lambda: WORKS)
    findings = doctor.backends()
    assert marks(findings, "LLVM") == [doctor.WARNING] and marks(findings, "CUDA") == [doctor.OK]


def test_wish_for_a_missing_gpu_is_a_problem(libraries, monkeypatch):
    """RENDERER_BACKEND=cuda without a GPU cannot work, whatever LLVM does."""
    libraries(WORKS)
    monkeypatch.setenv("RENDERER_BACKEND", "cuda")
    assert marks(doctor.backends(), "CUDA") == [doctor.PROBLEM]


def test_unknown_backend_is_a_problem(libraries, monkeypatch):
    """A misspelt wish is told with the names that there are."""
    libraries(WORKS)
    monkeypatch.setenv("RENDERER_BACKEND", "metal")
    (finding,) = [one for one in doctor.backends() if one.subject == "backend"]
    assert finding.mark == doctor.PROBLEM and "llvm and cuda" in finding.text


def test_nothing_installed_is_survived(root, tmp_path):
    """Under a Python without a single package, the doctor lists what is missing."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(tmp_path / "bare")], check=True)
    done = consult(root, python=str(tmp_path / "bare" / "bin" / "python"), PYTHONPATH=None)
    assert done.returncode == 1 and done.stderr == ""
    assert "not installed: " in done.stdout and "drjit" in done.stdout
    assert ("problem", "LLVM") in [(mark, text.split()[0]) for mark, text in lines_of(done, "LLVM")]


def test_no_home_is_survived(root):
    """Without HOME, kernels are not kept: a warning, since rendering works."""
    done = consult(root, HOME=None, DRJIT_CACHE_DIR=None)
    assert done.returncode == 0 and [mark for mark, _ in lines_of(done, "kernel cache")] == ["warning"]


def test_unwritable_cache_is_a_warning(root, tmp_path):
    """A file where the cache's folder should be: not even root can write into that."""
    (tmp_path / ".drjit").write_text("in the way")
    done = consult(root, HOME=tmp_path, DRJIT_CACHE_DIR=None)
    assert done.returncode == 0
    ((mark, text),) = lines_of(done, "kernel cache")
    assert mark == "warning" and "cannot be written" in text


def test_chosen_cache_folder_is_looked_at(root, tmp_path):
    """DRJIT_CACHE_DIR moves the cache, also to a folder that is not there yet."""
    ((mark, text),) = lines_of(consult(root, DRJIT_CACHE_DIR=tmp_path / "new" / "folder"), "kernel cache")
    assert mark == "ok" and str(tmp_path / "new" / "folder") in text


def test_little_memory_is_a_warning(monkeypatch):
    """Less than a gibibyte is worth a word."""
    monkeypatch.setattr(doctor.machine, "available_memory", lambda: 2**28)
    assert [finding.mark for finding in doctor.memory()] == [doctor.WARNING]


@pytest.mark.parametrize("installed, mark", [(None, doctor.PROBLEM), ("0.1", doctor.WARNING)])
def test_package_is_compared_with_its_pin(monkeypatch, installed, mark):
    """A missing package is a problem, another version than the tested one a warning."""
    true = doctor.installed_version
    monkeypatch.setattr(doctor, "installed_version", lambda name: installed if name == "numpy" else true(name))
    assert mark in [finding.mark for finding in doctor.packages() if "numpy" in finding.subject + finding.text]


def test_package_that_cannot_be_imported_is_a_problem(monkeypatch):
    """Installed is not the same as usable."""
    monkeypatch.setattr(doctor, "unimportable", lambda: {"scipy": "half of it is gone"})
    (finding,) = [one for one in doctor.packages() if one.subject == "scipy"]
    assert finding.mark == doctor.PROBLEM and "half of it is gone" in finding.text


def test_missing_system_library_is_named_with_its_package(monkeypatch):
    """A bare Debian has no libatomic, which Dr.Jit's wheel takes for granted."""
    message = "libatomic.so.1: cannot open shared object file: No such file or directory"
    monkeypatch.setattr(doctor, "unimportable", lambda: {"drjit": message})
    (finding,) = [one for one in doctor.packages() if one.subject == "drjit"]
    assert finding.mark == doctor.PROBLEM and "libatomic" in finding.text and "libatomic" in finding.mend


def test_failing_step_does_not_stop_the_others(monkeypatch):
    """Whatever happens inside a step, the rest of the report is written."""
    monkeypatch.setattr(doctor.machine, "usable_cores", lambda: 1 / 0)
    findings = doctor.examine()
    (finding,) = [one for one in findings if "ZeroDivisionError" in one.text]
    assert finding.mark == doctor.WARNING and marks(findings, "memory")


@pytest.mark.parametrize("argument, status", [("--help", 0), ("extra", 2)])
def test_arguments_are_answered(capsys, argument, status):
    """The doctor takes no arguments, and says so."""
    assert doctor.main([argument]) == status
    assert "usage" in capsys.readouterr().out
