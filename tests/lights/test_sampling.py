"""What is sampled of every light that has a size: densities, radiance, shadow rays; and what happens at odd points."""

import math

import drjit as dr
import numpy as np
import pytest

from renderer.core.backend import Bool, Float, UInt32, Vector3f
from renderer.core.records import NO_SHAPE, Ray
from tests.lights.room import SIGNIFICANCE, Room, environment_file, p_value, points, uniform_directions

LIGHT = [1.0, 2.0, 3.0]
RECTANGLE = {"type": "rectangle", "center": [0.3, 1, 0.2], "u": [1.5, 0.2, 0], "v": [0.4, 0.1, 2], "emission": LIGHT}
DISK = {"type": "disk", "center": [-1, 0.3, 0.2], "normal": [1, 0.3, -0.2], "radius": 0.9, "emission": LIGHT}
TRIANGLE = {"type": "triangle", "v0": [2, -1, 1], "v1": [2.5, -1, -1.5], "v2": [1.5, 2, 0], "emission": LIGHT}
BALL = {"type": "sphere", "center": [0.2, -1.2, 0.5], "radius": 0.8, "emission": LIGHT}
FAR_BALL = BALL | {"center": [0, -1.7, 0], "radius": 0.3}
TOUCHED = BALL | {"center": [0, -0.803, 0]}  # the point is nearly on it
MESH = {"type": "mesh", "filename": "the torus", "emission": LIGHT,
        "transform": [{"scale": 0.9}, {"translate": [0, 0, 2.0]}]}  # fmt: skip
SHAPES = {
    "rectangle": [RECTANGLE], "disk": [DISK], "triangle": [TRIANGLE], "sphere": [BALL], "far sphere": [FAR_BALL],
    "near sphere": [TOUCHED], "sheets": [RECTANGLE, DISK, TRIANGLE], "all kinds": [RECTANGLE, DISK, TRIANGLE, FAR_BALL],
}  # fmt: skip
ORIGIN = [0.0, 0.0, 0.0]


def many():
    """Return more emitters than are looked for one after the other, none behind another seen from the origin."""
    balls = [BALL | {"center": [3 * math.cos(a), 1.5 * h, 3 * math.sin(a)], "radius": 0.35}
             for h in (-1, 0, 1) for a in np.linspace(0, 2 * math.pi, 6, endpoint=False)]  # fmt: skip
    return [*balls, {"type": "box", "min": [-0.2, 4, -0.2], "max": [0.2, 4.2, 0.2], "emission": [1, 1, 1]}]


def skies():
    """Return small environment images that are hard to sample."""
    rng = np.random.default_rng(2)
    noise = rng.random((16, 32, 3)) ** 4
    dark = noise.copy()
    dark[::3] = 0
    one = np.zeros((16, 32, 3))
    one[5, 31] = 50.0  # beside the seam
    pole = np.zeros((16, 32, 3))
    pole[0, 3] = 9.0
    return {"noise": noise, "with zeros": dark, "one bright texel": one, "at the pole": pole, "one row": noise[:1]}


def room_of(folder, shapes, root):
    """Return the Room of shapes."""
    torus = str(root / "scenes/meshes/torus.obj")
    return Room(folder, [shape | ({"filename": torus} if shape["type"] == "mesh" else {}) for shape in shapes])


@pytest.mark.parametrize("shapes", SHAPES.values(), ids=SHAPES)
def test_directions_have_the_density_that_is_told(tmp_path, root, shapes):
    """The mean of 1 / density over a cell is the solid angle in which light is seen there."""
    room = room_of(tmp_path, shapes, root)
    found, even = room.sample(ORIGIN), uniform_directions(2**21)
    p = p_value(found.wo, found.pdf_sa.numpy().astype(float), even, room.seen(ORIGIN, even)[1] > 0)
    assert p > SIGNIFICANCE


def test_many_lights_have_the_density_that_is_told(tmp_path, root):
    """Also where lights are chosen by tables."""
    test_directions_have_the_density_that_is_told(tmp_path, root, many())


@pytest.mark.parametrize("name", skies())
def test_environment_has_the_density_that_is_told(tmp_path, name):
    """Also for images of few bright texels, zeros, and light at a pole."""
    room = Room(tmp_path, [], [environment_file(tmp_path, skies()[name], rotation=50)])
    found, even = room.sample(ORIGIN), uniform_directions(2**21)
    radiance, pdf_sa = room.seen(ORIGIN, even)
    assert (radiance.max(axis=0)[pdf_sa == 0] == 0).all()
    # 1 / density is unbounded where the image fades into black: weighted by what arrives it is not
    luminance = np.array([0.2126, 0.7152, 0.0722])
    weights = luminance @ found.radiance.numpy(), luminance @ radiance
    assert p_value(found.wo, found.pdf_sa.numpy() / weights[0].clip(1e-30), even, weights[1]) > SIGNIFICANCE


