"""The exact decision which rays meet a fan can say no."""

import numpy as np
import pytest

from tests.stability import edges


def test_rays_at_fans_meet_them_and_those_beside_do_not():
    """What aims at the common corner is met for certain; half the way to the next fan nothing is."""
    middle, rim, o, d = edges.fans()
    few = slice(0, 2)
    assert edges.truly_met()[few].all()
    beside = o[few] + [edges.APART / 2, 0, 0]
    assert not edges.exactly_met(middle[few], rim[few], beside, d[few]).any()


@pytest.mark.parametrize("share, met", [(0.25, True), (0.5, True), (0.5 + 2.0**-13, False), (0.75, False)])
def test_rays_at_a_blade_meet_it_up_to_its_outer_edge(share, met):
    """The middle of that edge included, which the ray passes exactly."""
    middle, rim, _, _ = (part[:1] for part in edges.fans())
    assert (middle == 0).all()
    corners = np.round(rim[:, :2] * 2**6) / 2**6  # so that products have few bits
    rim = np.concatenate([corners, rim[:, 2:]], 1)
    o = (share * corners.sum(1) + [0, 0, 3])[:, None]
    assert edges.exactly_met(middle, rim, o, np.array([[[0.0, 0, -1]]])).all() == met
