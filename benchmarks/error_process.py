"""The other end of `error_worker.py`: starts a contender's process, and asks it for pictures."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np

from benchmarks.measure import ROOT, TOLD, BenchmarkError

TRIES = 3  # of a picture until its kernels are there


class Process:
    """A contender's process (`error_worker.py`) with an empty kernel cache; a context manager."""

    def __init__(self, side, path, folder, on_gpu=False):
        self._folder = Path(tempfile.mkdtemp(dir=folder))
        self._picture, self._log = self._folder / "picture.npy", (self._folder / "log").open("w+")
        environment = os.environ | {"DRJIT_CACHE_DIR": str(self._folder),
                                    "RENDERER_BACKEND": "cuda" if on_gpu else "llvm"}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.error_worker", side, str(path)], cwd=ROOT, env=environment, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log,
        )  # fmt: skip
        try:
            self.started = self._answer()  # {"import", "build"}: seconds
        except BenchmarkError:
            self.__exit__()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._log):
            with suppress(BrokenPipeError):  # of a question that was never read
                stream.close()

    def render(self, sampler, samples, seed):
        """Return what a picture took, as the worker tells it, and the picture."""
        told = self._ask(sampler=sampler, samples=samples, seed=seed, picture=str(self._picture))
        return told, np.load(self._picture)

    def compiled(self, sampler, samples, seed):
        """Return the same of a picture for which nothing was compiled; raises BenchmarkError if there is none."""
        for _ in range(TRIES):
            told, picture = self.render(sampler, samples, seed)
            if told["compile"] == 0:
                return told, picture
        raise BenchmarkError(f"{samples} samples with {sampler} are compiled anew each time")

    def peak(self):
        """Return its peak memory in MB; it ends."""
        return self._ask()["peak"]

    def _ask(self, **question):
        """Return the worker's answer to a question."""
        try:
            print(json.dumps(question), file=self._process.stdin, flush=True)
        except BrokenPipeError:
            pass  # the missing answer tells
        return self._answer()

    def _answer(self):
        """Return what the worker says next; raises BenchmarkError with its last words if it has ended."""
        line = self._process.stdout.readline()
        if not line:
            status = self._process.wait()
            self._log.seek(0)
            said = "\n".join(self._log.read().strip().splitlines()[-TOLD:])
            raise BenchmarkError(f"'{' '.join(self._process.args[1:])}' ended with status {status}: {said}")
        return json.loads(line)
