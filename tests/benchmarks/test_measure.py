"""The instruments: each is shown something whose size is known."""

import pytest

from benchmarks.measure import BenchmarkError, interleaved, run_process, spread

MEGABYTE = 10**6


def test_spread_tells_median_and_ends():
    """One slow run does not move the median."""
    assert spread([2.0, 9.0, 1.0]) == {"median": 2.0, "min": 1.0, "max": 9.0}


def test_peak_memory_is_that_of_the_process_alone():
    """What this process holds is not counted, what the measured one held for a moment is."""
    ballast = bytearray(b"x") * (300 * MEGABYTE)
    small = run_process("-c", "pass").peak
    large = run_process("-c", f"bytearray(b'x') * {200 * MEGABYTE}").peak
    assert small < 100 < len(ballast) / MEGABYTE
    assert large - small == pytest.approx(200, abs=10)


def test_wall_time_counts_waiting_and_cpu_time_does_not():
    """A sleeping process takes time of the one kind only."""
    run = run_process("-c", "import time; time.sleep(0.5)")
    assert run.wall >= 0.5 and run.wall == run.ended - run.spawned
    assert run.cpu < 0.45


def test_output_and_environment_reach_their_ends():
    """The process gets the environment, and what it prints comes back."""
    program = "import os; print(os.environ['DRJIT_CACHE_DIR']); print('second')"
    assert run_process("-c", program, DRJIT_CACHE_DIR="/somewhere").output == "/somewhere\nsecond"


def test_failed_process_is_an_error_with_its_last_words():
    """A benchmark of a command that fails would be a fine speed."""
    with pytest.raises(BenchmarkError, match="status 3.*"):
        run_process("-c", "raise SystemExit(3)")


def test_actions_take_turns_after_a_warm_up():
    """Every action runs once unmeasured, then they alternate."""
    calls = []
    actions = {name: lambda name=name: calls.append(name) for name in "ab"}
    seconds = interleaved(actions, repeats=2, calls=2)
    assert "".join(calls) == "ab" + "aabb" * 2
    assert {name: len(times) for name, times in seconds.items()} == {"a": 2, "b": 2}


def test_cpu_time_is_that_of_one_call():
    """Work that is ten times as long takes longer, whatever else the machine does."""
    actions = {"short": lambda: sum(range(20_000)), "long": lambda: sum(range(2_000_000))}
    seconds = interleaved(actions, repeats=3, calls=2)
    assert min(seconds["long"]) > 10 * min(seconds["short"])
