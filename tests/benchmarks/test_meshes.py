"""The comparison of meshes with Mitsuba: both are given the same, and the arithmetic favours nobody."""

import dataclasses
from types import SimpleNamespace

import drjit as dr
import numpy as np
import pytest

import benchmarks.__main__ as command
from benchmarks import embree, mesh_memory, mesh_rays, meshes, stand_in, table
from benchmarks.measure import Effort
from benchmarks.mesh_scenes import KINDS, DiffusePicture, Light, bumpy, octahedron, soup
from tests.support import hoard

TINY = Effort(repeats=1, width=24, height=16, samples=3, triangles=900)


def test_mitsuba_traces_the_mesh_that_it_is_given():
    """Closed form: from the middle of an octahedron to |x| + |y| + |z| = r, and the triangle of the octant."""
    vertices, faces = bumpy(8)
    (rays,) = [rays for rays in mesh_rays.ray_sets(vertices, faces, 30, 20) if rays.name == "from inside"]
    host = dataclasses.replace(rays.orders[mesh_rays.AS_MADE], o=np.zeros((600, 3), np.float32))
    t, triangle = embree.closest(embree.build(embree.mesh_of(vertices, faces)), embree.rays_of(host), False)
    np.testing.assert_allclose(t.numpy(), abs(vertices).max() / abs(host.d).sum(axis=1), rtol=1e-5)
    towards = vertices[faces[triangle.numpy()]].sum(axis=1)
    assert (np.sign(towards) == np.sign(host.d)).all()


def test_paths_scatter_five_times():
    """In a closed room radiance is a polynomial in the reflectance: of degree five with the same paths, and no less."""
    vertices, faces = octahedron(1)
    room, reflectances = (6 * vertices.astype(np.float32), faces[:, ::-1]), np.linspace(0, 0.9, 8)
    pictures = [DiffusePicture(size=16, reflectance=float(albedo)) for albedo in reflectances]
    means = [np.mean(embree.DiffusePath(*room, picture).render(4, 0).numpy()) for picture in pictures]

    def misfit(degree):
        fit = np.polynomial.Polynomial.fit(reflectances, means, degree)
        return abs(fit(reflectances) - means).max() / max(means)

    assert misfit(5) < 1e-5 < misfit(4) / 5


@pytest.fixture
def quick(monkeypatch):
    """Measurements so short that their times mean nothing."""
    monkeypatch.setattr(meshes, "SHORTEST", 0.0)
    monkeypatch.setattr(meshes, "MEMORY_REPEATS", 1)


def test_stand_in_agrees_with_itself_and_is_not_judged(quick):
    """Mitsuba through our tracer's functions finds what it finds, and its figures are not called ours."""
    found = meshes.measure(TINY, stand_in)
    assert found["figures"] == [] and all("of the stand-in" in title for title in found["tables"])
    rays, building, memory, paths, fall = found["tables"].values()
    assert len(rays) == len(fall) == 10 and len(building) == len(memory) == 2 and len(paths) == 1
    for row in rays:
        assert row["rays that differ"] == 0 and not row["other triangle, same distance"]
        assert 0.02 < row["share that hits"] < 1
    assert paths[0]["mean radiance, x Mitsuba's"] == paths[0]["noise, x Mitsuba's"] == 1
    for rows in found["tables"].values():
        assert table.table(rows).count("\n") == len(rows) + 1


def test_wrong_tracer_is_noticed(quick, monkeypatch):
    """One that finds the right distances but the next triangle, and one whose shadow rays never end."""

    def closest(accel, o, d, coherent):
        t, triangle = stand_in.closest(accel, o, d, coherent)
        return t, triangle + 1

    def occluded(accel, o, d, distance, coherent):
        return stand_in.closest(accel, o, d, coherent)[0] < meshes.NO_HIT

    wrong = SimpleNamespace(build=stand_in.build, closest=closest, occluded=occluded)
    monkeypatch.setattr(mesh_rays, "Light", lambda: Light(centre=(0, 0, 0), side=1.0))  # shadow rays end inside
    rows = {row["rays"]: row for row in meshes._all_rays(wrong, soup(900), TINY)}
    for sort in (*meshes.INCOHERENT, "primary"):
        row = rows[sort]
        assert row["rays that differ"] == 0
        hits = row["share that hits"] * TINY.width * TINY.height
        assert row["other triangle, same distance"] == pytest.approx(hits)
    assert rows["shadow"]["rays that differ"] > 0


