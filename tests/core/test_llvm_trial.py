"""Trying a library must tell good from bad, whatever the bad one does to its process."""

import sys
import time

import pytest

from renderer.core import llvm, llvm_trial

OLD = [found for found in llvm.candidates() if found.version is not None and found.version < llvm.OLDEST]


def imitation(tmp_path, text):
    """Return the path of a program that stands in for Python."""
    path = tmp_path / "python"
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)
    return str(path)


def test_chosen_library_works():
    """The library that the tests run with computes minimum, maximum and clip."""
    trial = llvm_trial.try_llvm(llvm.prepare())
    assert trial.works and int(trial.version.split(".")[0]) >= llvm.OLDEST


def test_text_file_does_not_work(tmp_path):
    """A file that is no library is refused by Dr.Jit, and the trial says so."""
    (tmp_path / "libLLVM-19.so").write_text("not a library")
    trial = llvm_trial.try_llvm(str(tmp_path / "libLLVM-19.so"))
    assert not trial.works and trial.reason == "Dr.Jit cannot load it"


@pytest.mark.skipif(not OLD, reason="no LLVM older than 17 on this machine")
@pytest.mark.parametrize("found", OLD, ids=lambda found: f"version {found.version}")
def test_old_library_does_not_work(found):
    """Why old versions are refused by name: they do fail, some by killing the process."""
    trial = llvm_trial.try_llvm(found.path)
    assert not trial.works
    assert "SIGABRT" in trial.reason or trial.reason == "Dr.Jit cannot load it"


@pytest.mark.parametrize("text, told", [
    ("kill -ABRT $$", "killed by SIGABRT"),
    ("kill -FPE $$", "killed by SIGFPE"),
    ("exit 3", "status 3"),
    ("echo strange >&2; exit 1", "strange"),
    ("echo \"ModuleNotFoundError: No module named 'drjit'\" >&2; exit 1", "Dr.Jit is not installed"),
    ("echo 'ImportError: libatomic.so.1: cannot open shared object file: No such file' >&2; exit 1", "libatomic.so.1"),
    ("exit 0", "status 0"),
    ("printf '\\377\\376' >&2; exit 1", ""),
])
def test_bad_end_is_explained(tmp_path, text, told):
    """Signals, statuses and messages become one sentence; silence is no success."""
    trial = llvm_trial.try_llvm("/any/libLLVM.so", python=imitation(tmp_path, text))
    assert not trial.works and told in trial.reason


def test_hanging_trial_ends(tmp_path):
    """A trial that gives no answer is given up."""
    begun = time.monotonic()
    trial = llvm_trial.try_llvm("/any/libLLVM.so", python=imitation(tmp_path, "exec sleep 60"), time_limit=0.2)
    assert "no answer" in trial.reason and time.monotonic() - begun < 20


@pytest.mark.parametrize("path", ["/a\0b", ""])
def test_strange_paths_do_not_raise(path):
    """Whatever is to be tried, the answer is a sentence."""
    assert llvm_trial.try_llvm(path, python="/no/such/python").reason


def test_missing_system_library_is_named(tmp_path):
    """The loader's message tells which library a bare system lacks."""
    text = "echo 'ImportError: libatomic.so.1: cannot open shared object file: No such file or directory' >&2; exit 1"
    assert llvm_trial.missing_library(python=imitation(tmp_path, text)) == "libatomic.so.1"


def test_missing_llvm_is_no_missing_system_library(tmp_path, monkeypatch):
    """Dr.Jit's own word about a bad LLVM is another matter."""
    monkeypatch.setenv(llvm.VARIABLE, "/no/such/libLLVM.so")
    assert llvm_trial.missing_library() is None
    text = "echo '/no/such/libLLVM.so: cannot open shared object file: No such file or directory' >&2; exit 1"
    assert llvm_trial.missing_library(python=imitation(tmp_path, text)) is None


def test_no_system_library_is_missing_here():
    """Dr.Jit is importable where the tests run."""
    assert llvm_trial.missing_library(python=sys.executable) is None
