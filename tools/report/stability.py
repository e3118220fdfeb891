"""The table of hard cases in short: of each group of docs/stability.md, the case that comes nearest to its bound."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

from tests.stability.case import CLEARLY, ULP
from tools.report import results

MOST_PLAIN = 1e4  # larger numbers are written with a power of ten
SIDES = "ours", "naive", "mitsuba"
FLOORS = {"ulp": 1.0, "relative": ULP}  # errors that no one need be better than, as in Case.mitsuba_is_better
MADE = "measured x ?2"  # of bounds that were not derived, in the notes
SHARES = "share", "share of slipped rays"  # units of answers that are right or wrong
POWER = re.compile(r"\b(\d+(?:\.\d+)?)e(-?\d+)\b")


@dataclass(frozen=True)
class Line:
    """One case as the page has it; the sides are pairs of worst and mean error, None where one cannot be asked."""

    name: str
    unit: str
    allowed: float
    ours: tuple[float, float]
    naive: tuple[float, float] | None
    mitsuba: tuple[float, float] | None

    def within(self, side):
        """Return whether a side keeps our bound; None where it cannot be asked."""
        found = getattr(self, side)
        return found and found[0] <= self.allowed

    @property
    def strain(self):
        """Our worst error over what is allowed."""
        return self.ours[0] / self.allowed if self.allowed else math.inf * self.ours[0] if self.ours[0] else 0.0

    @property
    def mitsuba_is_better(self):
        """Whether Mitsuba's errors are clearly smaller, as tests/stability/case.py judges that."""
        floor = FLOORS.get(self.unit, 0.0)
        return self.mitsuba is not None and any(
            ours > max(CLEARLY * theirs, floor) for ours, theirs in zip(self.ours, self.mitsuba)
        )


def make(folder: Path) -> dict[str, str | list]:
    """Return the tables, how many cases each side decides within the bound, and what accuracy costs."""
    page = results.STABILITY.read_text()
    found = groups(page)
    lines = [line for group in found.values() for line in group]
    better = [line for line in lines if line.mitsuba_is_better]
    told = {"cases": str(len(lines)), "groups": str(len(found)), "table": [row(group) for group in found.values()],
            "better": results.words(len(better)), "better_table": [shown(line) for line in better],
            "doubled": results.words(len(re.findall(MADE, page)))}  # fmt: skip
    for side in SIDES:
        asked = [line.within(side) for line in lines if getattr(line, side) is not None]
        told |= {f"{side}_within": str(sum(asked)), f"{side}_asked": str(len(asked))}
    shadows = next(line for line in lines if line.name.startswith("shadows at first hits"))
    return told | {f"shadows_{side}": told_of(shadows, side) for side in SIDES} | costs()


def costs():
    """Return what docs/speed.md says of the price of accuracy, as it was measured before and after."""
    text = " ".join((results.ROOT / "docs" / "speed.md").read_text().split())
    whole = re.search(r"took (\d+ to \d+) per cent of `throughput` and (\d+ to \d+) per cent of the ratios of `paths`, "
                      r"(\d+) per cent of the thin lens's", text)  # fmt: skip
    twice = re.search(r"takes (\d+ to \d+) per cent of the coursework's scene", text)
    return dict(zip(("cost_phong", "cost_paths", "cost_lens", "cost_twice"), (*whole.groups(), twice[1])))


def groups(page):
    """Return {title: [Line]} of the page's tables. Raises ValueError for rows that cannot be read."""
    found, title = {}, None
    for text in page.splitlines():
        if text.startswith("## "):
            title = text[3:]
        cells = [cell.strip() for cell in text.strip("|").split("|")]
        if text.startswith("|") and cells[0] not in ("case", "---"):
            name, unit, allowed, *errors = cells
            found.setdefault(title, []).append(Line(name, unit, float(allowed), *map(pair, errors)))
    return found


def pair(cell):
    """Return worst and mean of a cell; None of a dash."""
    if cell == "-":
        return None
    worst, mean = (float(part.replace("infinite", "inf")) for part in cell.split(","))
    return worst, mean


def row(group):
    """Return the row of a group: how many cases, and the one that comes nearest to its bound."""
    hardest = max(group, key=lambda line: line.strain)  # the first of equals
    return [str(len(group)), *shown(hardest)]


def shown(line):
    """Return a case as cells: name, unit, what is allowed, and the errors of the three sides."""
    return [written(line.name), written(line.unit), value(line.allowed), *(told_of(line, side) for side in SIDES)]


def told_of(line, side):
    """Return the worst error of a side as text; of answers that are right or wrong, the share that is wrong."""
    found = getattr(line, side)
    if found is None:
        return results.UNASKED
    return results.percent(found[1]) if line.unit in SHARES else value(found[0])


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