def test_disagreements_are_counted():
    """Hits on one side only and other distances differ, within roundoff another triangle; two misses agree."""
    ours = np.array([1.0, 1.0, 1e30, 1e30, 2.0, 1e-5], np.float32), np.array([0, 1, 2, 3, 4, 5])
    theirs = np.array([1.00005, 1.01, np.inf, 3.0, np.inf, 1.05e-5], np.float32), np.array([9, 9, 9, 9, 9, 5])
    counted = meshes.agreement(ours, theirs)
    assert counted == {"share that hits": 4 / 6, "rays that differ": 3, "other triangle, same distance": 1}
    blocked = meshes.agreement([np.array([True, False, True])], [np.array([True, True, False])])
    assert blocked["rays that differ"] == 2 and blocked["share that hits"] == pytest.approx(2 / 3)


def test_ratio_is_mitsubas_time_over_ours_in_the_best_order(monkeypatch):
    """Twice as slow is 0.5 x; each side is judged by its own best order, and Mitsuba by its faster hint."""
    seconds = {("ours", "rows"): 4.0, ("ours", "tiles"): 2.0, ("theirs", "rows"): 1.0, ("theirs", "tiles"): 3.0,
               False: 5.0, True: 4.0}  # fmt: skip
    monkeypatch.setattr(meshes, "interleaved", lambda actions, repeats, calls=1: {
        name: [seconds[name]] * repeats for name in actions})  # fmt: skip
    hints = []

    def traced(order, hint=None):
        hints.append(hint)
        return dr.llvm.Float([1.0, 2.0]), dr.llvm.UInt32([0, 1])

    host = SimpleNamespace(o=np.zeros((6, 3)))
    rays = SimpleNamespace(name="primary", orders=dict.fromkeys(("rows", "tiles"), host))
    theirs = SimpleNamespace(trace=traced, faster_hint=lambda: meshes.Theirs.faster_hint(theirs), _rays=rays.orders)
    row = meshes._compare(SimpleNamespace(trace=traced), theirs, rays, 3)
    assert row["x Mitsuba"] == {"median": 0.5, "min": 0.5, "max": 0.5}
    assert row["our M rays/CPU s"]["median"] == pytest.approx(3e-6)
    assert (row["order, ours"], row["order, Mitsuba"], row["Mitsuba's hint"]) == ("tiles", "rows", "coherent")
    assert hints == [None, True]


def test_fastest_action_fills_a_measurement(monkeypatch):
    """So many calls that clocks of 4 ms suffice."""
    asked = []

    def interleaved(actions, repeats, calls=1):
        asked.append((repeats, calls))
        return {"slow": [0.4] * repeats, "fast": [0.06] * repeats}

    monkeypatch.setattr(meshes, "interleaved", interleaved)
    meshes.in_turns({"slow": None, "fast": None}, 5)
    assert asked == [(1, 1), (5, 9)]


def test_fall_is_measured_by_the_logarithm():
    """A rate that falls as 1 / log n stays at 1; one that halves while the logarithm doubles, too."""
    rates = {256: 8.0, 65_536: 4.0, 2**32: 1.0}
    rows = [{"mesh": "bumpy", "rays": "bounce", "triangles": n, "our M rays/CPU s": {"median": rate},
             "Mitsuba's M rays/CPU s": {"median": 1.0}} for n, rate in rates.items()]  # fmt: skip
    assert [row["our, of 1"] for row in meshes.falls(rows)] == [1.0, 1.0, 0.5]
    assert [row["Mitsuba's, of 1"] for row in meshes.falls(rows)] == [1.0, 2.0, 4.0]


