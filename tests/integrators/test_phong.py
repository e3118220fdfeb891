"""Phong mode against closed forms, a pixel at a time."""

import math

import numpy as np
import pytest

from renderer.engine.render import render
from tests.support.scenes import MATT, loaded, point_light

BACKGROUND, AMBIENT = 0.25, 0.4
WALL = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, -1]}  # faces the camera at z = -4
ONE_PIXEL = {"width": 1, "height": 1}  # its ray is the camera's axis


def middle(tmp_path, *args, **keys):
    """Return the linear colour of a picture of one pixel."""
    channels = render(loaded(tmp_path, *args, camera=ONE_PIXEL | keys.pop("camera", {}), **keys)).channels()
    return np.array([channels[name][0, 0] for name in "RGB"], float)


def shaded(material):
    """Return the wall with a material."""
    return [WALL | {"material": MATT | material}]


def test_background_where_nothing_is_hit(tmp_path):
    """A ray without a hit brings backgroundcolor."""
    assert np.allclose(middle(tmp_path, backgroundcolor=[0.1, 0.2, 0.3]), [0.1, 0.2, 0.3])


def test_ambient_is_light_times_diffuse_colour(tmp_path):
    """Without lights only ambientlight * diffusecolor is left; kd does not count."""
    colour = middle(tmp_path, shaded({}), ambientlight=[0.1, 0.2, 0.4])
    assert np.allclose(colour, [0.08, 0.1, 0.1], rtol=1e-6)


@pytest.mark.parametrize("angle_deg", [0, 30, 60, 85])
def test_diffuse_falls_with_the_cosine_and_not_with_distance(tmp_path, angle_deg):
    """I kd Cd cos, whatever the distance."""
    a = math.radians(angle_deg)
    for distance in (0.5, 3.0):
        light = point_light([distance * math.sin(a), 0, -distance * math.cos(a)], [0.5, 1.0, 2.0])
        colour = middle(tmp_path, shaded({}), [light])
        expected = np.array([0.8, 0.5, 0.25]) * (AMBIENT + 0.9 * math.cos(a) * np.array([0.5, 1.0, 2.0]))
        assert np.allclose(colour, expected, rtol=2e-6)


@pytest.mark.parametrize("exponent", [0, 1, 20, 1000])
def test_highlight_is_a_power_of_the_half_vector(tmp_path, exponent):
    """I ks Cs (N.H)^e with H halfway between light and viewer; exponent 0 gives a constant."""
    a = math.radians(20)
    material = {"kd": 0.0, "ks": 0.3, "specularcolor": [1, 0.5, 0.25], "specularexponent": exponent}
    colour = middle(tmp_path, shaded(material), [point_light([math.sin(a), 0, -math.cos(a)])])
    highlight = 0.3 * math.cos(a / 2) ** exponent * np.array([1, 0.5, 0.25])
    assert np.allclose(colour, AMBIENT * np.array([0.8, 0.5, 0.25]) + highlight, rtol=1e-5)


def test_light_behind_the_surface_gives_no_highlight(tmp_path):
    """Where N.L <= 0 the whole term is zero, also for exponent 0, whose highlight is everywhere else."""
    lights = [point_light([0.5, 0, 1]), point_light([1, 0, 0])]
    colour = middle(tmp_path, shaded({"ks": 1.0, "specularexponent": 0}), lights)
    assert np.allclose(colour, AMBIENT * np.array([0.8, 0.5, 0.25]), rtol=1e-6)


def test_sheets_are_shaded_on_the_side_that_is_seen(tmp_path):
    """The normal is turned to the viewer, so the back of a plane is lit like its front."""
    lights = [point_light([1, 0, -1])]
    front, back = (WALL | {"normal": [0, 0, z], "material": MATT} for z in (-1, 1))
    assert np.allclose(middle(tmp_path, [front], lights), middle(tmp_path, [back], lights), rtol=1e-6)


def test_a_shape_before_the_light_casts_a_shadow_and_one_behind_it_does_not(tmp_path):
    """Shadow rays end at the light."""
    light = point_light([2, 0, -2])
    blocker = {"type": "sphere", "radius": 0.2, "material": MATT}
    lit = middle(tmp_path, shaded({}), [light])
    before = middle(tmp_path, [*shaded({}), blocker | {"center": [1, 0, -1]}], [light])
    behind = middle(tmp_path, [*shaded({}), blocker | {"center": [2.5, 0, -2.5]}], [light])
    assert np.allclose(before, AMBIENT * np.array([0.8, 0.5, 0.25]), rtol=1e-6)
    assert np.allclose(behind, lit, rtol=1e-7)


