"""What the benchmarks measured, and numbers as the report writes them: the modules of the parts read no other way."""

from __future__ import annotations

import functools
import json
import math
from pathlib import Path

from tools import hard_cases

ROOT = Path(__file__).resolve().parent.parent.parent
RESULTS = ROOT / "benchmarks" / "results.json"
UNASKED = "\u2013"  # Mitsuba cannot do the same
LEAST_PLAIN = 1e-4  # smaller numbers are written with a power of ten
SUPERSCRIPTS = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")
THIN = "\u202f"  # a narrow space at which no line ends: between a number and its unit


@functools.cache
def results() -> dict:
    """Return all results: {"machine": ..., "effort": ..., "benchmarks": ...}."""
    return json.loads(RESULTS.read_text())


def machine(key: str) -> str:
    """Return a fact about the machine or the date of the measurement, such as "cpu"."""
    return str(results()["machine"][key])


def figure(benchmark: str, name: str) -> float:
    """Return what a benchmark's figure reached, in its own unit; raises KeyError with the names that there are."""
    figures = {one["name"]: one["reached"] for one in _benchmark(benchmark)["figures"]}
    if name not in figures:
        raise KeyError(f"{benchmark}: no figure {name!r}; there are {sorted(figures)}")
    return figures[name]


def table(benchmark: str, title: str) -> list[dict]:
    """Return the rows of a benchmark's table; raises KeyError with the titles that there are."""
    tables = _benchmark(benchmark)["tables"]
    if title not in tables:
        raise KeyError(f"{benchmark}: no table {title!r}; there are {sorted(tables)}")
    return tables[title]


def row(benchmark: str, title: str, **wanted) -> dict:
    """Return the one row of a table whose columns have the values wanted; raises KeyError for none or several."""
    found = [one for one in table(benchmark, title) if all(one[key] == value for key, value in wanted.items())]
    if len(found) != 1:
        raise KeyError(f"{benchmark}, {title}: {len(found)} rows with {wanted}")
    return found[0]


def median(value) -> float | None:
    """Return the middle of a spread, or a plain number as it is."""
    return value["median"] if isinstance(value, dict) else value


def _benchmark(name):
    """Return one benchmark's results."""
    if name not in results()["benchmarks"]:
        raise KeyError(f"no benchmark {name!r}; there are {sorted(results()['benchmarks'])}")
    return results()["benchmarks"][name]


def digits(value: float, count: int = 2) -> str:
    """Return a number with `count` significant digits: 0.0043, 12, 1,200, 2.4 x 10^-6."""
    if value == 0:
        return "0"
    if abs(value) < LEAST_PLAIN:
        text, power = f"{value:.{count - 1}e}".split("e")
        return f"{text}{THIN}\u00d7{THIN}10{str(int(power)).translate(SUPERSCRIPTS)}".replace("-", "\u2212", 1)
    places = count - 1 - math.floor(math.log10(abs(value)))
    rounded = round(value, places)
    places = count - 1 - math.floor(math.log10(abs(rounded)))  # 0.996 has become 1.0
    return f"{rounded:,.{max(places, 0)}f}".replace("-", "\u2212")


def unit(value: float, name: str, count: int = 2) -> str:
    """Return a number with its unit: unit(0.0123, "s") is "0.012 s"."""
    return f"{digits(value, count)}{THIN}{name}"


def percent(share: float, count: int = 2) -> str:
    """Return a share of 1 as per cent."""
    return unit(100 * share, "%", count)


def times(ratio: float, count: int = 2) -> str:
    """Return a ratio: "3.2 times"."""
    return unit(ratio, "times", count)


def seconds(value: float, count: int = 2) -> str:
    """Return a time in the unit that suits it: s, ms or \u00b5s."""
    for scale, name in ((1, "s"), (1e3, "ms")):
        if abs(value) * scale >= 0.9995 or value == 0:  # what rounding makes 1 of counts as 1
            return unit(value * scale, name, count)
    return unit(value * 1e6, "\u00b5s", count)


def words(count: int) -> str:
    """Return a small whole number as a word, a large one in figures."""
    names = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
    return names[count] if 0 <= count < len(names) else f"{count:,}"


def hard_case(name: str) -> dict[str, tuple[str, str]]:
    """Return {"ours", "naive", "mitsuba": (worst, mean error)} of a hard case, as text, of those that can be asked."""
    sides = {side: getattr(_hard(name), side) for side in hard_cases.SIDES}
    return {side: tuple(map(_plain, pair)) for side, pair in sides.items() if pair is not None}


def hard_share(name: str, side: str) -> str:
    """Return the mean of a hard case whose unit is a share, as per cent."""
    return percent(getattr(_hard(name), side)[1])


@functools.cache
def _hard_cases():
    """Return {name: HardCase} of the whole page."""
    return {case.name: case for case in hard_cases.read(hard_cases.PAGE.read_text())}


def _hard(name):
    """Return the hard case of a name; raises KeyError."""
    if name not in _hard_cases():
        raise KeyError(f"no hard case {name!r} in {hard_cases.PAGE.name}")
    return _hard_cases()[name]


def _plain(number):
    """Return an error as the report writes it."""
    return "infinite" if math.isinf(number) else digits(number)


def cost(feature: str) -> dict[str, str]:
    """Return what a feature costs: `ns` a sample, `times` the time without it, and `mitsuba`, the same of Mitsuba's.

    `share` is the time as a share of that without; `ratio` has no unit.
    """
    found = row("features", "features", feature=feature)
    ours, theirs = median(found["time, x without"]), median(found["Mitsuba's, x without"])
    return {"ns": unit(median(found["cost (ns a sample)"]), "ns"), "times": times(ours), "share": percent(ours),
            "ratio": digits(ours), "mitsuba": UNASKED if theirs is None else times(theirs)}


def picture_cost(feature: str) -> str:
    """Return the CPU time a pixel of what is done once a picture."""
    return unit(median(row("features", "pictures", feature=feature)["CPU ns a pixel"]), "ns")
