"""`python -m renderer compare`: pairs with known answers, formats in every mixture, and what is refused."""

import json
import math
import os
import re
import sys
from importlib.util import find_spec

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from renderer import cli, difference, options
from renderer.core import srgb
from renderer.extras import install_command
from renderer.io import image

SIZE = 16, 12
flip_there = pytest.mark.skipif(find_spec("flip_evaluator") is None, reason="its makers offer no package here")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def even(value, kind=np.uint8):
    """Return a picture of one colour."""
    return np.broadcast_to(np.asarray(value, kind), (SIZE[1], SIZE[0], 3)).copy()


def noise(seed=1):
    """Return a picture of random 8-bit values."""
    return np.random.default_rng(seed).integers(0, 256, (SIZE[1], SIZE[0], 3), np.uint8)


def eight_bits(path, pixels):
    """Write 8-bit values in the format of the name, PPM by hand as text where it is called .p3.ppm; return the path."""
    if path.endswith(".p3.ppm"):
        height, width, _ = pixels.shape
        with open(path, "w") as file:
            file.write(f"P3\n# by hand\n{width} {height}\n255\n" + "\n".join(map(str, pixels.reshape(-1))) + "\n")
    else:
        Image.fromarray(pixels).save(path)
    return path


def exr(path, pixels, **settings):
    """Write radiance with settings in the header, as the renderer does; return the path."""
    planes = {name: np.ascontiguousarray(pixels[..., k], np.float32) for k, name in enumerate("RGB")}
    image.write_exr(path, planes, {f"renderer.{name}": value for name, value in settings.items()})
    return path


def told(capfd, *arguments, status=0):
    """Return the JSON that a comparison prints."""
    assert cli.main(["compare", *arguments, "--json"]) == status
    return json.loads(capfd.readouterr().out)


def test_two_even_pictures_have_closed_forms(capfd):
    """Encoded 153 against 102 is a fifth of the peak; squared errors are of decoded values."""
    found = told(capfd, eight_bits("a.png", even(153)), eight_bits("b.ppm", even(102)))
    x, r = srgb.decoded(0.6), srgb.decoded(0.4)
    assert found["psnr"] == pytest.approx(-20 * math.log10(0.2), abs=1e-9)
    assert found["mse"] == pytest.approx((x - r) ** 2, rel=1e-9)
    assert found["relative_mse"] == pytest.approx((x - r) ** 2 / (r**2 + 0.01), rel=1e-9)
    assert found["ssim"] == pytest.approx((2 * 0.6 * 0.4 + 1e-4) / (0.36 + 0.16 + 1e-4), rel=1e-9)
    assert found["picture_mean"] == pytest.approx([x] * 3) and found["reference_mean"] == pytest.approx([r] * 3)
    assert (found["width"], found["height"], found["domain"], found["encoding"]) == (*SIZE, "8 bits", "srgb")
    assert found["exposure"] is None and found["tonemap"] is None


def test_linear_encoding_is_a_share_of_white(capfd):
    """Pictures of mode phong; what is seen stays the same."""
    paths = eight_bits("a.png", even(153)), eight_bits("b.ppm", even(102))
    found = told(capfd, *paths, "--encoding", "linear")
    assert found["mse"] == pytest.approx(0.04, rel=1e-9) and found["picture_mean"] == pytest.approx([0.6] * 3)
    assert found["psnr"] == told(capfd, *paths)["psnr"]


def test_radiance_is_compared_as_it_is(capfd):
    """Beyond white too, where nothing is seen of it; what is seen follows --exposure."""
    paths = exr("a.exr", even(4, np.float32)), exr("b.exr", even(2, np.float32))
    found = told(capfd, *paths)
    assert found["domain"] == "radiance" and found["mse"] == pytest.approx(4) and found["psnr"] is None
    assert found["relative_mse"] == pytest.approx(4 / 4.01)
    assert (found["greatest_levels"], found["greatest_radiance"]) == (0, 2)
    dark = told(capfd, *paths, "--exposure", "0.01", "--encoding", "linear")
    assert dark["mse"] == found["mse"] and dark["psnr"] == pytest.approx(-20 * math.log10(0.2))
    assert (dark["greatest_levels"], dark["exposure"]) == (51, 0.01)  # 0.4 and 0.2 of 255


