"""How busy lanes are: steps of paths are counted one by one, and put into packets in several ways.

Nothing is timed. The integrator tells how many steps each sample of each pixel takes. A packet takes as many as the
longest of its lanes; the others are idle for the rest.
"""

from __future__ import annotations

from pathlib import Path

import drjit as dr
import numpy as np

from benchmarks import plots
from renderer.core.backend import Bool, UInt32, new_scope
from renderer.engine.loop import pixel_corner
from renderer.engine.render import set_up
from renderer.engine.tiles import NO_PIXEL, PACKET, Tiles
from renderer.samplers.base import Draws
from renderer.scene.loader import load, override
from tools.report import drawing, pairs, results

SIZE = 300, 200  # of the pictures whose paths are counted
SAMPLES = 64  # a pixel
PASSES = 1, 2, 4, 8, 16, 32, 64  # samples a pixel in a pass
SHOWN = 16  # samples a pixel of the packet that is drawn
SCENES = CORNELL, STUDIO, SCENE = "cornell", "studio", "scene"
SHADES, IDLE = ("#0072b2", "#7ab8dc"), "#e8e6e1"  # of samples in turn, and of idle lanes
ALONE, PIXEL, TILE = "a lane a sample", "a lane a pixel", "a lane several pixels"


def make(folder: Path) -> dict[str, str | list]:
    """Write packets.svg and passes.svg, and return what was counted and what was measured."""
    steps = {name: steps_taken(name) for name in SCENES}
    shares = {name: shares_busy(counted) for name, counted in steps.items()}
    without, renewed = median_packet(steps[CORNELL])
    with drawing.in_print():
        drawing.save(of_packets(without, renewed), folder / "packets.svg")
        drawing.save(of_passes(shares), folder / "passes.svg")
    told = {"packet_gain": results.times(without.shape[1] / renewed.shape[1]), "samples": str(SAMPLES)}
    for name in SCENES:
        told |= {f"{name}_mean": results.digits(steps[name].mean()), f"{name}_longest": str(steps[name].max())}
        for key, way in (("alone", ALONE), ("pixel", PIXEL), ("tile", TILE)):
            first, last = (shares[name][way][samples] for samples in (PASSES[0], PASSES[-1]))
            told |= {f"{name}_{key}": percent(last), f"{name}_{key}_first": percent(first)}
    return told | {"variants": variants(), **{key: undone(name) for key, name in UNDONE.items()}}


