"""The camera transformation against Mitsuba's camera."""

import pytest

from tests.support.documents import GROUND, scene, shape

pytestmark = pytest.mark.oracle

VIEWS = {
    "from_the_right": {"position": [4.0, 0.5, 0.3]},
    "from_behind": {"position": [-0.5, 1.0, 4.2]},
    "from_above": {"position": [0.1, 4.5, 0.2], "upVector": [0.0, 0.0, 1.0]},
    "from_below_and_rolled": {"position": [1.0, 0.1, -3.9], "upVector": [0.7, 1.0, 0.2]},
    "long_slanted_up": {"upVector": [0.0, 5.0, 4.0]},
    "wide": {"fov": 100.0, "position": [0.3, 0.5, -2.0]},
    "narrow_from_far": {"fov": 4.0, "position": [5.0, 9.0, -30.0]},
    "portrait": {"width": 120, "height": 200},
    "one_row": {"width": 300, "height": 3},
    "orthographic": {"type": "orthographic", "fov": 40.0},
    "orthographic_of_a_height": {"type": "orthographic", "viewHeight": 2.5, "upVector": [0.3, 1.0, 0.1]},
}


@pytest.mark.parametrize("view", VIEWS)
def test_camera(agree, view):
    """Every view of the same shapes agrees, so right is right, up is up and fov is vertical."""
    agree(scene(shape("cylinder"), shape("triangle"), GROUND, camera=VIEWS[view]), ("shape", "depth", "normal", "rgb"))
