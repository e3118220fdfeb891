"""Arguments, exit statuses and messages of the command line, with a stand-in for the engine."""

import json
import os
import re
from pathlib import Path

import OpenEXR
import pytest
from PIL import Image

from renderer import __version__, cli
from renderer.core.errors import RenderError


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


def test_without_options_the_scene_decides(scene, engine):
    """Nothing is replaced by a default of the command line."""
    assert cli.main([scene]) == 0
    (loaded, seed), = engine.calls
    assert (loaded.description.rendermode, loaded.description.nbounces, seed) == ("phong", 2, 0)
    assert engine.pictures[0].graded == [(None, None, "linear")]
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
    assert "--accel" in said and "'octree'" in said and all(name in said for name in cli.ACCELS)
    assert engine.calls == []


def test_exr_carries_the_settings(scene, engine):
    """A picture tells how it was made."""
    assert cli.main([scene, "-o", "x.exr", "--samples", "4", "--seed", "5", "--exposure", "0.2"]) == 0
    header = OpenEXR.File("x.exr").header()
    settings = {key.removeprefix("renderer."): value for key, value in header.items() if key.startswith("renderer.")}
    assert settings == {
        "version": __version__, "scene": scene, "mode": "phong", "samples": "4", "size": "6x4", "seed": "5",
        "nbounces": "2", "exposure": "0.2",
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

    monkeypatch.setattr(machine, "available_memory", lambda: 2**30)
    assert cli.main([scene, "--size", "8000x6000"]) == 2
    assert "8000 x 6000 needs about 1.3 GiB of memory, and 1.0 GiB are free" in capsys.readouterr().err
    assert engine.calls == []
    assert cli.main([scene, "--size", "4000x3000"]) == 0
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


def test_texture_is_not_overwritten_by_the_picture(scene, document, engine, capsys):
    """`-o` with the name of a texture is a mistake, not a wish."""
    document["scene"]["shapes"][0]["material"] = {"texture": "wood.ppm"}
    Path(scene).write_text(json.dumps(document))
    Path("wood.ppm").write_bytes(b"P6\n1 1\n255\nabc")
    assert cli.main([scene, "-o", "wood.ppm"]) == 2
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
    def fail(loaded, *, seed, progress):
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
    def fail(loaded, *, seed, progress):
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
