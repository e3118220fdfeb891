"""What the engine promises: the same bytes however the work is split, values as data, honest sums."""

import drjit as dr
import numpy as np
import pytest

from renderer.core import rows
from renderer.core.backend import UInt32
from renderer.engine import passes
from renderer.engine import render as engine
from renderer.engine.loop import pixel_corner
from renderer.engine.render import render, replay
from renderer.scene.loader import load, override
from tests.support.scenes import MATT, SHAPES, loaded, point_light

MIRROR = MATT | {"isreflective": True, "reflectivity": 0.6}
GLASS = MATT | {"isrefractive": True, "refractiveindex": 1.4}
LIGHTS = [point_light([2, 3, -4]), point_light([-2, 1, -3], [0.3, 0.2, 0.1])]


def mixed(tmp_path, materials=(MATT, MIRROR, GLASS), **keys):
    """Return a scene with every kind of shape, and materials in turn."""
    shapes = [settings[0] | {"material": materials[number % len(materials)]}
              for number, settings in enumerate(SHAPES.values())]  # fmt: skip
    return loaded(tmp_path, shapes, LIGHTS, **keys)


def test_passes_do_not_change_a_bit(tmp_path, monkeypatch):
    """Samples are added in their order, whatever the passes."""
    scene = mixed(tmp_path, samples=20)
    whole = render(scene).channels()["R"]
    monkeypatch.setattr(passes, "PASS_SECONDS", 0.0)
    monkeypatch.setattr(passes, "LEAST_IN_PASS", 1)
    calls = []
    single = render(scene, progress=lambda done, total: calls.append((done, total)))
    assert calls == [(k, 20) for k in range(1, 21)]
    assert np.array_equal(whole, single.channels()["R"])


def test_threads_do_not_change_a_bit(tmp_path):
    """Every pixel is computed by one lane."""
    scene = mixed(tmp_path, samples=8)
    before = dr.thread_count()
    try:
        pictures = []
        for threads in (1, 2, 5):
            dr.set_thread_count(threads)
            pictures.append(render(scene).channels()["G"])
    finally:
        dr.set_thread_count(before)
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])


def test_seed_chooses_the_samples(tmp_path):
    """The same seed repeats the picture, another one gives another; one sample a pixel needs no seed."""
    scene = mixed(tmp_path, samples=2)
    one, again, other = (render(scene, seed=seed).channels()["B"] for seed in (1, 1, 2))
    assert np.array_equal(one, again) and not np.array_equal(one, other)
    scene = override(scene, samples=1)
    assert np.array_equal(render(scene, seed=1).channels()["B"], render(scene, seed=2).channels()["B"])


def test_many_samples_converge_to_the_area_mean(tmp_path):
    """A half-plane's edge covers pixels by their area; binary mode shows coverage."""
    edge = {"type": "triangle", "v0": [-9, -9, 0], "v1": [9, 9, 0], "v2": [9, -9, 0]}
    scene = loaded(tmp_path, [edge], rendermode="binary", samples=256, camera={"width": 12, "height": 12})
    coverage = render(scene).channels()["R"]
    # screen y runs down, world x to the right: the diagonal's lower right is covered
    diagonal = np.fliplr(np.eye(12, dtype=bool))
    assert np.abs(coverage[diagonal] - 0.5).max() < 0.02
    assert set(np.unique(coverage[~diagonal])) == {0.0, 1.0}
    assert coverage[11, 11] == 1 and coverage[0, 0] == 0


def test_loops_over_many_shapes_agree_with_unrolled_code(tmp_path, monkeypatch):
    """Records are read by literal index, by selects or by gathers; all three mean the same."""
    scene = mixed(tmp_path)
    unrolled = render(scene).channels()
    monkeypatch.setattr(rows, "UNROLL_LIMIT", 0)
    monkeypatch.setattr(rows, "SELECT_LIMIT", 0)
    looped = render(scene).channels()
    for name in "RGB":
        # other code, other roundings: a silhouette or shadow edge may fall to the other side
        differ = np.abs(unrolled[name] - looped[name]) > 1e-4
        assert differ.mean() < 0.02