def test_each_light_has_its_own_shadow(tmp_path):
    """Of two lights only the one in view adds its term."""
    lights = [point_light([2, 0, -2], [1, 0, 0]), point_light([-2, 0, -2], [0, 0, 1])]
    blocker = {"type": "sphere", "center": [1, 0, -1], "radius": 0.2, "material": MATT}
    colour = middle(tmp_path, [*shaded({}), blocker], lights)
    expected = AMBIENT * np.array([0.8, 0.5, 0.25]) + [0, 0, 0.9 * 0.25 * math.sqrt(0.5)]
    assert np.allclose(colour, expected, rtol=1e-5)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_mirror_mixes_by_reflectivity(tmp_path, share):
    """(1 - rho) local + rho background, for a mirror with nothing else in view."""
    material = {"isreflective": True, "reflectivity": share}
    expected = (1 - share) * AMBIENT * np.array([0.8, 0.5, 0.25]) + share * BACKGROUND
    assert np.allclose(middle(tmp_path, shaded(material)), expected, rtol=1e-6)


def test_reflectivity_counts_for_nothing_on_matt_shapes(tmp_path):
    """The coursework's files carry reflectivity 1 everywhere."""
    assert np.allclose(middle(tmp_path, shaded({"reflectivity": 1.0})), AMBIENT * np.array([0.8, 0.5, 0.25]), rtol=1e-6)


@pytest.mark.parametrize("bounces", [0, 1, 2, 5, 12])
def test_two_mirrors_reflect_as_often_as_nbounces_allows(tmp_path, bounces):
    """Between two facing half mirrors the local colour comes back with 1, rho, rho^2 ..., then the background."""
    mirror = MATT | {"isreflective": True, "reflectivity": 0.5}
    back = {"type": "plane", "point": [0, 0, -5], "normal": [0, 0, 1], "material": mirror}
    colour = middle(tmp_path, [WALL | {"material": mirror}, back], nbounces=bounces)
    local, rho = AMBIENT * np.array([0.8, 0.5, 0.25]), 0.5
    expected = sum(local * (1 - rho) * rho**k for k in range(bounces + 1)) + BACKGROUND * rho ** (bounces + 1)
    assert np.allclose(colour, expected, rtol=1e-6)


GLASS = {"isrefractive": True, "reflectivity": 1.0, "refractiveindex": 1.5}
PANE = {"type": "box", "min": [-9, -9, -1], "max": [9, 9, -0.5], "material": MATT | GLASS}
BLACK_WALL = WALL | {"material": MATT | {"diffusecolor": [0, 0, 0]}}


def pane_series(reflectance, bounces):
    """Return what a pane reflects and transmits at normal incidence, following up to `bounces` interfaces."""
    inside = 1 - reflectance
    reflected, transmitted = reflectance, 0.0
    for k in range(2, bounces + 1):  # each further interface lets 1 - F out, on the far side first
        out = inside * (1 - reflectance)
        transmitted, reflected = (transmitted + out, reflected) if k % 2 == 0 else (transmitted, reflected + out)
        inside *= reflectance
    return reflected, transmitted, inside


@pytest.mark.parametrize("bounces", [1, 2, 3, 4, 8])
def test_glass_pane_follows_both_branches(tmp_path, bounces):
    """At normal incidence F = ((n - 1) / (n + 1))^2; every order up to nbounces is there, cut ones see background."""
    colour = middle(tmp_path, [PANE, BLACK_WALL], nbounces=bounces)
    reflectance = 0.2**2
    reflected, transmitted, cut = pane_series(reflectance, bounces)
    # the wall behind is black: transmitted light is lost once it can reach it, which needs no bounce
    assert np.allclose(colour, BACKGROUND * (reflected + cut), rtol=1e-5)


def test_glass_loses_no_light(tmp_path):
    """Between background and background a glass ball shows the background's colour: the shares add up to one."""
    ball = {"type": "sphere", "center": [0.3, 0.2, 0], "radius": 1.0, "material": MATT | GLASS}
    picture = render(loaded(tmp_path, [ball], camera={"width": 40, "height": 30})).channels()
    assert np.allclose(picture["R"], BACKGROUND, rtol=2e-6)


