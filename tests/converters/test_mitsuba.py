"""The export for stock Mitsuba: dictionary and XML are the same scene, and both are the scene described."""

import re
import subprocess
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

from converters import mitsuba as export
from converters import whitted
from renderer.scene.loader import override
from tests.support import oracle as sides
from tests.support.documents import GLASS, GROUND, MIRROR, SHAPES, SHINY, scene, shape, write_texture

pytestmark = pytest.mark.oracle

MODES = ("binary", "phong", "depth", "normals", "uv", "albedo", "shapes")
TEXTURED = {**SHINY, "texture": "texture.png", "texturewrap": "clamp", "texturefilter": "nearest", "scaleU": 1.7}
BOARD = {**SHINY, "texture": {"type": "checkerboard", "scale": 5.0}}
SIZE = 90, 60
FEW = 4  # rays a pixel: both sides have the same noise, because the seeds are the same
EVERYTHING = scene(
    shape("sphere", {**GLASS, "reflectivity": 1.0}), shape("cylinder", TEXTURED), shape("triangle", MIRROR),
    shape("plane", BOARD), shape("box", {**TEXTURED, "texturefilter": "bilinear"}), shape("convex_vertices", GLASS),
    {**shape("sphere", {**MIRROR, "reflectivity": 1.0}), "center": [-1.1, 0.4, 0.3]},
    camera={"position": [0.4, 2.1, -4.0], "upVector": [0.1, 1, 0]},
)

LITTLE = scene(shape("sphere", {**GLASS, "reflectivity": 1.0}), GROUND)


def prepare(folder, document, mode=None):
    """Return the loaded document at the size of these tests."""
    write_texture(folder / "texture.png")
    return override(sides.prepare(sides.write(folder, document), *SIZE, mode=mode), samples=FEW)


def picture(loaded_scene):
    """Return Mitsuba's picture of a scene of its own."""
    return np.array(mi.render(loaded_scene, seed=5), dtype=np.float64)


def same(ours, theirs):
    """Return whether two of Mitsuba's pictures agree but for rounding at a few edges."""
    scale = np.maximum(np.abs(theirs), 1.0)
    return ours.shape == theirs.shape and (np.abs(ours - theirs) > 1e-3 * scale).mean() < 1e-3


def renumbered(shapes):
    """Return shape numbers in order of first appearance: dictionary and XML count primitives differently."""
    _, first, inverse = np.unique(shapes, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse].reshape(shapes.shape).astype(float)


@pytest.mark.parametrize("mode", MODES)
def test_xml_is_the_dictionary(tmp_path, mode):
    """The XML with its files renders to the picture of the dictionary, in every mode."""
    loaded = prepare(tmp_path, EVERYTHING, mode)
    export.write_xml(loaded, tmp_path / "scene.xml")
    from_dict = picture(mi.load_dict(export.to_dict(loaded)))
    from_xml = picture(mi.load_file(str(tmp_path / "scene.xml")))
    if mode == "shapes":
        from_dict, from_xml = renumbered(from_dict), renumbered(from_xml)
    assert from_dict.std() > 0.01, "an even picture shows nothing"
    assert same(from_xml, from_dict)


@pytest.mark.parametrize(("mode", "pattern", "replacement"), [
    ("phong", r'name="fov" value="34.0"', 'name="fov" value="35.0"'),
    ("normals", r'(type="cylinder".*\n.*<transform name="to_world"><matrix value=")', r"\g<1>-"),
    ("albedo", r'value="nearest"', 'value="bilinear"'),
    ("albedo", r'value="clamp"', 'value="repeat"'),
    ("albedo", r'name="raw" value="true"', 'name="raw" value="false"'),
    ("albedo", r'(name="to_uv"><matrix value="\S+ \S+ \S+) 1.7', r"\g<1> 0.0"),
    ("phong", r'name="int_ior" value="1.5"', 'name="int_ior" value="1.6"'),
    ("phong", r'(<rgb name="intensity" value=")\S+', r"\g<1>0"),
])
def test_changed_xml_is_another_scene(tmp_path, mode, pattern, replacement):
    """The comparison above sees a changed camera, texture, index or light."""
    loaded = prepare(tmp_path, LITTLE if mode == "phong" else EVERYTHING, mode)
    path = tmp_path / "scene.xml"
    export.write_xml(loaded, path)
    text, count = re.subn(pattern, replacement, path.read_text())
    assert count, "nothing was changed"
    path.write_text(text)
    assert not same(picture(mi.load_file(str(path))), picture(mi.load_dict(export.to_dict(loaded))))