@pytest.mark.parametrize("name", ["a.ppm", "a.png", "a.p3.ppm"])
def test_differing_pixels_are_counted_and_found(capfd, name):
    """More than one level counts; the first of the greatest is told, by column and row."""
    reference = noise() // 2
    picture = reference.copy()
    picture[3, 5, 1] += 1
    picture[4, 6, 2] += 2
    picture[7, 9, 0] += 100
    picture[8, 2, 1] += 100
    found = told(capfd, eight_bits(name, picture), eight_bits("b.png", reference))
    assert (found["differing_pixels"], found["differing_share"]) == (3, 3 / 192)
    assert (found["greatest_levels"], found["greatest_at"]) == (100, [9, 7])


def test_greatest_of_radiance_has_a_place_of_its_own(capfd):
    """A firefly may be white in both."""
    reference = even(0.5, np.float32)
    reference[9, 11] = 50
    picture = reference.copy()
    picture[9, 11, 2] = 20
    picture[1, 2, 0] = 0
    found = told(capfd, exr("a.exr", picture), exr("b.exr", reference))
    assert (found["greatest_radiance"], found["greatest_radiance_at"]) == (30, [11, 9])
    assert (found["greatest_levels"], found["greatest_at"]) == (188, [2, 1])  # encoded 0.5


@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("tonemap", ["linear", "reinhard", "filmic"])
@pytest.mark.parametrize("encoding", ["linear", "srgb"])
def test_files_of_one_render_are_equal(capfd, tonemap, encoding, swap):
    """EXR against what the renderer's own lanes make of it in 8 bits: at most one level, where rounding decides."""
    from renderer.core.backend import Float
    from renderer.engine.tonemap import to_bytes

    radiance = np.random.default_rng(2).exponential(0.7, (SIZE[1], SIZE[0], 3)).astype(np.float32)
    shown = to_bytes(Float(radiance.reshape(-1)), Float(0.3 / 0.1), tonemap, encoding).numpy().reshape(radiance.shape)
    settings = {"mode": "phong", "exposure": "0.3", "tonemap": tonemap, "encoding": encoding}
    paths = [eight_bits("a.ppm", shown), exr("b.exr", radiance, **settings)]
    found = told(capfd, *(reversed(paths) if swap else paths))
    assert found["greatest_levels"] <= 1 and found["differing_pixels"] == 0 and found["mse"] < 1e-6
    assert (found["exposure"], found["tonemap"], found["encoding"]) == (0.3, tonemap, encoding)
    assert told(capfd, *paths, "--exposure", "0.25")["greatest_levels"] > 1


@pytest.mark.parametrize("mode, settings", [
    ("pathtracer", []), ("phong", []), ("phong", ["--tonemap", "filmic", "--exposure", "0.2", "--encoding", "srgb"]),
    ("pathtracer", ["--tonemap", "reinhard", "--encoding", "linear"]), ("normals", ["--exposure", "0.3"]),
    ("depth", ["--tonemap", "reinhard", "--encoding", "srgb"]), ("binary", ["--exposure", "0.05"]),
])  # fmt: skip
def test_real_render_agrees_with_itself(scene, capfd, mode, settings):
    """The header tells all that is needed, in modes that show light and in those that do not."""
    assert cli.main([scene, "--mode", mode, *settings, "--samples", "4", "-q", "-o", "a.ppm", "-o", "a.exr"]) == 0
    found = told(capfd, "a.ppm", "a.exr")
    assert found["greatest_levels"] <= 1 and found["differing_pixels"] == 0
    assert max(found["picture_mean"]) > 0 and found["remarks"][0].endswith("(header of a.exr)")


