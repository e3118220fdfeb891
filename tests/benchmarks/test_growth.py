"""The comparison of structures over numbers of triangles: everyone gets the mesh, and what is told is of it."""

import dataclasses

import numpy as np
import pytest

from benchmarks import growth, mesh_rays
from benchmarks.measure import Effort
from benchmarks.mesh_scenes import bumpy, soup
from renderer.accel.records import WORDS

TINY = Effort(repeats=1, width=24, height=16, samples=3, triangles=100)


@pytest.fixture
def quick(monkeypatch):
    """Measurements so short that their times mean nothing."""
    monkeypatch.setattr(growth, "SHORTEST", 0.0)


def test_every_mesh_size_and_set_of_rays_has_a_row(quick):
    """All contenders have rates and times in each."""
    tables = growth.measure(TINY)["tables"]
    assert [(row["mesh"], row["rays"]) for row in tables["rates"]] == [
        (mesh, sort) for mesh in ("bumpy", "soup") for sort in growth.SORTS
    ]
    for name in (*growth.ACCELS, growth.MITSUBA):
        assert all(row[f"{name}, M rays/CPU s"]["median"] > 0 for row in tables["rates"])
        assert all(row[f"{name}, CPU s"]["median"] > 0 for row in tables["building"])


def test_bytes_are_those_of_the_records():
    """Closed form: a soup has a record a triangle and no pairs; the hierarchy has a node more for three children."""
    count = 200
    none, bvh = (growth.held(growth._of(accel, *soup(count)).structure) for accel in ("none", "bvh"))
    record = 4 * WORDS
    assert none == record * count + 4  # and how many there are
    assert record * (count + (count - 1) / 3) <= bvh < record * 2 * count


def test_every_structure_finds_the_same(quick):
    """What is timed is the same work: all rays, and the same hits."""
    arrays = bumpy(128)
    (rays,) = [rays for rays in mesh_rays.ray_sets(*arrays, 24, 16) if rays.name == "bounce"]
    host = rays.orders[mesh_rays.AS_MADE]
    hits = [growth._trace(growth._of(accel, *arrays), host, False)() for accel in growth.ACCELS]
    assert len(hits[0].index) == 24 * 16
    assert all(np.array_equal(hits[0].index.numpy(), hit.index.numpy()) for hit in hits[1:])


def test_thinned_rays_are_some_of_all():
    """Every third ray, origin and direction together."""
    numbers = np.arange(21, dtype=np.float32).reshape(7, 3)
    (rays,) = [rays for rays in mesh_rays.ray_sets(*bumpy(128), 6, 4) if rays.name == "bounce"]
    host = dataclasses.replace(rays.orders[mesh_rays.AS_MADE], o=numbers, d=-numbers)
    few = growth._thinned(host, 3)
    assert few.o[:, 0].tolist() == [0, 9, 18] and np.array_equal(few.d, -few.o) and few.distance is None