def test_hundreds_of_shapes_render(tmp_path):
    """More shapes than are unrolled: a wall of balls, each where it belongs."""
    balls = [{"type": "sphere", "center": [0.2 * (k % 20) - 1.9, 0.2 * (k // 20) - 1.9, 0], "radius": 0.09}
             for k in range(400)]  # fmt: skip
    scene = loaded(tmp_path, balls, rendermode="shapes", camera={"width": 60, "height": 60, "fov": 53.13})
    number = render(scene).channels()["Shape"]
    rows_seen, columns_seen = np.divmod(number[1::3, 1::3][::-1].astype(int), 20)
    assert np.array_equal(columns_seen[0], np.arange(20)) and np.array_equal(rows_seen[:, 0], np.arange(20))


def kernels(scene, monkeypatch, least=0):
    """Return the hashes of the kernels that a render launches, of those with at least so many operations."""
    seen = []
    read = dr.kernel_history
    monkeypatch.setattr(engine.dr, "kernel_history", lambda: seen.extend(read()) or seen)
    render(scene)
    monkeypatch.undo()
    return {kernel["hash"] for kernel in seen if "hash" in kernel and kernel["operation_count"] >= least}


def edited(tmp_path, monkeypatch, change):
    """Return the kernels of a scene with a ball, changed in one place."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": dict(MATT)}
    camera, lights = {}, [point_light([1, 2, -3])]
    change(ball, camera, lights)
    return kernels(loaded(tmp_path, [ball], lights, camera=camera), monkeypatch)


VALUES = {
    "colour": lambda ball, camera, lights: ball["material"].update(diffusecolor=[0.1, 0.9, 0.2]),
    "radius": lambda ball, camera, lights: ball.update(radius=0.5),
    "exponent": lambda ball, camera, lights: ball["material"].update(specularexponent=0),
    "camera": lambda ball, camera, lights: camera.update(position=[1, 2, -5], fov=20),
    "size": lambda ball, camera, lights: camera.update(width=33, height=7),
    "light": lambda ball, camera, lights: lights[0].update(position=[0, 5, 0], intensity=[3, 2, 1]),
    "place": lambda ball, camera, lights: ball.update(center=[0.5, 1, 0]),
}
STRUCTURE = {
    "a mirror": lambda ball, camera, lights: ball["material"].update(isreflective=True),
    "a light more": lambda ball, camera, lights: lights.append(point_light([0, 1, 0])),
    "another shape": lambda ball, camera, lights: (ball.clear(), ball.update(SHAPES["box"][0])),
}


@pytest.mark.parametrize("name", ["scene", "cornell", "soft_shadows"])
def test_all_passes_of_a_scene_run_one_kernel(root, monkeypatch, name):
    """Also the first, whose operations must come in the order of the others'."""
    monkeypatch.setattr("renderer.engine.passes.PART_PIXELS", 300)
    scene = override(load(root / f"scenes/{name}.json"), width=32, height=20, samples=40)
    assert len(kernels(scene, monkeypatch, least=100)) == 1


@pytest.mark.parametrize("change", VALUES.values(), ids=VALUES)
def test_an_edited_value_finds_the_compiled_kernel(tmp_path, monkeypatch, change):
    """Values are data."""
    assert edited(tmp_path, monkeypatch, change) == edited(tmp_path, monkeypatch, lambda *nothing: None)


@pytest.mark.parametrize("change", STRUCTURE.values(), ids=STRUCTURE)
def test_a_kernel_contains_only_what_its_scene_uses(tmp_path, monkeypatch, change):
    """Structure is code: what a scene lacks is not compiled in, so adding it gives another kernel."""
    assert edited(tmp_path, monkeypatch, change) != edited(tmp_path, monkeypatch, lambda *nothing: None)


def test_only_the_axes_of_directions_are_structure(tmp_path, monkeypatch):
    """A floor has fewer terms than a slope; slopes share a kernel with each other."""
    def floor(normal):
        return kernels(loaded(tmp_path, [{"type": "plane", "point": [0, -1, 0], "normal": normal}]), monkeypatch)

    assert floor([0.1, 1, 0.2]) == floor([0.3, 2, 0.1]) != floor([0, 1, 0]) == floor([0, 7, 0])


@pytest.mark.parametrize("width", [1, 3, 1200, 16_384, 65_536])
def test_pixel_numbers_are_split_exactly(width):
    """Also for the last pixels of the largest picture."""
    pixels = np.unique(np.concatenate([np.arange(4000), 2**28 - 1 - np.arange(4000), np.arange(1, 4000) * width - 1,
                                       np.arange(1, 4000) * width])).astype(np.uint32)  # fmt: skip
    pixels = pixels[pixels < min(2**28, width * 2**24)]
    corner = pixel_corner(UInt32(pixels), dr.opaque(UInt32, width))
    assert np.array_equal(corner.x.numpy(), (pixels % width).astype(np.float32))
    assert np.array_equal(corner.y.numpy(), (pixels // width).astype(np.float32))


def test_timings_and_rate_are_told(tmp_path):
    """All times are there and none is negative."""
    picture = render(mixed(tmp_path, samples=2))
    assert min(picture.timings.build, picture.timings.compile, picture.timings.render) >= 0
    assert picture.samples_per_second == pytest.approx(16 * 12 * 2 / picture.timings.render)


@pytest.mark.parametrize("name", ["gaussian", "box"])
@pytest.mark.parametrize("mode", ["phong", "pathtracer"])
def test_repeated_samples_are_those_of_the_picture(tmp_path, mode, name):
    """One by one, through lens and filter, they have the pixel's mean; path tracing in a scene where rays miss too."""
    lens = {"type": "thinlens", "apertureRadius": 0.1}
    scene = mixed(tmp_path, rendermode=mode, samples=8, filter=name, nbounces=3, camera=lens)
    picture = np.stack([render(scene, seed=5).channels()[c] for c in "RGB"])
    for column, row in ((8, 6), (3, 9), (15, 0)):
        samples = [replay(scene, (column, row), sample, seed=5) for sample in range(8)]
        assert np.mean(samples, axis=0) == pytest.approx(picture[:, row, column], rel=1e-4)
