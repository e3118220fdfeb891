"""Figures and numbers of the part `acceleration` of the report: none, grid, hierarchy and Mitsuba's Embree."""

from __future__ import annotations

import math
from pathlib import Path

from benchmarks.plots import OURS, STYLES, _bars
from tools.report import drawing
from tools.report.results import ROOT, digits, row, seconds, table, times

RATE, TIME, BYTES = "{}, M rays/CPU s", "{}, CPU s", "{}, bytes/triangle"
NAMES = {"none": "none", "grid": "grid", "bvh": "hierarchy", "Mitsuba": "Embree"}
LOOKS = {"none": ("#6b6b6b", "^", 1.0), "grid": ("#009e73", "s", 1.2), "bvh": OURS, "Mitsuba": STYLES["llvm", False]}
SORTS = ("primary", "from outside", "from inside", "bounce", "shadow")
TOLD = {"primary": "camera", "bounce": "bounced"}
MARKS = (("#f0b27a", "o"), ("#d55e00", "s"), ("#7b3200", "D"))  # of sizes, the smallest first
MESHES = ("bumpy", "soup")
TRIED = ("one ray a lane", "a new ray", "coherent rays in groups", "records by single", "two triangles a record",
         "stack read", "two rays a lane", "8-bit planes", "six children", "two paths", "next record",
         "huge pages")  # fmt: skip


def make(folder: Path) -> dict:
    """Return the part's numbers."""
    with drawing.in_print():
        drawing.save(of_growth(), folder / "growth.svg")
        drawing.save(of_sorts(), folder / "sorts.svg")
    return growth() | sorts() | built() | others() | {"tried": tried()}


def of_growth():
    """Return plots of rates and of the time to build over the number of triangles of the bumpy mesh."""
    figure, grid = drawing.sheet(drawing.PAGE, 1.95, ncols=4)
    panels = [("bounced rays, bumpy mesh", "rates", RATE, {"mesh": "bumpy", "rays": "bounce"}),
              ("camera's rays, bumpy mesh", "rates", RATE, {"mesh": "bumpy", "rays": "primary"}),
              ("bounced rays, soup", "rates", RATE, {"mesh": "soup", "rays": "bounce"}),
              ("building, bumpy mesh", "building", TIME, {"mesh": "bumpy"})]  # fmt: skip
    for axes, (title, name, key, wanted) in zip(grid, panels):
        rows = [one for one in table("growth", name) if all(one[k] == value for k, value in wanted.items())]
        for contender, (colour, marker, width) in LOOKS.items():
            values = [one[key.format(contender)] for one in rows]
            axes.errorbar([one["triangles"] for one in rows], [v["median"] for v in values], yerr=_bars(values),
                          color=colour, marker=marker, linewidth=width, elinewidth=0.6, label=NAMES[contender])
        axes.set(xscale="log", yscale="log", title=title, xlabel="triangles")
        axes.set_ylabel("CPU s" if name == "building" else "M rays a CPU second" if axes is grid[0] else "")
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(LOOKS))
    return figure


def of_sorts():
    """Return a plot of the hierarchy's rate over Embree's, by sort of rays, mesh and number of triangles."""
    figure, grid = drawing.sheet(drawing.COLUMN, 2.1, ncols=2, sharey=True)
    for axes, mesh in zip(grid, MESHES):
        sizes = sorted({one["triangles"] for one in table("meshes", "rays") if one["mesh"] == mesh})
        for k, size in enumerate(sizes):
            ratios = [row("meshes", "rays", mesh=mesh, triangles=size, rays=sort)["x Mitsuba"] for sort in SORTS]
            places = [place + 0.24 * (k - (len(sizes) - 1) / 2) for place in range(len(SORTS))]
            colour, marker = MARKS[k]
            axes.errorbar([one["median"] for one in ratios], places, xerr=_bars(ratios), color=colour, marker=marker,
                          linestyle="none", elinewidth=0.6, label=f"{round_size(size)} triangles")  # fmt: skip
        axes.axvline(1, color="#222222", linewidth=0.6)
        axes.set(title=f"{mesh} mesh" if mesh == "bumpy" else mesh, xlim=(0, 1.85),
                 yticks=range(len(SORTS)), yticklabels=[TOLD.get(sort, sort) for sort in SORTS])  # fmt: skip
    grid[0].invert_yaxis()
    figure.supxlabel("rate, times Embree's", fontsize=drawing.SIZE)
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, columnspacing=0.8, handletextpad=0.1)
    return figure


def round_size(count):
    """Return about how many triangles there are, as a plot names them."""
    return {4: "10,000", 5: "100,000", 6: "a million"}[round(math.log10(count))]