@pytest.mark.parametrize("wrong", [1.03, 1 / 1.03])
def test_test_refuses_densities_that_are_off_by_three_percent(tmp_path, root, wrong):
    """The test itself is tested."""
    room = room_of(tmp_path, [RECTANGLE], root)
    found, even = room.sample(ORIGIN), uniform_directions(2**21)
    shines = room.seen(ORIGIN, even)[1] > 0
    assert p_value(found.wo, wrong * found.pdf_sa.numpy(), even, shines) < SIGNIFICANCE


@pytest.mark.parametrize("shapes", [*SHAPES.values(), many(), [MESH], [MESH, RECTANGLE], [MESH, *many()]],
                         ids=[*SHAPES, "many", "mesh", "mesh and rectangle", "mesh and many"])
def test_what_is_hit_tells_density_and_radiance_of_what_was_sampled(tmp_path, root, shapes):
    """Following a sampled direction to its light finds the same radiance and density."""
    room = room_of(tmp_path, shapes, root)
    found = room.sample(ORIGIN, 2**17)
    radiance, pdf_sa = room.seen(ORIGIN, found.wo)
    first = ~hidden(room, ORIGIN, found) & (found.radiance.numpy().max(axis=0) > 0)
    off = abs(pdf_sa / found.pdf_sa.numpy() - 1)[first]
    # rounding decides at rims, and magnifies at grazing angles
    assert first.mean() > 0.1 and np.median(off) < 1e-5 and (off > 1e-2).mean() < 1e-3
    assert (abs(radiance - found.radiance.numpy()).max(axis=0)[first] > 1e-5).mean() < 1e-3


@pytest.mark.parametrize("name", skies())
def test_environment_tells_the_density_of_what_was_sampled(tmp_path, name):
    """Looking in a sampled direction finds the same radiance and density."""
    room = Room(tmp_path, [], [environment_file(tmp_path, skies()[name], rotation=-20)])
    found = room.sample(ORIGIN, 2**17)
    radiance, pdf_sa = room.seen(ORIGIN, found.wo)
    bright = found.radiance.numpy().max(axis=0) > 0.05
    assert bright.any() and np.quantile(abs(pdf_sa / found.pdf_sa.numpy() - 1)[bright], 0.999) < 2e-3
    assert np.quantile(abs(radiance - found.radiance.numpy()), 0.999) < 2e-3 * radiance.max()


def looked_up(pixels, d, rotation_deg):
    """Return the colours (3, N) of an environment in directions (3, N), interpolated in numpy."""
    height, width = pixels.shape[:2]
    x = (np.arctan2(-d[0], -d[2]) / (2 * math.pi) - rotation_deg / 360) * width - 0.5
    y = np.arccos(np.clip(d[1], -1, 1)) / math.pi * (height - 1)
    i, j = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), height - 2)
    a, b = x - i, y - j
    corners = [pixels[j + dj, (i + di) % width].T for dj in (0, 1) for di in (0, 1)]
    return (corners[0] * (1 - a) + corners[1] * a) * (1 - b) + (corners[2] * (1 - a) + corners[3] * a) * b


def test_environment_is_interpolated_across_its_seam(tmp_path):
    """Colours are those of a plain bilinear look-up, columns being periodic and rows not."""
    pixels = skies()["noise"]
    room = Room(tmp_path, [], [environment_file(tmp_path, pixels, rotation=33, intensity=[1, 0.5, 2])])
    even = uniform_directions(2**16)
    expected = looked_up(pixels, even.numpy().astype(float), 33) * [[1], [0.5], [2]]
    assert np.quantile(abs(room.seen(ORIGIN, even)[0] - expected), 0.9999) < 1e-4


def test_bright_texels_are_chosen_as_bright_as_they_are(tmp_path):
    """Nearly all of the variance is gone, also beside the seam and at a pole."""
    for name, bound in (("one bright texel", 0.1), ("noise", 0.25), ("at the pole", 0.8)):
        found = Room(tmp_path, [], [environment_file(tmp_path, skies()[name])]).sample(ORIGIN)
        values = np.array([0.2126, 0.7152, 0.0722]) @ found.radiance.numpy() / found.pdf_sa.numpy()
        assert values.std() < bound * values.mean()


def hidden(room, p, found):
    """Return (N,) whether shadow rays are blocked."""
    count = dr.width(found.wo)
    left = UInt32(NO_SHAPE) + dr.zeros(UInt32, count)
    blocked = room.geometry.occluded(Ray(points(p, count), found.wo, left, Bool(False)), found.distance, Bool(True))
    return (blocked | dr.zeros(Bool, count)).numpy()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("shape", [RECTANGLE, DISK, TRIANGLE, BALL, FAR_BALL], ids=lambda shape: shape["type"])