def test_index_one_is_invisible(tmp_path):
    """With refractiveindex 1 nothing is reflected and nothing is bent."""
    ball = {"type": "sphere", "center": [0, 0, 1], "radius": 0.8, "material": MATT}
    clear = {"type": "box", "min": [-1, -1, -2], "max": [1.5, 1, -1], "material": MATT | GLASS | {"refractiveindex": 1}}
    camera = {"width": 40, "height": 30}
    with_it, without = (render(loaded(tmp_path, shapes, camera=camera)).channels()["R"]
                        for shapes in ([ball, clear], [ball]))  # fmt: skip
    assert np.ptp(without) > 0.05 and np.abs(with_it - without).max() < 1e-5


def test_number_of_bounces_does_not_reach_the_kernel(tmp_path):
    """Stacks of different sizes would share one cached kernel and overwrite each other's rays."""
    first = [middle(tmp_path, [PANE, BLACK_WALL], nbounces=bounces) for bounces in (1, 8, 3)]
    again = [middle(tmp_path, [PANE, BLACK_WALL], nbounces=bounces) for bounces in (3, 8, 1)]
    assert np.array_equal(first, again[::-1][:1] + again[1:2] + again[:1])


def test_total_reflection_inside_glass(tmp_path):
    """A camera in glass beyond the critical angle sees only the reflection."""
    inside = {"type": "box", "min": [-50, -50, -50], "max": [50, 50, 0], "material": MATT | GLASS}
    # 60 degrees from the normal of the face at z = 0, where asin(1 / 1.5) is 41.8; the reflected ray meets
    # the black wall inside the block before it could meet a face
    wall = {"type": "plane", "point": [20, 0, 0], "normal": [1, 0, 0],
            "material": MATT | {"diffusecolor": [0, 0, 0]}}  # fmt: skip
    camera = {"position": [0, 0, -1], "lookAt": [math.tan(math.radians(60)), 0, 0]}
    assert np.allclose(middle(tmp_path, [inside, wall], camera=camera, nbounces=1), 0, atol=1e-7)


def test_nested_media_bend_by_the_ratio_of_their_indices(tmp_path):
    """Where glass of index 1.5 lies in water of index 1.5 its surface reflects nothing; in air it does."""
    water = {"type": "box", "min": [-9, -9, -2], "max": [9, 9, 2], "material": MATT | GLASS}
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": MATT | GLASS}
    same = middle(tmp_path, [water, ball, BLACK_WALL | {"point": [0, 0, 3]}], nbounces=2)
    alone = middle(tmp_path, [water, BLACK_WALL | {"point": [0, 0, 3]}], nbounces=2)
    # with two bounces: 4 % at the front; through the rest both end in the background of an exhausted ray,
    # except what leaves the water behind, which needs two interfaces without the ball and four with it
    assert np.allclose(alone, BACKGROUND * (0.04 + 0.96 * 0.04), rtol=1e-5)
    assert np.allclose(same, BACKGROUND * (0.04 + 0.96), rtol=1e-5)


def test_partial_glass_mixes_local_colour(tmp_path):
    """(1 - rho) local + rho glass."""
    half = MATT | GLASS | {"reflectivity": 0.5}
    colour = middle(tmp_path, [WALL | {"material": half}])
    assert np.allclose(colour, 0.5 * AMBIENT * np.array([0.8, 0.5, 0.25]) + 0.5 * BACKGROUND, rtol=1e-6)


BRIGHT = np.array([0.8, 0.5, 0.25])  # of the wall
SOFT = 4096  # samples a pixel


def test_spot_lights_its_cone_and_fades_towards_its_rim(tmp_path):
    """Full within beamwidth, then linear in the angle to nothing at cutoff; it does not fall off with distance."""
    def lit(angle_deg):
        a = math.radians(angle_deg)
        spot = {"type": "spot", "position": [math.sin(a), 0, -math.cos(a)], "direction": [0, 0, 1],
                "intensity": [1, 1, 1], "cutoff": 40, "beamwidth": 20}  # fmt: skip
        return (middle(tmp_path, shaded({}), [spot]) / BRIGHT - AMBIENT) / (0.9 * math.cos(a))

    for angle_deg, expected in ((0, 1), (19, 1), (30, 0.5), (35, 0.25), (41, 0), (80, 0)):
        assert np.allclose(lit(angle_deg), expected, atol=1e-5)


