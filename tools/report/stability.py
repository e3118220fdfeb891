"""The table of hard cases in short: of each group of docs/stability.md, the case that comes nearest to its bound."""

from __future__ import annotations

import itertools
import math
import re
from pathlib import Path

from tests.stability.case import CLEARLY, ULP
from tools.hard_cases import PAGE, SIDES, read
from tools.report import results

MOST_PLAIN = 1e4  # larger numbers are written with a power of ten
FLOORS = {"ulp": 1.0, "relative": ULP}  # errors that no one need be better than, as in Case.mitsuba_is_better
MADE = "measured x ?2"  # of bounds that were not derived, in the notes
SHARES = "share", "share of slipped rays"  # units of answers that are right or wrong
POWER = re.compile(r"\b(\d+(?:\.\d+)?)e(-?\d+)\b")


def make(folder: Path) -> dict[str, str | list]:
    """Return the tables, how many cases each side decides within the bound, and what accuracy costs."""
    page = PAGE.read_text()
    cases = read(page)
    found = groups(cases)
    better = [case for case in cases if mitsuba_is_better(case)]
    told = {"cases": str(len(cases)), "groups": str(len(found)), "table": [row(group) for group in found],
            "better": results.words(len(better)), "better_table": [shown(case) for case in better],
            "doubled": results.words(len(re.findall(MADE, page)))}  # fmt: skip
    for side in SIDES:
        asked = [getattr(case, side)[0] <= case.allowed for case in cases if getattr(case, side) is not None]
        told |= {f"{side}_within": str(sum(asked)), f"{side}_asked": str(len(asked))}
    shadows = next(case for case in cases if case.name.startswith("shadows at first hits"))
    return told | {f"shadows_{side}": told_of(shadows, side) for side in SIDES} | costs()


def costs():
    """Return what docs/speed.md says of the price of accuracy, as it was measured before and after."""
    text = " ".join((results.ROOT / "docs" / "speed.md").read_text().split())
    whole = re.search(r"took (\d+ to \d+) per cent of `throughput` and (\d+ to \d+) per cent of the ratios of `paths`, "
                      r"(\d+) per cent of the thin lens's", text)  # fmt: skip
    twice = re.search(r"takes (\d+ to \d+) per cent of the coursework's scene", text)
    return dict(zip(("cost_phong", "cost_paths", "cost_lens", "cost_twice"), (*whole.groups(), twice[1])))


def mitsuba_is_better(case):
    """Return whether Mitsuba's errors are clearly smaller, as tests/stability/case.py judges that."""
    floor = FLOORS.get(case.unit, 0.0)
    return case.mitsuba is not None and any(
        ours > max(CLEARLY * theirs, floor) for ours, theirs in zip(case.ours, case.mitsuba)
    )


def groups(cases):
    """Return the cases in a list for each section of the page."""
    return [list(group) for _, group in itertools.groupby(cases, lambda case: case.section)]


def row(group):
    """Return the row of a group: how many cases, and the one that comes nearest to its bound."""
    hardest = max(group, key=lambda case: case.strain("ours"))  # the first of equals
    return [str(len(group)), *shown(hardest)]


def shown(case):
    """Return a case as cells: name, unit, what is allowed, and the errors of the three sides."""
    return [written(case.name), written(case.unit), value(case.allowed), *(told_of(case, side) for side in SIDES)]


def told_of(case, side):
    """Return the worst error of a side as text; of answers that are right or wrong, the share that is wrong."""
    found = getattr(case, side)
    if found is None:
        return results.UNASKED
    return results.percent(found[1]) if case.unit in SHARES else value(found[0])


def value(number):
    """Return a number of the table as text."""
    if math.isinf(number):
        return "∞"
    return results.digits(number) if number < MOST_PLAIN else written(f"{number:.1e}".replace("+0", ""))


def written(text):
    """Return a name with its powers of ten as such."""
    def power(match):
        mantissa = "" if match[1] == "1" else f"{match[1]}{results.THIN}×{results.THIN}"
        return f"{mantissa}10{match[2].translate(results.SUPERSCRIPTS)}"
    return POWER.sub(power, text)
