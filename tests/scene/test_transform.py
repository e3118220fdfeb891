"""Transformation steps as matrices: where points go."""

import math
from types import SimpleNamespace

import pytest

from renderer.scene.transform import determinant, matrix

EMPTY = dict.fromkeys(("translate", "scale", "rotate", "matrix"))


def step(**given):
    """Return a step with one key, as the description holds it."""
    if "rotate" in given:
        axis, angle = given["rotate"]
        given["rotate"] = SimpleNamespace(axis=axis, angle=angle)
    return SimpleNamespace(**EMPTY | given)


def moved(steps, point):
    """Return where a point goes."""
    return [sum(a * x for a, x in zip(row, (*point, 1.0), strict=True)) for row in matrix(steps)]


SHEAR = (1.0, 2.0, 0.0, 3.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("steps, point, expected", [
    ([], (1, 2, 3), (1, 2, 3)),
    ([step(translate=(1.0, 2.0, 3.0))], (10, 20, 30), (11, 22, 33)),
    ([step(scale=(2.0, 3.0, -4.0))], (1, 1, 1), (2, 3, -4)),
    ([step(rotate=((0.0, 0.0, 2.0), 90.0))], (1, 0, 0), (0, 1, 0)),
    ([step(rotate=((0.0, 5.0, 0.0), 90.0))], (0, 0, 1), (1, 0, 0)),
    ([step(rotate=((1.0, 0.0, 0.0), -90.0))], (0, 1, 0), (0, 0, -1)),
    ([step(rotate=((0.0, 0.0, 1.0), 540.0))], (1, 2, 3), (-1, -2, 3)),
    ([step(matrix=SHEAR)], (1, 10, 5), (24, 10, 5)),
    ([step(translate=(1.0, 0.0, 0.0)), step(scale=(2.0, 2.0, 2.0))], (1, 1, 1), (4, 2, 2)),
    ([step(scale=(2.0, 2.0, 2.0)), step(translate=(1.0, 0.0, 0.0))], (1, 1, 1), (3, 2, 2)),
    ([step(rotate=((0.0, 0.0, 1.0), 90.0)), step(scale=(2.0, 1.0, 1.0)), step(translate=(0.0, 0.0, 7.0))], (0, 1, 0),
     (-2, 0, 7)),
])
def test_points_go_where_the_steps_say(steps, point, expected):
    """Each step alone, and several in their order; quarter turns are exact."""
    assert moved(steps, point) == [*expected, 1]


def test_thirds_of_a_turn_around_the_diagonal_permute_the_axes():
    """A rotation that no quarter turn is."""
    steps = [step(rotate=((1.0, 1.0, 1.0), 120.0))]
    assert moved(steps, (1, 2, 3)) == pytest.approx([3, 1, 2, 1])


def test_rotation_keeps_lengths_and_turns_by_its_angle():
    """Also by angles that are no fraction of a turn."""
    to = moved([step(rotate=((0.0, 3.0, 4.0), 33.0))], (1, 0, 0))[:3]
    assert math.hypot(*to) == pytest.approx(1)
    assert math.degrees(math.acos(to[0])) == pytest.approx(33)  # (1, 0, 0) is perpendicular to the axis


@pytest.mark.parametrize("steps, expected", [
    ([step(scale=(2.0, 3.0, -4.0)), step(rotate=((1.0, 2.0, 3.0), 77.0)), step(translate=(1.0, 1.0, 1.0))], -24),
    ([step(matrix=SHEAR)], 1),
])
def test_determinant_is_the_factor_of_volumes(steps, expected):
    """Rotations, translations and shears keep it; mirrors make it negative."""
    assert determinant(matrix(steps)) == pytest.approx(expected)
