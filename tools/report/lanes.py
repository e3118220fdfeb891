"""How busy lanes are: steps of paths counted one by one, and put into packets as the renderer and others put them.

Nothing here is timed. The integrator is asked for the steps that each sample of each pixel takes; a packet takes as
many steps as the longest of its lanes, and its lanes are busy for the rest of what they have.
"""

from __future__ import annotations

import math
from pathlib import Path

import drjit as dr
import numpy as np

from benchmarks import plots
from renderer.core.backend import Bool, UInt32, new_scope
from renderer.engine.loop import camera_ray, pixel_corner
from renderer.engine.render import set_up
from renderer.engine.tiles import NO_PIXEL, PACKET, Tiles
from renderer.samplers.base import Draws
from renderer.scene.loader import load, override
from tools.report import results

SIZE = 300, 200  # of the pictures whose paths are counted
SAMPLES = 64  # a pixel
SHOWN = 16  # samples a pixel of the packet that is drawn
FEW = 1, 2, 4, 8, 16, 32, 64  # samples of a pass
SCENES = "cornell", "studio", "scene"
CORNELL, STUDIO, SCENE = SCENES
SHADES, IDLE = ("#0072b2", "#7ab8dc"), "#e8e6e1"  # of paths in turn, and of lanes that wait


def make(folder: Path) -> dict[str, str | list]:
    """Write packets.svg and passes.svg, and return what was counted."""
    import matplotlib

    steps = {name: steps_taken(name) for name in SCENES}
    tiled = {samples: busy(in_tiles(steps[STUDIO], samples)) for samples in FEW}
    rows = {name: {samples: busy(in_rows(steps[name], samples)) for samples in FEW} for name in SCENES}
    alone = {name: busy(lane_a_sample(steps[name])) for name in SCENES}
    without, regenerated = median_packet(steps[CORNELL])
    with matplotlib.rc_context(plots.SETTINGS | {"font.size": 8}):
        _save(_of_packets(without, regenerated), folder / "packets.svg")
        _save(_of_passes(rows, tiled, alone), folder / "passes.svg")
    least, most = min(FEW), max(FEW)
    told = {f"{name}_mean": f"{steps[name].mean():.1f}" for name in SCENES}
    told |= {f"{name}_longest": str(steps[name].max()) for name in SCENES}
    told |= {f"{name}_alone": _percent(alone[name]) for name in SCENES}
    told |= {f"{name}_one": _percent(rows[name][least]) for name in SCENES}
    told |= {f"{name}_pixel": _percent(rows[name][most]) for name in SCENES}
    told |= {"studio_tile_one": _percent(tiled[least]), "studio_tile": _percent(tiled[most]), "samples": str(most)}
    told |= {"packet_without": str(without.shape[1]), "packet_with": str(regenerated.shape[1]),
             "packet_saved": f"{without.shape[1] / regenerated.shape[1]:.1f} times"}  # fmt: skip
    return told | {"variants": variants(), "alone_cost": _undone("one lane a sample")}


def steps_taken(name):
    """Return the steps that the integrator takes, (samples, height, width) uint16, of a scene of the repository."""
    loaded = load(str(results.ROOT / "scenes" / f"{name}.json"))
    _, view = set_up(override(loaded, width=SIZE[0], height=SIZE[1], samples=SAMPLES))
    pixels, integrator = view.width * view.height, view.integrator
    taken = np.empty((SAMPLES, view.height, view.width), np.uint16)
    for number in range(SAMPLES):
        new_scope()
        pixel, sample = dr.arange(UInt32, pixels), dr.opaque(UInt32, number) + dr.zeros(UInt32, pixels)
        sampler = view.sampler(pixel, dr.opaque(UInt32, view.seed))
        corner = pixel_corner(pixel, dr.opaque(UInt32, view.width))
        o, d, _ = camera_ray(view.camera, sampler, corner, sample, view.centred, view.pixel_filter)
        path = integrator.restart(integrator.start(pixels), True, o, d)

        def advance(path, count, alive):
            _, goes_on, path = integrator.step(path, Draws(sampler, sample))
            return path, count + dr.select(alive, UInt32(1), 0), alive & goes_on

        state = path, dr.zeros(UInt32, pixels), dr.full(Bool, True, pixels)
        count = dr.while_loop(state, lambda path, count, alive: alive, advance, label="steps of a sample")[1]
        taken[number] = count.numpy().reshape(view.height, view.width)
    return taken


def lane_a_sample(steps):
    """Return the steps of lanes by packet, (packets, 16), if a packet has 16 samples of one pixel, and no others."""
    samples = len(steps) // PACKET * PACKET
    return np.moveaxis(steps[:samples].reshape(-1, PACKET, steps[0].size), 1, 2).reshape(-1, PACKET)


def in_rows(steps, samples):
    """Return the same if a packet has 16 pixels side by side, and a pass so many samples of each."""
    width = steps.shape[2] // PACKET * PACKET
    return _passes(steps, samples)[:, :, :width].reshape(-1, PACKET)