def test_directional_light_comes_from_one_side_and_is_shadowed(tmp_path):
    """Its direction is that in which light travels; what lies that way at any distance casts a shadow."""
    light = {"type": "directional", "direction": [-1, 0, 1], "intensity": [1, 0.5, 2]}
    colour = middle(tmp_path, shaded({}), [light])
    assert np.allclose(colour, BRIGHT * (AMBIENT + 0.9 * math.sqrt(0.5) * np.array([1, 0.5, 2])), rtol=2e-6)
    ball = {"type": "sphere", "center": [500, 0, -500], "radius": 1, "material": MATT}
    assert np.allclose(middle(tmp_path, [*shaded({}), ball], [light]), BRIGHT * AMBIENT, rtol=2e-6)


LAMPS = {
    "arealight": {"type": "arealight", "position": [0, 0, -2], "u": [2, 0, 0], "v": [0, 1, 0], "intensity": [1, 1, 1]},
    "disklight": {"type": "disklight", "position": [0, 0, -2], "normal": [0, 0, 1], "radius": 1,
                  "intensity": [1, 1, 1]},
}


@pytest.mark.parametrize("kind", LAMPS)
def test_lamp_is_a_point_in_its_middle_with_one_sample(tmp_path, kind):
    """The lamp itself is not seen, and a light on its other side is not hidden by it."""
    colour = middle(tmp_path, shaded({}), [LAMPS[kind]])
    assert np.allclose(colour, middle(tmp_path, shaded({}), [point_light([0, 0, -2])]), rtol=2e-6)


@pytest.mark.parametrize("kind", LAMPS)
def test_shadow_is_soft_as_the_covered_share_of_the_lamp(tmp_path, kind):
    """A blocker that hides the lamp beyond x = 1/2 leaves what the rest of it brings."""
    wall = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, -1], "material": MATT | {"kd": 1.0}}
    # halfway to the lamp, so that it hides x > 1/2 of it from the middle of the wall
    blocker = {"type": "box", "min": [0.25, -9, -1.0001], "max": [9, 9, -1], "material": MATT}
    camera = {"position": [-1, 0, -4], "lookAt": [0, 0, 0], "fov": 1e-4}
    lit = middle(tmp_path, [wall, blocker], [LAMPS[kind]], camera=camera, samples=SOFT, ambientlight=[0, 0, 0])
    seen = middle(tmp_path, [wall], [LAMPS[kind]], camera=camera, samples=SOFT, ambientlight=[0, 0, 0])
    assert np.allclose(lit / BRIGHT, _mean_cosine(kind, -1.0, 0.5), atol=4e-3)
    assert np.allclose((seen - lit) / BRIGHT, _mean_cosine(kind, 0.5, 1.0), atol=4e-3)


def _mean_cosine(kind, low, high):
    """Return the integral of the cosine at the wall's middle over the part low < x < high of a lamp, over its area."""
    x, y = np.meshgrid(*(np.linspace(-1, 1, 2001)[:-1] + 5e-4,) * 2)
    whole = x**2 + y**2 < 1 if kind == "disklight" else abs(y) < 0.5
    part = whole & (x > low) & (x < high)
    return (2 / np.sqrt(x**2 + y**2 + 4))[part].sum() / whole.sum()


def test_several_lamps_have_places_of_their_own(tmp_path):
    """Each lamp draws its own numbers: two that are each hidden by half do not hide together."""
    lamps = [LAMPS["arealight"] | {"intensity": colour} for colour in ([1, 0, 0], [0, 1, 0])]
    wall = [WALL | {"material": MATT | {"diffusecolor": [1, 1, 1]}}]
    blocker = {"type": "box", "min": [0, -9, -1.0001], "max": [9, 9, -1], "material": MATT}
    camera = {"width": 64, "height": 1, "position": [-1, 0, -4], "fov": 1e-4}
    scene = loaded(tmp_path, [*wall, blocker], lamps, camera=camera, samples=2, sampler="independent",
                   ambientlight=[0, 0, 0])  # fmt: skip
    picture = render(scene).channels()
    red, green = (picture[name][0] > 0.6 for name in "RG")  # both samples lit
    assert 0 < (red & ~green).sum() and 0 < (green & ~red).sum()


MIRROR_WALL = {"isreflective": True, "reflectivity": 1.0}