def made_up(name):
    """Return lengths of paths that no scene has, for tests."""
    return np.random.default_rng(len(name)).integers(1, 9, (SAMPLES, SIZE[1] // 4, SIZE[0] // 4)).astype(np.uint16)


@pairs.slow(made_up)
def steps_taken(name):
    """Return the steps of the integrator, (samples, height, width) uint16, in a scene of the repository."""
    loaded = load(str(results.ROOT / "scenes" / f"{name}.json"))
    _, view = set_up(override(loaded, width=SIZE[0], height=SIZE[1], samples=SAMPLES))
    pixels, integrator = view.width * view.height, view.integrator
    taken = np.empty((SAMPLES, view.height, view.width), np.uint16)
    for number in range(SAMPLES):
        new_scope()
        pixel, sample = dr.arange(UInt32, pixels), dr.opaque(UInt32, number) + dr.zeros(UInt32, pixels)
        sampler = view.sampler(pixel, dr.opaque(UInt32, view.seed))
        corner = pixel_corner(pixel, dr.opaque(UInt32, view.width))
        o, d, _ = view.ray(sampler, corner, sample)
        path = integrator.restart(integrator.start(pixels), True, o, d)

        def advance(path, count, alive):
            _, goes_on, path = integrator.step(path, Draws(sampler, sample))
            return path, count + dr.select(alive, UInt32(1), 0), alive & goes_on

        state = path, dr.zeros(UInt32, pixels), dr.full(Bool, True, pixels)
        count = dr.while_loop(state, lambda path, count, alive: alive, advance, label="steps of a sample")[1]
        taken[number] = count.numpy().reshape(view.height, view.width)
    return taken


def shares_busy(steps):
    """Return {way: {samples of a pass: share of the lanes' steps that are not idle}}."""
    alone = busy(lane_a_sample(steps))
    return {ALONE: dict.fromkeys(PASSES, alone),
            PIXEL: {samples: busy(lane_a_pixel(steps, samples)) for samples in PASSES},
            TILE: {samples: busy(lane_a_tile(steps, samples)) for samples in PASSES}}  # fmt: skip


def busy(packets):
    """Return the share of busy lanes, of the steps of lanes by packet, (packets, 16)."""
    return float(packets.sum() / (PACKET * packets.max(1).sum(dtype=np.int64)))


def lane_a_sample(steps):
    """Return the steps of lanes by packet where a packet has 16 samples of one pixel, and no others."""
    samples = len(steps) // PACKET * PACKET
    return np.moveaxis(steps[:samples].reshape(-1, PACKET, steps[0].size), 1, 2).reshape(-1, PACKET).astype(np.int64)


def lane_a_pixel(steps, samples):
    """Return the same where a packet has 16 pixels of a row, and a pass so many samples of each."""
    width = steps.shape[2] // PACKET * PACKET
    return _passes(steps, samples)[:, :, :width].reshape(-1, PACKET)


def lane_a_tile(steps, samples):
    """Return the same where lanes render several pixels of a tile in turn, those of engine/tiles.py."""
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
    """Return the steps of pixels in each pass of so many samples, (passes, height, width)."""
    return steps.reshape(-1, samples, *steps.shape[1:]).sum(1, dtype=np.int64)


def median_packet(steps):
    """Return two arrays (16, steps) of which sample lanes are at, -1 where they are idle: alone, and renewed.

    The packet is that whose gain is the median of all. Alone, it renders the samples of one pixel after another.
    """
    few = steps[:SHOWN, :, : steps.shape[2] // PACKET * PACKET].reshape(SHOWN, -1, PACKET).astype(int)
    gain = few.max(0).sum(1) / few.sum(0).max(1)
    packet = few[:, np.argsort(gain, kind="stable")[len(gain) // 2]]
    ends = packet.max(0).cumsum()
    alone, renewed = -np.ones((PACKET, ends[-1]), int), -np.ones((PACKET, packet.sum(0).max()), int)
    for pixel, end in enumerate(ends):
        begin = 0
        for sample, count in enumerate(packet[:, pixel]):
            start = end - packet[:, pixel].max()
            alone[sample, start : start + count] = pixel
            renewed[pixel, begin : begin + count] = sample
            begin += count
    return alone, renewed


UNDONE = {"undone_alone": "one lane a sample", "undone_unrolled": "loops instead of unrolling",
          "undone_selects": "gathers instead of selects"}  # fmt: skip


def undone(name):
    """Return how many times the time `scene` takes with a decision undone."""
    return results.times(results.median(results.row("variants", "variants", variant=name)["time, x as it is"]))


def percent(share):
    """Return a share as per cent; as 100 % only if nothing is missing."""
    return results.percent(share, 3 if 0.99 < share < 1 else 2)


def variants():
    """Return rows of variant, throughput and time, of the benchmark `variants`."""
    rows = results.table("variants", "variants")
    return [[row["variant"], *(results.digits(results.median(row[key]), count)
            for key, count in (("M samples/CPU s", 3), ("time, x as it is", 3)))] for row in rows]  # fmt: skip


def of_packets(alone, renewed):
    """Return both packets as bars of lanes over steps, on one scale."""
    figure, axes = drawing.sheet(drawing.COLUMN, 2.1, nrows=2, sharex=True)
    for ax, lanes, told in zip(axes, (alone, renewed), (ALONE, f"{PIXEL}, sample after sample")):
        ax.barh(PACKET / 2, lanes.shape[1], height=PACKET, color=IDLE, linewidth=0)
        for lane, numbers in enumerate(lanes):
            edges = np.flatnonzero(np.diff(numbers, prepend=-2, append=-2))
            for begin, end in zip(edges, edges[1:]):
                if numbers[begin] >= 0:
                    shade = SHADES[numbers[begin] % 2]
                    ax.barh(lane + 0.5, end - begin, left=begin, height=0.84, color=shade, linewidth=0)
        ax.set(xlim=(0, alone.shape[1]), ylim=(PACKET, 0), yticks=[], ylabel=f"{PACKET} lanes")
        ax.set_title(f"{told}: {percent((lanes >= 0).mean())} busy")
        ax.spines["left"].set_visible(False)
    axes[-1].set_xlabel("steps of the loop")
    return figure


def of_passes(shares):
    """Return the share of busy lanes over the samples of a pass, of two scenes."""
    figure, axes = drawing.sheet(drawing.COLUMN, 1.75, ncols=2, sharey=True)
    for ax, name in zip(axes, (CORNELL, STUDIO)):
        for way, style in ((TILE, {"color": plots.OURS[0], "marker": "D"}),
                           (PIXEL, {"color": SHADES[0], "marker": "o"}),
                           (ALONE, {"color": "#777777", "linestyle": "--"})):  # fmt: skip
            if name != CORNELL or way != TILE:  # without a hierarchy there are no tiles
                ax.plot(PASSES, [100 * shares[name][way][samples] for samples in PASSES], label=way, **style)
        ax.set(xscale="log", xlabel="samples in a pass", xticks=PASSES, xticklabels=PASSES, ylim=(40, 100))
        ax.set_title(f"{name}.json")
        ax.minorticks_off()
        ax.grid(True, color=plots.FAINT, linewidth=0.4)
    axes[0].set_ylabel("busy lanes, %")
    figure.legend(*axes[1].get_legend_handles_labels(), loc="outside lower center", ncols=3, columnspacing=1)
    return figure
