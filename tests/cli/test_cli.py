"""Arguments, exit statuses and messages of the command line, with a stand-in for the engine."""

import json
import os
import re
import signal
import sys
from pathlib import Path
from types import SimpleNamespace

import OpenEXR
import pytest
from PIL import Image

from renderer import __version__, cli, options as command_line
from renderer.core.errors import RenderError
from tests.cli.conftest import StandInPicture


def test_default_output_has_the_scenes_name(scene, engine):
    """Without -o the picture lies in the current folder."""
    assert cli.main([scene]) == 0
    assert os.path.getsize("small.ppm") == len(b"P6\n6 4\n255\n") + 6 * 4 * 3


def test_default_output_lies_in_the_current_folder(scene, engine, tmp_path, monkeypatch):
    """A scene elsewhere does not get its picture beside it."""
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert cli.main([str(tmp_path / scene)]) == 0
    assert os.listdir(".") == ["small.ppm"]


def test_several_outputs_come_from_one_render(scene, engine):
    """All formats are written, and the engine is asked once."""
    assert cli.main([scene, "-o", "a.ppm", "-o", "b.png", "--output", "c.exr", "-o", "D.PNG"]) == 0
    assert len(engine.calls) == 1
    assert len(engine.pictures[0].graded) == 1
    with Image.open("a.ppm") as ppm, Image.open("b.png") as png:
        assert ppm.tobytes() == png.tobytes()
    assert os.path.exists("D.PNG")
    assert set(OpenEXR.File("c.exr", separate_channels=True).channels()) == {"R", "G", "B"}


def test_settings_replace_those_of_the_scene(scene, engine):
    """Mode, size, samples, bounces and seed reach the engine."""
    options = ["--mode", "depth", "--size", "7x5", "--samples", "9", "--bounces", "3", "--seed", "11"]
    assert cli.main([scene, *options]) == 0
    (loaded, seed), = engine.calls
    description = loaded.description
    assert (description.rendermode, description.samples, description.nbounces, seed) == ("depth", 9, 3, 11)
    assert (description.camera.width, description.camera.height) == (7, 5)


@pytest.mark.parametrize("name, mode", [("path", "pathtracer"), ("Path-Tracing", "pathtracer"), ("preview", "phong")])
def test_mode_is_understood_as_in_scene_files(scene, engine, name, mode):
    """Spellings of other programs; `phnog` is none."""
    assert cli.main([scene, "--mode", name]) == 0
    (loaded, _), = engine.calls
    assert loaded.description.rendermode == mode


def test_without_options_the_scene_decides(scene, engine):
    """Nothing is replaced by a default of the command line."""
    assert cli.main([scene]) == 0
    (loaded, seed), = engine.calls
    assert (loaded.description.rendermode, loaded.description.nbounces, seed) == ("phong", 2, 0)
    assert engine.pictures[0].graded == [(None, None, None)]
    assert engine.loaded == [(None, None)]


def test_grading_reaches_the_picture(scene, engine):
    """Tone map, exposure and encoding are handed on."""
    assert cli.main([scene, "--tonemap", "filmic", "--exposure", "0.3", "--encoding", "srgb"]) == 0
    assert engine.pictures[0].graded == [("filmic", 0.3, "srgb")]


def test_backend_and_threads_reach_the_engine(scene, engine):
    """They are needed when Dr.Jit is loaded."""
    assert cli.main([scene, "--backend", "llvm", "--threads", "3"]) == 0
    assert engine.loaded == [("llvm", 3)]


@pytest.mark.parametrize("options, accel", [
    ([], "auto"), (["--accel", "bvh"], "bvh"), (["--accel=grid"], "grid"), (["--accel", "none"], "none"),
])
def test_structure_reaches_the_engine(scene, engine, options, accel):
    """By its name; without the option the scene decides."""
    assert cli.main([scene, *options]) == 0
    assert engine.accels == [accel]


def test_unknown_structure_is_told_with_those_there_are(scene, engine, capsys):
    """And nothing is rendered."""
    assert cli.main([scene, "--accel", "octree"]) == 2
    said = capsys.readouterr().err
    assert "--accel" in said and "'octree'" in said and all(name in said for name in command_line.ACCELS)
    assert engine.calls == []