def test_settings_come_from_options_then_the_reference_then_the_picture(capfd):
    """And the table says where from."""
    picture = exr("a.exr", even(0.1, np.float32), mode="phong", exposure="0.4", tonemap="filmic", encoding="linear")
    reference = exr("b.exr", even(0.1, np.float32), mode="phong", exposure="0.2")
    found = told(capfd, picture, reference, "--encoding", "srgb")
    assert (found["exposure"], found["tonemap"], found["encoding"]) == (0.2, "filmic", "srgb")
    assert found["remarks"] == ["compared as radiance; seen with exposure 0.2 (header of b.exr), "
                                "tone map filmic (header of a.exr), encoding srgb (--encoding)"]
    bare = told(capfd, exr("c.exr", even(0.1, np.float32)), eight_bits("d.png", even(9)))
    assert bare["remarks"] == ["compared in 8 bits; radiance of c.exr shown with exposure 0.1, tone map linear, "
                               "encoding srgb (assumed)"]


def test_table_tells_what_json_tells(capfd):
    """Number by number."""
    paths = eight_bits("a.png", noise(1)), eight_bits("b.png", noise(2))
    found = told(capfd, *paths)
    assert cli.main(["compare", *paths]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert lines[0] == "a.png against b.png: 16 x 12 pixels"
    assert [lines[1]] == found["remarks"]
    rows = dict(re.split(r"  +", line.strip(), maxsplit=1) for line in lines[2:])
    assert rows.pop("pixels that differ") == (f"{100 * found['differing_share']:.4g} % ({found['differing_pixels']} of "
                                              "192, by more than 1 level of 255)")
    x, y = found["greatest_at"]
    assert rows.pop("greatest difference") == f"{found['greatest_levels']} levels at x {x}, y {y}"
    assert found["flip"] is not None or rows.pop("FLIP") == "-"
    names = {"MSE": "mse", "relative MSE": "relative_mse", "PSNR": "psnr", "SSIM": "ssim", "FLIP": "flip",
             "mean of the picture": "picture_mean", "mean of the reference": "reference_mean"}
    assert set(rows) <= set(names)
    for name, text in rows.items():
        value = found[names[name]]
        numbers = [float(word) for word in text.removesuffix(" dB").split()]
        assert numbers == pytest.approx(value if isinstance(value, list) else [value], rel=1e-5)


def test_names_of_limits_are_measures():
    """Every one of them has a value, and every value of JSON that is one number can be limited."""
    from renderer.comparison import Values

    assert set(options.LIMITED) < set(Values.__dataclass_fields__)


@pytest.mark.parametrize("limits, worse", [
    (["mse=0.13", "psnr=9", "differing_share=1"], []), (["mse=0.12"], ["mse"]), (["psnr=9.1"], ["psnr"]),
    (["greatest_levels=89", "ssim=0", "mse=1e-3"], ["greatest_levels", "mse"]), (["greatest_levels=90"], []),
])
def test_limits_decide_the_status(capfd, limits, worse):
    """MSE 0.1246, 9.05 dB and 90 levels; a value equal to its limit is none worse."""
    paths = eight_bits("a.png", even(90)), eight_bits("b.png", even(0))
    arguments = ["compare", *paths, "--encoding", "linear", *(f"--limit={limit}" for limit in limits)]
    assert cli.main([*arguments, "--json"]) == (1 if worse else 0)
    said = capfd.readouterr()
    assert json.loads(said.out)["exceeded"] == worse
    assert [line.split(" is ")[0] for line in said.err.splitlines()] == worse


def test_infinite_psnr_is_within_any_limit(capfd):
    """Of equal pictures; JSON stays JSON."""
    paths = eight_bits("a.png", noise()), eight_bits("b.ppm", noise())
    assert told(capfd, *paths, "--limit", "psnr=90")["psnr"] is None
    assert cli.main(["compare", *paths]) == 0
    assert re.search("PSNR +infinite", capfd.readouterr().out)


@pytest.mark.parametrize("hidden, missing, named", [
    (["skimage", "skimage.metrics"], {"ssim"}, "SSIM needs scikit-image"),
    (["flip_evaluator"], {"flip"}, "FLIP needs flip-evaluator"),
    (["skimage", "skimage.metrics", "flip_evaluator"], {"ssim", "flip"},
     "SSIM and FLIP need scikit-image and flip-evaluator"),
])  # fmt: skip
def test_missing_packages_cost_their_measures_only(capfd, monkeypatch, hidden, missing, named):
    """A dash, a null, and one line that says what to install."""
    for name in hidden:
        monkeypatch.setitem(sys.modules, name, None)
    paths = eight_bits("a.png", noise(1)), eight_bits("b.png", noise(2))
    found = told(capfd, *paths)
    assert all(found[name] is None for name in missing) and found["mse"] > 0 and found["psnr"] > 0
    assert f"{named}: {install_command('compare')}" in found["remarks"][-1]
    assert cli.main(["compare", *paths]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert [line for line in lines if re.search(r"  -$", line)] and found["remarks"][-1] in lines
    assert cli.main(["compare", *paths, "--limit", f"{min(missing)}=0.5"]) == 2
    assert "pip install" in capfd.readouterr().err


def test_small_picture_has_no_ssim(capfd):
    """Fewer pixels than a window; everything else is told."""
    found = told(capfd, eight_bits("a.png", noise(1)[:5, :1]), eight_bits("b.png", noise(2)[:5, :1]))
    assert found["ssim"] is None and "SSIM needs 11 x 11 pixels at least" in found["remarks"] and found["mse"] > 0


def test_difference_picture_is_three_beside_one_another(capfd):
    """Picture, reference, and colours of what is between them; nothing else is grey."""
    picture, reference = noise(1), noise(1)
    reference[2, 3] = picture[2, 3] ^ 0x10  # 16 levels
    reference[5, 7, 1] = picture[5, 7, 1] ^ 0x04
    found = told(capfd, eight_bits("a.png", picture), eight_bits("b.png", reference), "-o", "d.png", "--gain", "4")
    width, gap, drawn = SIZE[0], difference.GAP, np.asarray(Image.open("d.png"))
    assert drawn.shape == (SIZE[1], 3 * width + 2 * gap, 3) and found["gain"] == 4
    np.testing.assert_array_equal(drawn[:, :width], picture)
    np.testing.assert_array_equal(drawn[:, width + gap : 2 * width + gap], reference)
    assert (drawn[:, width : width + gap] == difference.GREY).all()
    heat = drawn[:, -width:]
    assert {(int(x), int(y)) for y, x in np.argwhere(heat.any(axis=2))} == {(3, 2), (7, 5)}
    violet = np.array(difference.HEAT[1])  # at a quarter of the scale, which 4 x 16 of 255 is
    assert np.abs(heat[2, 3] - violet).max() <= 1 and np.abs(heat[5, 7] - violet / 4).max() <= 1


def test_colours_grow_lighter():
    """From black to the lightest, which all greater ones share; so the picture can be read without a scale."""
    colours = difference.coloured(np.linspace(0, 1, 256)).astype(float) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(colours) > 0).all() and colours[0] == 0
    np.testing.assert_array_equal(difference.coloured(np.array([1.0, 7.0])), [difference.HEAT[-1]] * 2)


@pytest.mark.parametrize("levels, gain", [(0, 100), (2, 100), (3, 50), (25, 10), (26, 5), (51, 5), (52, 2), (200, 1)])
def test_gain_is_the_largest_that_fits(capfd, levels, gain):
    """Where nothing is clipped; a single pixel does not decide."""
    reference = even(10)
    picture = reference + np.uint8(levels)
    picture[0, 0] = 255
    assert told(capfd, eight_bits("a.png", picture), eight_bits("b.png", reference), "-o", "d.ppm")["gain"] == gain


def test_difference_as_exr_keeps_the_sign(capfd):
    """Picture less reference, linear."""
    told(capfd, exr("a.exr", even([1, 2, 3], np.float32)), exr("b.exr", even([2, 2, 2.5], np.float32)), "-o", "d.exr")
    channels = OpenEXR.File("d.exr", separate_channels=True).channels()
    assert [channels[name].pixels[4, 4].item() for name in "RGB"] == [-1, 0, 0.5]


def test_difference_on_standard_output_leaves_it_free(capfdbinary):
    """The table goes where messages go."""
    paths = eight_bits("a.png", noise(1)), eight_bits("b.png", noise(2))
    assert cli.main(["compare", *paths, "-o", "-"]) == 0
    said = capfdbinary.readouterr()
    assert said.out.startswith(b"P6\n56 12\n255\n") and len(said.out) == 13 + 56 * 12 * 3
    assert said.err.startswith(b"a.png against b.png") and b"standard output: picture, reference" in said.err


@pytest.mark.parametrize("arguments, message", [
    (["a.png"], "the following arguments are required: REFERENCE"),
    (["a.png", "b.png", "c.png"], "unknown argument 'c.png'"),
    (["a.png", "b.png", "--jsn"], "did you mean '--json'?"),
    (["a.png", "b.png", "-o", "d.jpg"], "d.jpg: unknown picture format"),
    (["a.png", "b.png", "-o", "gone/d.png"], "gone/d.png: cannot be written"),
    (["a.png", "b.png", "-o", "b.png"], "b.png: one of the pictures is read from this file"),
    (["a.png", "b.png", "-o", "./a.png"], "./a.png: one of the pictures is read from this file"),
    (["a.png", "b.png", "--gain", "2"], "--gain needs -o FILE"),
    (["a.png", "b.png", "-o", "d.png", "--gain", "0"], "must be a number greater than 0, got '0'"),
    (["a.png", "b.png", "-o", "-", "--json"], "--json and '-o -'"),
    (["a.png", "b.png", "--limit", "flip"], "must look like flip=0.1"),
    (["a.png", "b.png", "--limit", "rmse=1"], "must look like flip=0.1"),
    (["a.png", "b.png", "--limit", "mse=nan"], "must look like flip=0.1"),
    (["a.png", "b.png", "--exposure", "0.2"], "--exposure: both pictures have 8 bits"),
    (["a.png", "b.png", "--tonemap", "filmic"], "--tonemap: both pictures have 8 bits"),
    (["a.png", "small.png"], "a.png has 16 x 12 pixels, and small.png 16 x 11: only pictures of one size"),
    (["gone.png", "b.png"], "gone.png: cannot be read: No such file"),
    ([".", "b.png"], ".: cannot be read: Is a directory"),
    (["empty.png", "b.png"], "empty.png: not a PPM, PNG, JPEG, EXR or HDR picture"),
    (["a.png", "text.exr"], "text.exr: not a PPM, PNG, JPEG, EXR or HDR picture"),
    (["cut.ppm", "b.png"], "cut.ppm: cannot be read: image file is truncated"),
    (["a.png", "cut.exr"], "cut.exr: the EXR is damaged"),
    (["z.exr", "b.png"], "z.exr: has no channels R, G, B or Y, but Z"),
    (["nan.exr", "b.png"], "nan.exr: NaN or infinite in 2 pixels, first at x 4, y 3"),
    (["a.png", "nan.exr"], "nan.exr: NaN or infinite in 2 pixels, first at x 4, y 3"),
])
def test_what_cannot_be_compared_is_told(capfd, folder, arguments, message):
    """In one line of the user's terms, with status 2; nothing is written."""
    eight_bits("a.png", noise(1)), eight_bits("b.png", noise(2)), eight_bits("small.png", noise(3)[:11])
    (folder / "empty.png").touch()
    (folder / "text.exr").write_text("once upon a time")
    (folder / "cut.ppm").write_bytes(b"P6\n16 12\n255\n" + bytes(100))
    radiance = np.random.default_rng(4).random((SIZE[1], SIZE[0], 3)).astype(np.float32)
    (folder / "cut.exr").write_bytes((folder / exr("whole.exr", radiance)).read_bytes()[:900])
    image.write_exr("z.exr", {"Z": radiance[..., 0].copy()}, {})
    radiance[3, 4, 1], radiance[5, 0, 0] = math.nan, -math.inf
    exr("nan.exr", radiance)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert cli.main(["compare", *arguments]) == 2
    said = capfd.readouterr()
    assert said.out == "" and message in said.err
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert "damaged" in message or len(said.err.splitlines()) == 1  # the EXR library has its own say


@pytest.mark.parametrize("name, write", [
    ("grey.png", lambda grey: Image.fromarray(grey).save("grey.png")),
    ("grey16.png", lambda grey: Image.fromarray(grey.astype(np.uint16) * 257).save("grey16.png")),
    ("palette.png", lambda grey: Image.fromarray(grey).convert("P").save("palette.png")),
    ("alpha.png", lambda grey: Image.fromarray(np.dstack([grey] * 4)).save("alpha.png")),
    ("levels.ppm", lambda grey: eight_bits_of_16("levels.ppm", grey)),
    ("half.exr", lambda grey: planes("half.exr", np.float16, R=grey, G=grey, B=grey, A=grey)),
    ("y.exr", lambda grey: planes("y.exr", np.float32, Y=grey)),
])
def test_other_varieties_are_understood(capfd, name, write):
    """Grey, 16 bits, palettes, alpha, few or many levels, half floats, luminance alone."""
    grey = np.arange(192, dtype=np.uint8).reshape(12, 16)
    write(grey)
    reference = eight_bits("b.png", np.dstack([grey] * 3))
    found = told(capfd, name, reference, *(["--encoding", "linear"] if name.endswith(".exr") else []))
    assert found["greatest_levels"] == 0 and found["reference_mean"][0] > 0


def eight_bits_of_16(path, grey):
    """Write a PPM with 65535 levels."""
    values = (np.dstack([grey] * 3).astype(">u2") * 257).astype(">u2")
    with open(path, "wb") as file:
        file.write(b"P6 16 12 65535\n" + values.tobytes())


def planes(path, kind, **channels):
    """Write channels of an EXR, as shares of 255."""
    attributes = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(attributes, {name: (values / 255).astype(kind) for name, values in channels.items()}).write(path)


def test_failed_picture_does_not_cost_the_numbers(capfd):
    """A full disk is told after them, with status 1."""
    paths = eight_bits("a.png", noise(1)), eight_bits("b.png", noise(2))
    os.symlink("/dev/full", "d.ppm")
    assert cli.main(["compare", *paths, "-o", "d.ppm"]) == 1
    said = capfd.readouterr()
    assert "relative MSE" in said.out and said.err == "d.ppm: cannot be written: No space left on device\n"
    assert "lightest" not in said.out


@flip_there
def test_neither_dr_jit_nor_a_scene_is_needed(run_python):
    """Comparing starts without the renderer's engine; 8-bit pictures do without OpenEXR too."""
    eight_bits("a.png", noise(1)), eight_bits("b.ppm", noise(2))
    code = ("import sys; from renderer import cli; status = cli.main(['compare', 'a.png', 'b.ppm']); "
            "print(status, {'drjit', 'mitsuba', 'OpenEXR'} & set(sys.modules))")
    assert run_python(code).stdout.splitlines()[-1] == "0 set()"


def test_help_is_printed_and_named_by_the_renderers_own(capfd):
    """With the options of each."""
    for arguments, word in ((["compare", "--help"], "--limit MEASURE=VALUE"), (["--help"], "compare A B")):
        with pytest.raises(SystemExit) as end:
            cli.main(arguments)
        assert end.value.code == 0 and word in capfd.readouterr().out