@pytest.mark.parametrize("name", SHAPES)
def test_stock_geometry_is_that_of_the_exact_counterpart(tmp_path, name):
    """Normals of the exported scene, rendered by stock Mitsuba, are those of the scene described."""
    loaded = prepare(tmp_path, scene(shape(name), GROUND), "normals")
    export.write_xml(loaded, tmp_path / "scene.xml")
    stock = picture(mi.load_file(str(tmp_path / "scene.xml")))
    exact = whitted.reference(loaded)
    where = ~whitted.mask_uncertain(loaded, edges=True)
    assert np.abs(stock - exact["normal"])[where].max() < 2e-3


@pytest.mark.parametrize("name", SHAPES)
def test_stock_albedo_is_that_of_the_exact_counterpart(tmp_path, name):
    """Textures of the exported scene lie where the scene's texture coordinates put them, caps and planes included."""
    texture = {**TEXTURED, "texturefilter": "bilinear", "texturewrap": "repeat", "scaleU": 0.7, "scaleV": 0.6}
    loaded = prepare(tmp_path, scene(shape(name, texture), camera={"position": [0.4, 1.5, -4.0]}), "albedo")
    export.write_xml(loaded, tmp_path / "scene.xml")
    stock, exact = picture(mi.load_file(str(tmp_path / "scene.xml"))), whitted.reference(loaded)
    near = exact["depth"] < 80  # a textured plane is finite in stock Mitsuba
    assert (np.abs(stock - exact["albedo"]).max(axis=-1)[near] > 0.01).mean() < 0.002


def test_binary_export_is_red_where_something_is_hit(tmp_path):
    """The aov picture of binary mode is (1, 0, 0) on the mask and 0 off it."""
    loaded = prepare(tmp_path, EVERYTHING, "binary")
    exact = whitted.reference(loaded)["rgb"]
    assert np.abs(picture(mi.load_dict(export.to_dict(loaded))) - exact).max(axis=-1).mean() < 1e-3


@pytest.mark.parametrize("name", ["simple_phong", "scene", "mirror_image"])
def test_nearest_counterpart_is_about_as_bright(root, name):
    """The stock picture of a phong scene has the brightness of the exact one, though not its light."""
    loaded = sides.prepare(root / "scenes" / f"{name}.json", *SIZE, mode="phong")
    stock, exact = picture(mi.load_dict(export.to_dict(loaded))), whitted.reference(loaded)
    ratio = stock[exact["hit"]].mean() / exact["rgb"][exact["hit"]].mean()
    assert 0.6 < ratio < 1.6


def test_every_replacement_is_named(tmp_path):
    """What stock Mitsuba cannot express is told once each, with its places."""
    warnings = [str(w) for w in export.write_xml(prepare(tmp_path, EVERYTHING), tmp_path / "scene.xml")]
    for words in ("without fall-off", "ambient term", "background also lights", "path integrator", "rough plastic",
                  "mirror share", "glass share", "finite rectangle", "8-bit"):
        assert sum(words in w for w in warnings) == 1, words
    assert any("scene.shapes[1], scene.shapes[4]" in w for w in warnings)


def test_plain_matt_scene_has_no_material_remarks(tmp_path):
    """Nothing is said about what is exact."""
    document = scene(shape("sphere", {"ks": 0.0}), lights=(), ambientlight=[0, 0, 0], backgroundcolor=[0, 0, 0])
    assert export.write_xml(prepare(tmp_path, document), tmp_path / "scene.xml") == ()