def test_largest_mesh_of_each_kind_is_judged():
    """Of the incoherent sets the slowest counts; build time and memory have to be low."""
    sorts = dict(zip(("from outside", "from inside", "bounce", "shadow", "primary"), (1.2, 0.9, 1.6, 1.1, 0.7)))
    rows = {title: [] for title in ("rays", "building", "memory", "diffuse paths", "fall")}
    for kind in KINDS:
        for n, factor in ((10, 5.0), (1000, 1.0)):
            about = {"mesh": kind, "triangles": n}
            rows["rays"] += [about | {"rays": sort, "x Mitsuba": {"median": factor * ratio}}
                             for sort, ratio in sorts.items()]  # fmt: skip
            rows["fall"] += [about | {"rays": sort, "our, of 1": factor * ratio} for sort, ratio in sorts.items()]
            rows["building"].append(about | {"time, x Mitsuba": {"median": 3.0 / factor}})
            rows["diffuse paths"].append(about | {"x Mitsuba": {"median": factor}})
        rows["memory"].append(about | {"our bytes/triangle, kept": {"median": 100.0}})
    judged = {figure.name.removeprefix("soup, 1000 triangles, "): figure for figure in meshes.figures(rows)}
    expected = {"slowest incoherent rays": (0.9, False, False), "shadow rays": (1.1, True, False),
                "primary rays": (0.7, True, False), "diffuse paths": (1.0, True, False),
                "time to build": (3.0, True, False), "memory": (100.0, True, False),
                "rate x log(triangles), least": (0.9, False, None)}  # fmt: skip
    for name, (reached, least, aim) in expected.items():
        figure = judged[name]
        assert (figure.reached, figure.holds(figure.least), figure.holds(figure.aim)) == (reached, least, aim), name
    assert len(meshes.figures(rows)) == 2 * len(expected)


def test_memory_is_what_a_build_keeps_and_needs():
    """A build that keeps 64 bytes a triangle, and needs 128 more for a while, is found to do so; its mesh is not."""
    count = 500_000
    grown = mesh_memory.grown(hoard.__name__, *soup(count))
    assert grown["kept"] / count == pytest.approx(hoard.KEPT, rel=0.05)
    assert grown["peak"] / count == pytest.approx(hoard.KEPT + hoard.FOR_A_WHILE, rel=0.05)


@pytest.mark.parametrize("largest, expected", [
    (10_000_000, [10_000, 100_000, 1_000_000, 10_000_000]), (999_999, [10_000, 100_000]), (500, [500]),
])  # fmt: skip
def test_sizes_go_up_to_the_largest(largest, expected):
    """Powers of ten, or the one small mesh that was asked for."""
    assert meshes.sizes(largest) == expected


@pytest.mark.parametrize("count", ["0", "-3", "20000000"])
def test_impossible_number_of_triangles_is_told(count, capsys):
    """Before anything is measured."""
    assert command.main(["meshes", "--triangles", count]) == command.BAD_INPUT
    assert f"--triangles {count} is not between 1 and 10000000" in capsys.readouterr().err


def test_number_of_triangles_is_passed_on_and_makes_a_run_partial(monkeypatch):
    """The committed results are those of the usual sizes."""
    asked = []
    monkeypatch.setattr(command, "run", lambda names, effort: asked.append((names, effort.triangles)) or {})
    monkeypatch.setattr(table, "page", lambda results: "")
    monkeypatch.setattr(table, "figures", lambda results: [])
    monkeypatch.setattr(table, "write", lambda results: asked.append("written"))
    assert command.main(["--triangles", "5000"]) == command.main(["meshes"]) == 0
    assert asked == [(list(command.BENCHMARKS), 5000), (["meshes"], 1_000_000)]