def test_rough_mirror_loses_no_light(tmp_path):
    """Whatever the roughness, a mirror of reflectivity 1 shows the background at full weight, and nothing behind it."""
    behind = BLACK_WALL | {"point": [0, 0, 0.1]}
    for roughness in (0.0, 0.05, 0.5, 1.0):
        colour = middle(tmp_path, [*shaded(MIRROR_WALL | {"roughness": roughness}), behind], samples=64)
        assert np.allclose(colour, BACKGROUND, rtol=1e-5)


def test_rough_mirror_shows_what_normals_of_its_distribution_reflect(tmp_path):
    """At normal incidence GGX normals are seen with the density D cos, of which tan < alpha holds half."""
    alpha = 0.2
    # seen head-on, a normal at the angle a reflects to 2 a: a disk of half the light covers tan a < alpha
    reach = 4 * math.tan(2 * math.atan(alpha))
    disk = {"type": "disk", "center": [0, 0, -4.001], "normal": [0, 0, 1], "radius": reach,
            "material": MATT | {"diffusecolor": [0, 0, 0]}}  # fmt: skip
    wall = WALL | {"material": MATT | MIRROR_WALL | {"roughness": alpha}}
    colour = middle(tmp_path, [wall, disk], camera={"fov": 1e-4}, samples=SOFT, nbounces=1)
    assert np.allclose(colour, 0.5 * BACKGROUND, atol=0.012)


def test_rough_mirror_is_sharp_with_one_sample(tmp_path):
    """One sample a pixel has no random numbers to blur with."""
    sharp, rough = (middle(tmp_path, shaded(MIRROR_WALL | {"roughness": r}) + [ball()], samples=1) for r in (0.0, 0.5))
    assert np.array_equal(sharp, rough)


def ball():
    """Return a ball behind the camera."""
    return {"type": "sphere", "center": [0, 0, -6], "radius": 0.5, "material": MATT}


def environment_file(folder, pixels):
    """Write (H, W, 3) linear colours as an EXR, and return the light that names it."""
    OpenEXR = pytest.importorskip("OpenEXR")
    channels = {name: np.ascontiguousarray(pixels[..., k], np.float32) for k, name in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(folder / "sky.exr"))
    return {"type": "environment", "filename": "sky.exr"}


def test_environment_is_seen_behind_everything(tmp_path):
    """Looking along -z the middle of the first and last column is seen; to the right of the picture u grows."""
    pixels = np.zeros((5, 8, 3))
    pixels[..., 0] = np.arange(8)
    pixels[..., 1] = np.arange(5)[:, None]
    light = environment_file(tmp_path, pixels)
    # texel i is at u = (i + 1/2) / 8: along +z (u = 1/2) halfway between texels 3 and 4
    assert np.allclose(middle(tmp_path, [], [light]), [3.5, 2, 0], atol=1e-5)
    picture = render(loaded(tmp_path, [], [light], camera={"width": 3, "height": 3})).channels()
    assert picture["R"][1, 2] > 3.6 and picture["R"][1, 0] < 3.4 and picture["G"][2, 1] > 2.1 > picture["G"][1, 1]
    up = middle(tmp_path, [], [light], camera={"lookAt": [0, 1, -4], "upVector": [0, 0, 1]})
    assert np.allclose(up[1], 0, atol=1e-3)
    turned = middle(tmp_path, [], [light | {"rotation": 45}])
    assert np.allclose(turned, [2.5, 2, 0], atol=1e-5)


def test_mirror_shows_the_environment(tmp_path):
    """Also when no bounce is left, and for the direction in which it reflects."""
    pixels = np.zeros((4, 8, 3))
    pixels[:, 7] = pixels[:, 0] = 2.0  # around -z
    light = environment_file(tmp_path, pixels)
    for bounces in (0, 1):
        colour = middle(tmp_path, shaded(MIRROR_WALL), [light], nbounces=bounces)
        assert np.allclose(colour, 2.0, rtol=1e-5)


def test_binary_mode_is_red_or_black(tmp_path):
    """A hit is (255, 0, 0) whatever the exposure, a miss black."""
    ball = {"type": "sphere", "center": [0, 0, 0], "radius": 0.5}
    picture = render(loaded(tmp_path, [ball], rendermode="binary", camera={"exposure": 0.01}))
    pixels = np.frombuffer(picture.rgb8(), np.uint8).reshape(12, 16, 3)
    assert tuple(pixels[6, 8]) == (255, 0, 0) and tuple(pixels[0, 0]) == (0, 0, 0)
    assert set(map(tuple, pixels.reshape(-1, 3))) == {(255, 0, 0), (0, 0, 0)}