def test_unbounded_volume_is_clipped_with_a_warning(tmp_path):
    """A single half-space becomes a mesh that ends far away, and the warning says so."""
    document = scene({"type": "convex", "halfspaces": [[0, 1, 0, -0.5]], "material": SHINY})
    loaded = prepare(tmp_path, document, "normals")
    warnings = export.write_xml(loaded, tmp_path / "scene.xml")
    assert any("cut off" in str(w) and "scene.shapes[0]" in str(w) for w in warnings)
    assert np.allclose(picture(mi.load_file(str(tmp_path / "scene.xml")))[-1, SIZE[0] // 2], [0, 1, 0], atol=1e-6)


def run(*arguments, cwd):
    """Return the finished process of the converter's command line."""
    root = Path(__file__).resolve().parents[2]
    return subprocess.run([sys.executable, "-m", "converters.mitsuba", *map(str, arguments)], cwd=cwd, text=True,
                          capture_output=True, env={"PYTHONPATH": str(root), "PATH": ""}, check=False)


def test_command_writes_beside_the_caller_and_warns(tmp_path):
    """Without -o the XML has the scene's name in the current folder; warnings go to stderr."""
    prepare(tmp_path, EVERYTHING)
    (tmp_path / "elsewhere").mkdir()
    done = run(tmp_path / "scene.json", cwd=tmp_path / "elsewhere")
    assert (done.returncode, done.stdout) == (0, "")
    assert "warning: " in done.stderr and "without fall-off" in done.stderr
    assert mi.load_file(str(tmp_path / "elsewhere" / "scene.xml")).sensors()


def test_stock_mitsuba_renders_the_export(tmp_path):
    """`mitsuba scene.xml` of the stock command line writes the picture."""
    prepare(tmp_path, scene(shape("box"), GROUND, mode="normals"))
    assert run(tmp_path / "scene.json", "-o", tmp_path / "out.xml", cwd=tmp_path).returncode == 0
    command = Path(sys.executable).with_name("mitsuba")
    done = subprocess.run([command, "-m", "scalar_rgb", "out.xml"], cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert np.array(mi.Bitmap(str(tmp_path / "out.exr"))).shape[2] >= 3


def test_help_and_bad_input(tmp_path):
    """--help gives 0; missing scenes, mistakes in them and unwritable outputs give 2 and a line, no traceback."""
    assert run("--help", cwd=tmp_path).returncode == 0
    prepare(tmp_path, EVERYTHING)
    (tmp_path / "bad.json").write_text('{"camera": {"position": [0, 0, 0]}}')
    before = set(tmp_path.iterdir())
    for arguments in (["missing.json"], ["bad.json"], ["scene.json", "-o", "no/such/folder/x.xml"], [],
                      ["scene.json", "-o", tmp_path], ["scene.json", "--mode", "nonsense"]):
        done = run(*arguments, cwd=tmp_path)
        assert done.returncode == 2 and done.stderr and "Traceback" not in done.stderr, (arguments, done.stderr)
    assert set(tmp_path.iterdir()) == before


def test_failed_export_leaves_nothing_behind(tmp_path):
    """A missing texture stops the export before any file is written."""
    path = sides.write(tmp_path, EVERYTHING)
    before = set(tmp_path.iterdir())
    done = run(path, "-o", tmp_path / "out.xml", cwd=tmp_path)
    assert done.returncode == 2 and "texture.png" in done.stderr
    assert set(tmp_path.iterdir()) == before


def test_interrupted_export_keeps_the_old_one(tmp_path, monkeypatch):
    """When a file cannot be written the XML and files that were there stay whole, and no temporary file stays."""
    from converters.mitsuba import as_xml

    loaded = prepare(tmp_path, EVERYTHING)
    path = tmp_path / "scene.xml"
    export.write_xml(loaded, path)
    before = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(as_xml, "write_png", full)
    with pytest.raises(OSError, match="No space"):
        export.write_xml(override(loaded, mode="albedo"), path)
    assert {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()} == before
