"""What the report tells of lanes: counted steps, put into packets."""

import numpy as np
import pytest

from renderer.engine import tiles
from tools.report import lanes

WIDTH, HEIGHT, SAMPLES = 32, 16, 16


@pytest.fixture
def steps():
    """Lengths of paths from 1 to 7."""
    return np.random.default_rng(3).integers(1, 8, (SAMPLES, HEIGHT, WIDTH)).astype(np.uint16)


@pytest.mark.parametrize("way", [lanes.lane_a_pixel, lanes.lane_a_tile])
@pytest.mark.parametrize("samples", [1, 4, 16])
def test_packets_have_all_steps(steps, way, samples, monkeypatch):
    """No step is lost or counted twice, however lanes are put together; tiles have several pixels a lane."""
    monkeypatch.setattr(tiles, "PACKETS_A_THREAD", 0)
    assert int(tiles.Tiles(WIDTH, 0, WIDTH * HEIGHT).turns[0]) > 1
    packets = way(steps, samples)
    assert packets.shape[1] == 16 and packets.sum() == steps.sum()


def test_a_lane_a_sample_waits_for_the_longest_of_its_pixel(steps):
    packets = lanes.lane_a_sample(steps)
    assert packets.shape == (HEIGHT * WIDTH, 16)
    assert (packets.max(1) == steps.max(0).ravel()).all()


def test_share_of_busy_lanes():
    """Of a packet whose lanes have 1 to 16 steps, 136 of 256 are not idle."""
    assert lanes.busy(np.arange(1, 17)[None]) == pytest.approx(136 / 256)


def test_equal_paths_keep_all_lanes_busy():
    shares = lanes.shares_busy(np.full((lanes.SAMPLES, HEIGHT, WIDTH), 3, np.uint16))
    assert {share for way in shares.values() for share in way.values()} == {1.0}


def test_more_samples_in_a_pass_keep_more_lanes_busy(steps):
    shares = [lanes.busy(lanes.lane_a_pixel(steps, samples)) for samples in (1, 4, 16)]
    assert shares == sorted(shares) and shares[0] < shares[-1] - 0.1


def test_packet_that_is_drawn_has_each_step_once(steps):
    """Alone and renewed: as many turns of each pixel as its samples take; and renewed ends earlier."""
    alone, renewed = lanes.median_packet(steps)
    assert (alone >= 0).sum() == (renewed >= 0).sum()
    assert renewed.shape[1] < alone.shape[1]
    turns = [np.bincount(lane[lane >= 0], minlength=16) for lane in alone]
    renewed_turns = [np.bincount(lane[lane >= 0], minlength=16) for lane in renewed]
    assert (np.array(turns) == np.array(renewed_turns).T).all()


def test_lanes_are_renewed_without_a_pause(steps):
    """A lane is idle only after its last sample."""
    _, renewed = lanes.median_packet(steps)
    for lane in renewed:
        length = (lane >= 0).sum()
        assert (lane[:length] >= 0).all() and (np.diff(lane[:length]) >= 0).all()


@pytest.mark.parametrize("share, text", [(0.56, "56"), (0.995, "99.5"), (1.0, "100")])
def test_all_are_busy_only_if_none_is_idle(share, text):
    assert lanes.percent(share).startswith(text + "\u202f")


@pytest.mark.slow
def test_steps_are_those_of_paths(monkeypatch):
    """In the closed Cornell box every path takes a step, and none more than its bounces and one."""
    monkeypatch.setattr(lanes, "SIZE", (32, 32))
    monkeypatch.setattr(lanes, "SAMPLES", 2)
    steps = lanes.steps_taken(lanes.CORNELL)
    assert steps.shape == (2, 32, 32) and steps.min() >= 1 and 5 < steps.max() <= 13