def test_lamp_does_not_hide_itself(tmp_path, root, shape, scale):
    """Shadow rays end before their own lamp, at grazing angles, far from the origin and at any scale."""
    scaled = {key: [scale * x for x in value] if key in ("center", "u", "v", "v0", "v1", "v2") else value
              for key, value in shape.items()}  # fmt: skip
    scaled = scaled | ({"radius": scale * shape["radius"]} if "radius" in shape else {})
    room = room_of(tmp_path, [scaled], root)
    rng = np.random.default_rng(4)
    for reach in (2.0, 0.1, 50.0):
        p = Vector3f(*(Float(scale * reach * rng.normal(size=2**16).astype(np.float32)) for _ in range(3)))
        found = room.sample(p, 2**16)
        lit = found.radiance.numpy().max(axis=0) > 0
        assert lit.mean() > 0.1 and (hidden(room, p, found) & lit).mean() < 1e-4


def test_what_lies_just_before_a_lamp_hides_it(tmp_path, root):
    """Shadow rays do not end much too early."""
    lamp = {"type": "rectangle", "center": [0, 1, 0], "u": [1, 0, 0], "v": [0, 0, 1], "emission": LIGHT}
    cover = {"type": "rectangle", "center": [0, 0.9999, 0], "u": [3, 0, 0], "v": [0, 0, 3]}
    room = room_of(tmp_path, [lamp, cover], root)
    assert hidden(room, ORIGIN, room.sample(ORIGIN, 2**16)).all()


def lamp(**keys):
    """Return a one-sided lamp above the origin that shines down."""
    return {"type": "arealight", "position": [0, 1, 0], "u": [1, 0, 0], "v": [0, 0, 1], "intensity": LIGHT,
            "twosided": False} | keys  # fmt: skip


def test_one_sided_lamps_are_dark_behind(tmp_path):
    """The normal u x v shows where they shine; other lamps shine on both sides."""
    disk = {"type": "disklight", "position": [0, 1, 0], "normal": [0, -1, 0], "radius": 1, "intensity": LIGHT,
            "twosided": False}  # fmt: skip
    for light in (lamp(), disk):
        for y, expected in ((0, 1), (2, 0)):
            assert (Room(tmp_path, [], [light]).sample([0.2, y, 0.1], 2**12).radiance.numpy()[0] == expected).all()
            seen, pdf_sa = Room(tmp_path, [], [light]).seen([0.2, y, 0.1], Vector3f(0, [float(1 - y)], 0))
            assert seen[0] == expected and (pdf_sa > 0) == expected
        room = Room(tmp_path, [], [light | {"twosided": True}])
        assert (room.sample([0.2, 2, 0.1], 2**12).radiance.numpy()[2] == 3).all()


def test_sides_of_several_lamps_are_their_own(tmp_path):
    """A one-sided lamp beside a two-sided one; behind the first only the second is chosen."""
    room = Room(tmp_path, [], [lamp(), lamp(position=[5, 1, 0], intensity=[7, 7, 7], twosided=True)])
    found = room.sample([0, 2, 0], 2**14)
    assert set(np.unique(found.radiance.numpy()[0])) == {7.0}
    below = room.sample([2.5, 0, 0], 2**14).radiance.numpy()[0]
    assert set(np.unique(below)) == {1.0, 7.0}
    for x, y, expected in ((0, 2, 0), (0, 0, 1), (5, 2, 7), (5, 0, 7)):
        radiance, pdf_sa = room.seen([x, y, 0], Vector3f(0, [float(1 - y)], 0))
        assert radiance[0] == expected and (pdf_sa > 0) == (expected > 0)


def test_spheres_are_dark_within(tmp_path, root):
    """Emission of solids goes outwards: nothing from inside or from the surface itself, nor on hitting it there."""
    room = room_of(tmp_path, [BALL], root)
    inside = np.array(BALL["center"])
    for p in (inside, inside + [0.3, 0.2, 0.1], inside + [0, BALL["radius"], 0]):
        assert (room.sample(p, 2**12).radiance.numpy() == 0).all()
    radiance, pdf_sa = room.seen(inside, uniform_directions(2**12))
    assert (radiance == 0).all() and (pdf_sa == 0).all()


ODD_POINTS = [[0, 1, 0], [0.5, 1, 0.5], [0, 1 + 1e-7, 0], [1e8, 1, -1e8], [1e-20, 1, 0], [0, 0, 0], [3, -2, 1]]


@pytest.mark.parametrize("p", ODD_POINTS)
def test_numbers_stay_finite_at_odd_points(tmp_path, p):
    """On a lamp, in its plane, at its corner, at a point light, in a sphere's middle, far away: no NaN, no infinity."""
    point = {"type": "pointlight", "position": [0, 0, 0], "intensity": LIGHT}
    spot = {"type": "spot", "position": [3, -2, 1], "direction": [0, -1, 0], "intensity": LIGHT}
    alone = [([], [lamp()]), ([], [point]), ([], [spot]), ([BALL | {"center": [0, 1, 0]}], [])]
    for shapes, lights in [*alone, ([BALL | {"center": [0, 1, 0]}], [lamp(), point, spot])]:
        found = Room(tmp_path, shapes, lights).sample(p, 2**12)
        for values in (found.radiance, found.wo, found.pdf_sa, found.distance):
            assert np.isfinite(values.numpy()).all()
        assert (found.pdf_sa.numpy() > 0).all() and (found.radiance.numpy() >= 0).all()