def in_tiles(steps, samples):
    """Return the same if lanes render several pixels of a tile in turn, as engine/tiles.py says."""
    _, height, width = steps.shape
    tiles = Tiles(width, 0, height * width)
    work = _passes(steps, samples).reshape(-1, height * width)
    lanes = np.zeros((len(work), tiles.lanes), np.int64)
    for turn in range(int(tiles.turns[0])):
        pixel = tiles.pixel(dr.full(UInt32, turn, tiles.lanes)).numpy()
        there = pixel != NO_PIXEL
        lanes[:, there] += work[:, pixel[there]]
    return lanes.reshape(-1, PACKET)


def _passes(steps, samples):
    """Return the steps of the pixels in each pass of so many samples, (passes, height, width)."""
    return steps.reshape(-1, samples, *steps.shape[1:]).sum(1, dtype=np.int64)


def busy(packets):
    """Return the share of all lanes' time in which they have something to do."""
    return packets.sum() / (PACKET * packets.max(1).sum(dtype=np.int64))


def median_packet(steps):
    """Return (16, time) arrays of which sample a lane is at, -1 where it waits: without and with new samples in time.

    The packet is that of the median gain. Without, it renders all samples of one pixel after the other.
    """
    few = steps[:SHOWN, :, : steps.shape[2] // PACKET * PACKET].reshape(SHOWN, -1, PACKET)
    gain = few.max(0).sum(1) / few.sum(0, dtype=np.int64).max(1)
    packet = few[:, np.argsort(gain)[len(gain) // 2]].astype(int)
    without, regenerated = -np.ones((2, PACKET, packet.sum() + PACKET), int)
    time = 0
    for lane in range(PACKET):  # of those that render a pixel each, below
        for sample in range(SHOWN):
            without[sample, time : time + packet[sample, lane]] = lane
            begins = packet[:sample, lane].sum()
            regenerated[lane, begins : begins + packet[sample, lane]] = sample
        time += packet[:, lane].max()
    return without[:, :time], regenerated[:, : packet.sum(0).max()]


def variants():
    """Return rows of variant, throughput and time of the benchmark `variants`."""
    rows = results.table("variants", "variants")
    return [[row["variant"], f"{row['M samples/CPU s']['median']:.3g}", f"{row['time, x as it is']['median']:.2f}"]
            for row in rows]  # fmt: skip


def _undone(variant):
    """Return how many times the time a variant takes."""
    row = next(row for row in results.table("variants", "variants") if row["variant"] == variant)
    return f"{row['time, x as it is']['median']:.1f} times"


def _percent(share):
    return f"{100 * share:.0f} %"


def _of_packets(without, regenerated):
    """Return both packets as bars of lanes over time, on one scale."""
    figure, axes = plots_figure(6.8, 2.3, nrows=2, sharex=True)
    for ax, lanes, told in zip(axes, (without, regenerated), ("a lane a sample", "a lane a pixel, regenerated")):
        ax.add_patch(_rectangle(lanes.shape[1]))
        for lane, numbers in enumerate(lanes):
            _bars(ax, lane, numbers)
        ax.set(xlim=(0, without.shape[1]), ylim=(PACKET, 0), yticks=[], ylabel="lanes")
        ax.set_title(f"{told}: busy {_percent((lanes >= 0).mean())}", fontsize=8, fontweight="normal")
        ax.spines["left"].set_visible(False)
    axes[-1].set_xlabel("turns of the loop")
    return figure


def _rectangle(length):
    from matplotlib.patches import Rectangle

    return Rectangle((0, 0), length, PACKET, color=IDLE, linewidth=0)


def _bars(axes, lane, numbers):
    """Draw the samples of one lane, in shades that take turns."""
    edges = np.flatnonzero(np.diff(numbers, prepend=-2, append=-2))
    for begin, end in zip(edges, edges[1:]):
        if numbers[begin] >= 0:
            axes.barh(lane + 0.5, end - begin, left=begin, height=0.86, color=SHADES[numbers[begin] % 2], linewidth=0)


def _of_passes(rows, tiled, alone):
    """Return the share of busy lanes over the samples of a pass."""
    figure, axes = plots_figure(6.8, 2.2, ncols=2, sharey=True)
    for ax, name in zip(axes, (CORNELL, STUDIO)):
        ax.axhline(100 * alone[name], color=plots.STYLES["scalar", False][0], linestyle="--", label="a lane a sample")
        ax.plot(FEW, [100 * rows[name][n] for n in FEW], color=SHADES[0], marker="o", label="a lane a pixel")
        if name == STUDIO:
            ax.plot(FEW, [100 * tiled[n] for n in FEW], color=plots.OURS[0], marker="D", label="a lane a tile's pixels")
        ax.set(xscale="log", xlabel="samples of a pass", xticks=FEW, xticklabels=FEW, ylim=(40, 100))
        ax.set_title(f"{name}.json", fontsize=8, fontweight="normal")
        ax.minorticks_off()
        ax.grid(True, color=plots.FAINT, linewidth=0.4)
        ax.legend(frameon=False, fontsize=7, loc="lower right")
    axes[0].set_ylabel("lanes that are busy (%)")
    return figure


def plots_figure(width, height, **grid):
    """Return a figure without a window, and its axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(**grid)


def _save(figure, path):
    figure.savefig(path, metadata={"Date": None, "Creator": None})