def test_exr_carries_the_settings(scene, engine):
    """A picture tells how it was made."""
    assert cli.main([scene, "-o", "x.exr", "--samples", "4", "--seed", "5", "--exposure", "0.2"]) == 0
    header = OpenEXR.File("x.exr").header()
    settings = {key.removeprefix("renderer."): value for key, value in header.items() if key.startswith("renderer.")}
    assert settings == {
        "version": __version__, "scene": scene, "mode": "phong", "samples": "4", "size": "6x4", "seed": "5",
        "nbounces": "2", "exposure": "0.2", "tonemap": "linear", "encoding": "linear",
    }


def test_every_run_ends_with_one_line(scene, engine, capsys):
    """Where the picture is, what it shows, and how long each part took; on standard error."""
    assert cli.main([scene, "-o", "a.ppm", "-o", "b.png"]) == 0
    said = capsys.readouterr()
    assert said.out == ""
    assert re.fullmatch(
        r"a\.ppm, b\.png: 6 x 4, phong, 1 sample a pixel; built in 0\.02 s, compiled in 0\.00 s, "
        r"rendered in 0\.03 s \(32 M samples/s\), total \d+\.\d\d s\n", said.err)


def test_quiet_run_says_nothing(scene, engine, capsys):
    """No news is good news."""
    assert cli.main([scene, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_warning_of_the_scene_is_printed(scene, document, engine, capsys):
    """What was ignored is told, also with --quiet, and the render goes on."""
    Path(scene).write_text(json.dumps(document | {"shutterspeed": 3}))
    assert cli.main([scene, "-q"]) == 0
    assert re.fullmatch(r"warning: small\.json:1:\d+: shutterspeed: .*\n", capsys.readouterr().err)


def test_picture_that_does_not_fit_into_memory_is_refused(scene, engine, capsys, monkeypatch):
    """With the size, what it needs and what is there; a picture that fits, or an unknown memory, is no matter."""
    from renderer import machine

    monkeypatch.setitem(sys.modules, "mitsuba_oidn", SimpleNamespace())
    monkeypatch.setattr(machine, "available_memory", lambda: 2**30)
    assert cli.main([scene, "--size", "8000x6000"]) == 2
    assert "8000 x 6000 needs about 1.3 GiB of memory, and 1.0 GiB are free" in capsys.readouterr().err
    assert engine.calls == []
    assert cli.main([scene, "--size", "4000x3000"]) == 0
    for options in (["-o", "x.exr"], ["--samples", "2"], ["--time", "1"], ["--denoise"]):  # each takes more
        assert cli.main([scene, "--size", "5500x5000", *options]) == 2
        assert "choose a smaller --size" in capsys.readouterr().err
    assert cli.main([scene, "--size", "5500x5000", "-q"]) == 0
    monkeypatch.setattr(machine, "available_memory", lambda: None)
    assert cli.main([scene, "--size", "8000x6000"]) == 0


def test_note_of_the_scene_is_told_apart(scene, document, engine, capsys):
    """A spelling that was understood is no warning, and --quiet drops it."""
    Path(scene).write_text(json.dumps(document | {"camera samples": 2}))
    assert cli.main([scene]) == 0
    assert re.match(r"note: small\.json:1:\d+: ", capsys.readouterr().err)
    assert cli.main([scene, "-q"]) == 0
    assert capsys.readouterr().err == ""


def test_strict_makes_the_warning_a_mistake(scene, document, engine, capsys):
    """With --strict nothing is rendered."""
    Path(scene).write_text(json.dumps(document | {"shutterspeed": 3}))
    assert cli.main([scene, "--strict"]) == 2
    assert engine.calls == [] and not os.path.exists("small.ppm")
    assert "shutterspeed" in capsys.readouterr().err


def test_all_mistakes_of_a_scene_are_told(scene, document, engine, capsys):
    """One line for each, with its place."""
    Path(scene).write_text(json.dumps(document | {"nbounces": -1, "samples": "many"}))
    assert cli.main([scene]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert all(re.match(r"small\.json:1:\d+: (nbounces|samples): ", line) for line in lines)


@pytest.mark.parametrize("arguments, message", [
    ([], "the following arguments are required: SCENE"),
    (["small.json", "--sampels", "3"], "unknown argument '--sampels', did you mean '--samples'?"),
    (["small.json", "--sam", "3"], "unknown argument '--sam'"),
    (["small.json", "other.json"], "unknown argument 'other.json'"),
    (["small.json", "--mode", "phnog"], "invalid choice: 'phnog'"),
    (["small.json", "--samples", "0"], "must be a whole number from 1 to"),
    (["small.json", "--samples", "1e3"], "must be a whole number from 1 to"),
    (["small.json", "--samples", "9" * 5000], "must be a whole number from 1 to"),
    (["small.json", "--bounces", "-1"], "must be a whole number from 0 to"),
    (["small.json", "--seed", "4294967296"], "must be a whole number from 0 to 4294967295"),
    (["small.json", "--threads", "0"], "must be a whole number from 1 to"),
    (["small.json", "--size", "300"], "must look like 1200x800"),
    (["small.json", "--size", "0x5"], "width: must be"),
    (["small.json", "--size", "65536x65536"], "65536 x 65536"),
    (["small.json", "--time", "0"], "must be a number greater than 0"),
    (["small.json", "--error", "inf"], "must be a number greater than 0"),
    (["small.json", "--time", "2", "--mode", "depth"], "--time: mode 'depth' has no samples"),
    (["small.json", "--pixel", "3"], "must look like 12,34"),
    (["small.json", "--pixel", "6,0"], "--pixel: the picture is 6 x 4, counted from 0"),
    (["small.json", "--pixel", "0,0", "--mode", "uv"], "--pixel: mode 'uv' has no samples"),
    (["small.json", "--sample", "3"], "--sample needs --pixel X,Y"),
    (["small.json", "--denoise", "--mode", "binary"], "--denoise: mode 'binary' shows no light"),
    (["small.json", "--exposure", "nan"], "must be a number of at least 0"),
    (["small.json", "--exposure", "-1"], "must be a number of at least 0"),
    (["small.json", "--exposure", "bright"], "must be a number of at least 0"),
    (["small.json", "--tonemap", "aces"], "invalid choice: 'aces'"),
    (["small.json", "--backend", "metal"], "invalid choice: 'metal'"),
    (["small.json", "--encoding", "gamma"], "invalid choice: 'gamma'"),
    (["small.json", "-o"], "expected one argument"),
    (["-q", "doctor"], "'doctor' takes no options of a render"),
    (["schema", "extra"], "'schema' takes no arguments"),
    (["missing.json"], "missing.json: no such file"),
    (["."], "is a directory"),
], ids=lambda value: " ".join(value)[:30] if isinstance(value, list) else "")
def test_unusable_argument_is_told(scene, engine, capsys, arguments, message):
    """Status 2, one line that says what is wrong, nothing rendered and no file made."""
    assert cli.main(arguments) == 2
    said = capsys.readouterr()
    assert message in said.err and len(said.err.splitlines()) == 1
    assert said.out == ""
    assert engine.loaded == [] and os.listdir(".") == [scene]


@pytest.mark.parametrize("output, message", [
    ("out.tga", "out.tga: unknown picture format; the name must end in .ppm, .png, .exr"),
    ("out", "out: unknown picture format"),
    ("", "(empty): unknown picture format"),
    ("nowhere/out.ppm", "nowhere/out.ppm: cannot be written: there is no folder"),
    (".", ".: cannot be written: it is a folder"),
    ("good.ppm", "good.ppm: this output is given twice"),
    ("./good.ppm", "./good.ppm: this output is given twice"),
])
def test_unusable_output_is_told_before_any_work(scene, engine, capsys, output, message):
    """Status 2, and the other outputs are not begun."""
    assert cli.main([scene, "-o", "good.ppm", "-o", output]) == 2
    assert message in capsys.readouterr().err
    assert engine.loaded == [] and os.listdir(".") == [scene]


def test_all_unusable_outputs_are_told(scene, engine, capsys):
    """One line for each."""
    assert cli.main([scene, "-o", "a.gif", "-o", "b.bmp"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 2


def test_scene_is_not_overwritten_by_its_picture(scene, engine, capsys):
    """A scene file named like a picture would otherwise be lost."""
    os.rename(scene, "small.ppm")
    before = Path("small.ppm").read_bytes()
    assert cli.main(["small.ppm"]) == 2
    assert "the scene is read from this file" in capsys.readouterr().err
    assert Path("small.ppm").read_bytes() == before


@pytest.mark.parametrize("material", [
    {"texture": "wood.ppm"}, {"normalmap": "wood.ppm"}, {"bumpmap": "wood.ppm"},
    {"bsdf": {"type": "roughconductor", "alpha": "wood.ppm"}},
])  # fmt: skip
def test_texture_is_not_overwritten_by_the_picture(scene, document, engine, capsys, material):
    """`-o` with the name of a texture or map is a mistake, not a wish."""
    document["scene"]["shapes"][0]["material"] = material
    Path(scene).write_text(json.dumps(document))
    Path("wood.ppm").write_bytes(b"P6\n1 1\n255\nabc")
    assert cli.main([scene, "-o", "wood.ppm"]) == 2
    assert "the scene is read from this file" in capsys.readouterr().err


def test_surroundings_are_not_overwritten_by_the_picture(scene, document, engine, capsys):
    """Nor is the image of an environment."""
    document["scene"]["lightsources"].append({"type": "environment", "filename": "sky.ppm"})
    Path(scene).write_text(json.dumps(document))
    Path("sky.ppm").write_bytes(b"P6\n1 1\n255\nabc")
    assert cli.main([scene, "-o", "sky.ppm"]) == 2
    assert "the scene is read from this file" in capsys.readouterr().err


def test_failed_write_does_not_keep_the_others(scene, engine, capsys):
    """The full disk is reported with status 1, and the pictures elsewhere are complete."""
    os.symlink("/dev/full", "full.png")
    assert cli.main([scene, "-o", "a.ppm", "-o", "full.png", "-o", "c.exr"]) == 1
    assert "full.png: cannot be written: No space left on device" in capsys.readouterr().err
    assert sorted(os.listdir(".")) == ["a.ppm", "c.exr", "full.png", scene]


def test_second_failure_is_reported_too(scene, engine, capsys):
    """Every file that could not be written is named."""
    os.symlink("/dev/full", "full.png")
    os.symlink("/dev/full", "full.ppm")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("renderer.io.outputs.os.path.realpath", os.path.abspath)  # both are one device
        assert cli.main([scene, "-o", "full.ppm", "-o", "full.png"]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 2


@pytest.mark.parametrize("error, status, message", [
    (RenderError("the device is gone"), 1, "the device is gone"),
    (MemoryError(), 1, "there is not enough memory for this render; try a smaller --size"),
    (KeyboardInterrupt(), 130, "interrupted; no picture was left unfinished"),
    (BrokenPipeError(), 1, "standard output: its reader closed it before everything was written"),
    (ZeroDivisionError("division\nby zero"), 1, "unexpected ZeroDivisionError: division by zero; please report it"),
], ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else "")
def test_failure_while_rendering_is_told(scene, engine, capsys, monkeypatch, error, status, message):
    """One line and the documented status; an old picture stays as it was."""
    def fail(loaded, **settings):
        raise error

    monkeypatch.delenv("RENDERER_DEBUG", raising=False)
    engine.render = fail
    Path("small.ppm").write_bytes(b"old")
    assert cli.main([scene]) == status
    said = capsys.readouterr().err
    assert said.startswith(message) and len(said.splitlines()) == 1
    assert Path("small.ppm").read_bytes() == b"old" and sorted(os.listdir(".")) == [scene, "small.ppm"]


def test_traceback_is_there_for_developers(scene, engine, capsys, monkeypatch):
    """RENDERER_DEBUG shows where it happened."""
    def fail(loaded, **settings):
        raise ZeroDivisionError

    engine.render = fail
    monkeypatch.setenv("RENDERER_DEBUG", "1")
    assert cli.main([scene]) == 1
    assert "Traceback" in capsys.readouterr().err


def test_interrupt_while_writing_leaves_no_half_picture(scene, engine, monkeypatch):
    """Ctrl-C between two bytes of a file."""
    def interrupt(width, height):
        assert len(os.listdir(".")) == 2, "the file is open by now"
        raise KeyboardInterrupt

    monkeypatch.setattr("renderer.io.image.ppm_header", interrupt)
    assert cli.main([scene]) == 130
    assert os.listdir(".") == [scene]


def test_unloadable_library_points_to_the_doctor(scene, capsys, monkeypatch):
    """A Dr.Jit that cannot be loaded is a plain sentence."""
    import builtins

    real = builtins.__import__

    def refuse(name, *arguments, **keywords):
        if name.startswith("renderer.engine"):
            raise ImportError("libLLVM.so: cannot open shared object file")
        return real(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", refuse)
    assert cli.main([scene]) == 1
    assert capsys.readouterr().err == (
        "Dr.Jit cannot be used here: libLLVM.so: cannot open shared object file; "
        "'python -m renderer doctor' tells what to do\n")


def test_schema_is_json(capfd):
    """What is printed is a JSON Schema and nothing else."""
    assert cli.main(["schema"]) == 0
    assert json.loads(capfd.readouterr().out)["type"] == "object"


@pytest.mark.parametrize("rate, words", [
    (0.0, "0"), (999.4, "999"), (1000, "1.0 k"), (999_600, "1.0 M"), (3_240_000, "3.2 M"), (9.96e6, "10 M"),
    (32e6, "32 M"), (4.2e9, "4.2 G"), (31e9, "31 G"),
])
def test_rate_is_short(rate, words):
    """Two digits are enough, and rounding never gives 1000 of a unit."""
    assert cli.rate_in_words(rate) == words


def test_limits_of_time_and_error_reach_the_engine(scene, engine):
    """In place of the scene's number of samples; --samples is the most then."""
    from renderer.engine.passes import Until
    from renderer.scene.schema import MAX_SAMPLES

    for given, until in (
        ([], None), (["--time", "2.5"], Until(MAX_SAMPLES, 2.5)), (["--error", "0.02"], Until(error=0.02)),
        (["--time", "1e3", "--error", "1", "--samples", "64"], Until(64, 1000.0, 1.0)),
    ):
        assert cli.main([scene, *given]) == 0
        assert engine.limits[-1] == (until, False)


def test_variance_is_asked_for_where_it_is_written(scene, engine):
    """An EXR has a place for it."""
    assert cli.main([scene, "-o", "a.ppm", "-o", "b.EXR"]) == 0
    assert engine.limits == [(None, True)]


def test_exr_tells_the_samples_that_were_rendered(scene, engine):
    """Not those that were asked for, where time was up before."""
    def stopped(loaded, **settings):
        picture = StandInPicture(loaded)
        picture.samples = 12
        return picture

    engine.render = stopped
    assert cli.main([scene, "-o", "x.exr", "--samples", "40", "--time", "1"]) == 0
    assert OpenEXR.File("x.exr").header()["renderer.samples"] == "12"


@pytest.fixture
def ctrl_c():
    """Ctrl-C as a program has it that was started in the foreground; one in the background would ignore it."""
    former = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, former)


def test_interrupted_picture_is_written_with_its_status(scene, engine, capsys, ctrl_c):
    """130, the picture, and how many samples it has."""
    def stopped(loaded, *, interrupted, **settings):
        assert not interrupted()
        signal.raise_signal(signal.SIGINT)
        assert interrupted()
        return StandInPicture(loaded)

    engine.render = stopped
    assert cli.main([scene, "-q"]) == 130
    assert capsys.readouterr().err.endswith("interrupted after 1 sample a pixel\n") and os.path.exists("small.ppm")


def test_lost_samples_are_told_with_the_command_that_repeats_them(scene, engine, capsys):
    """Also with --quiet; what the picture depended on is in the command."""
    def lossy(loaded, **settings):
        picture = StandInPicture(loaded)
        picture.lost = SimpleNamespace(count=3, examples=(("nan", 5, 2, 17), ("inf", 0, 1, 0)))
        return picture

    engine.render, repeated = lossy, "--seed 4 --size 8x6 --samples 20 --bounces 0"
    assert cli.main([scene, "-q", *repeated.split()]) == 0
    assert capsys.readouterr().err.splitlines() == [
        "warning: 3 samples of the picture were NaN or infinite, and left out",
        f"warning: nan: python -m renderer small.json --pixel 5,2 --sample 17 {repeated}",
        f"warning: inf: python -m renderer small.json --pixel 0,1 --sample 0 {repeated}"]


def test_one_sample_is_printed(scene, capfd):
    """Its radiance goes to standard output, and no picture is written; another sample or seed is another number."""
    options = ["--mode", "pathtracer", "--bounces", "1"]
    said = []
    for given in (["--sample", "3"], ["--sample", "3"], ["--sample", "4"], ["--sample", "3", "--seed", "1"]):
        assert cli.main([scene, "--pixel", "2,1", *given, *options]) == 0
        said.append(capfd.readouterr().out)
    number = r"[-+.e0-9]+"
    assert re.fullmatch(rf"pixel 2,1 sample 3 seed 0: {number} {number} {number}\n", said[0])
    assert said[0] == said[1] != said[2] and said[3].startswith("pixel 2,1 sample 3 seed 1: ")
    assert said[3].split(": ")[1] != said[0].split(": ")[1]
    assert os.listdir(".") == [scene]


def test_denoiser_that_is_not_installed_is_told(scene, engine, capsys, monkeypatch):
    """Before any work, with the command that installs it."""
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    assert cli.main([scene, "--denoise"]) == 2
    said = capsys.readouterr().err
    assert f"{sys.executable} -m pip install -r " in said and "requirements/denoise.txt" in said
    assert len(said.splitlines()) == 1
    assert engine.calls == [] and os.listdir(".") == [scene]


def test_denoiser_gets_the_picture_and_gives_another(scene, document, monkeypatch):
    """A stand-in for the library: linear colour, albedo and normals go in, and what comes out is written."""
    def denoise(colour, albedo, normal, *, hdr, clean_aux):
        assert colour.shape == albedo.shape == normal.shape == (4, 6, 3) and hdr and clean_aux
        assert colour[0, 0].tolist() == [0.25] * 3 and not albedo[0, 0].any() and normal[2, 3, 2] < -0.5
        return 0.5 * colour

    monkeypatch.setitem(sys.modules, "mitsuba_oidn", SimpleNamespace(denoise=denoise))
    assert cli.main([scene, "-o", "plain.exr", "-o", "plain.ppm"]) == 0
    assert cli.main([scene, "-o", "smooth.exr", "-o", "smooth.ppm", "--denoise"]) == 0
    plain, smooth = (OpenEXR.File(f"{name}.exr", separate_channels=True).channels() for name in ("plain", "smooth"))
    for name in "RGB":
        assert (smooth[name].pixels == 0.5 * plain[name].pixels).all() and plain[name].pixels.any()
    assert Path("plain.ppm").read_bytes()[-1] == 64 and Path("smooth.ppm").read_bytes()[-1] == 32


def test_failure_of_the_denoiser_is_told(scene, monkeypatch, capsys):
    """Status 1 and one line."""
    def denoise(*pictures, **settings):
        raise RuntimeError("no device")

    monkeypatch.setitem(sys.modules, "mitsuba_oidn", SimpleNamespace(denoise=denoise))
    assert cli.main([scene, "--denoise"]) == 1
    assert "cannot be denoised: no device" in capsys.readouterr().err


def test_exr_has_what_the_first_rays_hit(scene):
    """Beside the colour where light is shown, and not where a mode shows one thing only."""
    first = {"Albedo.R", "Albedo.G", "Albedo.B", "N.X", "N.Y", "N.Z", "Z", "Shape", "SampleCount"}
    for options, names, samples in (
        (["--samples", "2"], first | {"Variance"}, 2), ([], first, 1),
        (["--mode", "pathtracer"], first | {"Variance"}, 64), (["--mode", "binary", "--samples", "2"], set(), 2),
    ):
        assert cli.main([scene, "-o", "x.exr", *options]) == 0
        channels = OpenEXR.File("x.exr", separate_channels=True).channels()
        assert set(channels) == {"R", "G", "B"} | names
        if names:
            assert channels["N.Z"].pixels[2, 3] < -0.5 and channels["Z"].pixels[2, 3] < 1 < channels["Z"].pixels[0, 0]
            assert channels["Shape"].pixels[2, 3] == 0 and channels["Shape"].pixels[0, 0] == 2**32 - 1
            assert channels["SampleCount"].pixels[1, 1] == samples
