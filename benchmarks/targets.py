"""Figures that are judged: what was reached, the least that is asked for, and the aim."""

from __future__ import annotations

from dataclasses import dataclass

LOWER, HIGHER = "lower", "higher"  # which is better


@dataclass(frozen=True)
class Figure:
    """One number and what it is held to; `least` and `aim` are None where there is none."""

    name: str
    unit: str
    better: str  # LOWER or HIGHER
    reached: float
    least: float | None = None
    aim: float | None = None

    def holds(self, limit):
        """Return whether the limit was kept; None where there is no limit. A NaN keeps none."""
        if limit is None:
            return None
        return self.reached <= limit if self.better == LOWER else self.reached >= limit


def verdict(figure, limit):
    """Return the limit and what came of it in words: `at most 0.6 s: met`, or a dash without a limit."""
    if limit is None:
        return "-"
    bound = "at most" if figure.better == LOWER else "at least"
    return f"{bound} {quantity(limit, figure.unit)}: {'met' if figure.holds(limit) else 'missed'}"


def sentence(figure):
    """Return the figure as the line that ends a run."""
    least, aim = verdict(figure, figure.least), verdict(figure, figure.aim)
    return f"{figure.name}: {quantity(figure.reached, figure.unit)} (asked: {least}; aim: {aim})"


def quantity(value, unit):
    """Return a value with three significant digits and its unit."""
    return f"{number(value)} {unit}".rstrip()


def number(value):
    """Return a number with three significant digits, never in powers of ten; whole numbers in full."""
    if isinstance(value, int):
        return str(value)
    for limit, decimals in ((1, 3), (10, 2), (100, 1)):  # 0.123, 1.23, 12.3, 123
        if abs(value) < limit:
            return f"{value:.{decimals}f}"
    return f"{value:.0f}"
