"""What the cases of leaving find where a guard is taken away."""

import pytest

from renderer.scene import geometry, triangles
from renderer.shapes import base
from tests.stability import contact, leaving, seams, stage


@pytest.fixture(autouse=True)
def forgotten():
    """Scenes and hits are made anew before and after."""
    caches = stage.scene, leaving.met, seams.neighbours, contact.pair
    for cache in caches:
        cache.cache_clear()
    yield
    for cache in caches:
        cache.cache_clear()


@pytest.mark.parametrize("module, name", [(geometry, "LEAVE_ULPS"), (base, "SHEET_ROUNDOFFS")])
def test_both_roundings_of_sheets_are_needed(monkeypatch, module, name):
    """That of the origin far from the world's, that of the sheet near it."""
    monkeypatch.setattr(module, name, 0.0)
    assert seams.at_seams(stage.ours).any()


def test_meshes_must_be_started_off(monkeypatch):
    """Rays that start where they hit meet a neighbour of their triangle."""
    monkeypatch.setattr(triangles, "POINT_ROUNDOFFS", 0.0)
    monkeypatch.setattr(triangles, "EDGE_ROUNDOFFS", 0.0)
    assert leaving.again(["ball"], stage.ours).any()


@pytest.mark.parametrize("name", ["POINT_ROUNDOFFS", "EDGE_ROUNDOFFS"])
def test_both_roundings_of_meshes_are_needed(monkeypatch, name):
    """That of the point, and that of the neighbours' corners."""
    monkeypatch.setattr(triangles, name, 0.0)
    assert seams.at_seams(stage.ours).any()


def test_wider_bounds_hide_what_is_close(monkeypatch):
    """Guards as wide as eight times the rounding lose surfaces in near contact."""
    monkeypatch.setattr(geometry, "LEAVE_ULPS", 16.0)
    assert contact.unseen(stage.ours).any()