def growth():
    """Return what the finest mesh does to each contender, and how much the hierarchy is worth there."""
    numbers = {}
    for mesh in MESHES:
        rows = [one for one in table("growth", "rates") if one["mesh"] == mesh and one["rays"] == "bounce"]
        first, last = min(rows, key=_size), max(rows, key=_size)
        for name in NAMES:
            numbers[f"{mesh}_{name}_falls"] = digits(_rate(first, name) / _rate(last, name))
        numbers |= {f"{mesh}_over_none": times(_rate(last, "bvh") / _rate(last, "none")),
                    f"{mesh}_over_grid": times(_rate(last, "bvh") / _rate(last, "grid"))}  # fmt: skip
        numbers |= {f"{mesh}_grows": f"{int(round(last['triangles'] / first['triangles'], -2)):,}",
                    f"{mesh}_most": f"{last['triangles']:,}"}  # fmt: skip
    return numbers


def _size(one):
    return one["triangles"]


def _rate(one, name):
    return one[RATE.format(name)]["median"]


def sorts():
    """Return the ratios to Embree that the text names: least and greatest by sort of rays over all meshes."""
    rows = table("meshes", "rays")
    numbers = {}
    for name, names in {"incoherent": SORTS[1:4], "shadow": ("shadow",), "camera": ("primary",)}.items():
        ratios = [one["x Mitsuba"]["median"] for one in rows if one["rays"] in names]
        numbers |= {f"{name}_least": digits(min(ratios)), f"{name}_most": times(max(ratios))}
    paths = [one["x Mitsuba"]["median"] for one in table("meshes", "diffuse paths")]
    numbers |= {"paths_least": digits(min(paths)), "paths_most": times(max(paths))}
    differ = sum(one["rays that differ"] for one in rows)
    return numbers | {"rays_differ": f"{differ:,}", "rays_compared": f"{len(rows) * _rays() / 1e6:.0f} million"}


def _rays():
    """Return how many rays a set of the benchmark has."""
    from tools.report.results import results

    return results()["effort"]["width"] * results()["effort"]["height"]


def built():
    """Return the table of building and memory at the largest number of triangles."""
    rows = []
    for mesh in MESHES:
        ours = max((one for one in table("growth", "building") if one["mesh"] == mesh), key=_size)
        memory = max((one for one in table("meshes", "memory") if one["mesh"] == mesh), key=_size)
        for name, told in NAMES.items():
            theirs = memory["Mitsuba's bytes/triangle, kept"]["median"]
            held = digits(theirs if name == "Mitsuba" else ours[BYTES.format(name)])
            peak = {"bvh": "our", "Mitsuba": "Mitsuba's"}.get(name)
            rows.append([mesh if name == "none" else "", told, seconds(ours[TIME.format(name)]["median"]), held,
                         digits(memory[f"{peak} bytes/triangle, peak"]["median"], 3) if peak else "-"])  # fmt: skip
    return {"building": rows}


def tried():
    """Return rows of the table of what was tried in docs/acceleration.md: those that begin as TRIED says."""
    section = (ROOT / "docs" / "acceleration.md").read_text().split("## What was tried")[1]
    found = [[cell.strip().replace("`", "") for cell in line.strip("|\n").split("|")]
             for line in section.splitlines() if line.startswith("| ")]  # fmt: skip
    rows = [row for start in TRIED for row in found if row[0].startswith(start)]
    if len(rows) != len(TRIED):
        raise KeyError(f"docs/acceleration.md has not all of {TRIED}")
    return rows


def others():
    """Return where the hierarchy begins to pay, and what the grid does with a mesh in a stadium."""
    crossing = table("structures", "crossover")
    rate = {way: f"from inside, {way}, M rays/CPU s" for way in ("unrolled", "hierarchy")}
    ratio = {one["spheres"]: one[rate["unrolled"]]["median"] / one[rate["hierarchy"]]["median"] for one in crossing}
    pays = min(count for count in ratio if ratio[count] < 1)
    few = min(ratio)
    stadium = row("structures", "structures", scene="mesh in a stadium", rays="from inside")
    alone = row("structures", "structures", scene="bumpy mesh", rays="from inside")
    return {
        "pays_from": f"{pays}", "pays_not": f"{max(count for count in ratio if count < pays)}",
        "few": f"{few}", "few_ratio": times(ratio[few]),
        "stadium_grid": digits(_rate(alone, "grid") / _rate(stadium, "grid")),
        "stadium_bvh": digits(_rate(alone, "bvh") / _rate(stadium, "bvh")),
    }  # fmt: skip
