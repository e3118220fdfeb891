"""What docs/stability.md says of each hard case, for the plot and the report that are made from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent / "docs" / "stability.md"
SIDES = "ours", "naive", "mitsuba"


@dataclass(frozen=True)
class HardCase:
    """One row of the page; the sides are pairs of worst and mean error, None where one cannot be asked."""

    section: str
    name: str
    unit: str
    allowed: float
    ours: tuple[float, float]
    naive: tuple[float, float] | None
    mitsuba: tuple[float, float] | None

    def strain(self, side: str) -> float:
        """Return a side's worst error over what is allowed: infinite for an error where there may be none."""
        worst, _ = getattr(self, side)
        return worst / self.allowed if self.allowed else math.inf if worst else 0.0


def read(text: str) -> list[HardCase]:
    """Return the cases of the page in its order. Raises ValueError for rows that cannot be read."""
    found, section = [], ""
    for line in text.splitlines():
        if line.startswith("## "):
            section = line.removeprefix("## ")
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and cells[0] not in ("case", "---"):
            name, unit, allowed, *errors = cells
            found.append(HardCase(section, name, unit, float(allowed), *map(_pair, errors)))
    return found


def _pair(cell):
    """Return worst and mean of a cell; None of a dash."""
    if cell == "-":
        return None
    worst, mean = (float(part.replace("infinite", "inf")) for part in cell.split(","))
    return worst, mean
