"""Random scenes: good ones load, spoilt ones are told with a place and nothing else goes wrong."""

import copy
import json
from pathlib import Path

import jsonschema
from hypothesis import given, settings
from hypothesis import strategies as st

from renderer.core.errors import SceneError
from renderer.scene import composed, reference, schema, values
from renderer.scene.loader import from_dict, load

SCENES = Path(__file__).resolve().parents[2] / "scenes"
ORIGINALS = [json.loads(path.read_text()) for path in sorted(SCENES.glob("*.json"))]


def of(kind):
    """Return a strategy for the values that a kind of value declares as good."""
    if isinstance(kind, values.Number):
        low, high = max(kind.low, -1e3), min(kind.high, 1e3)
        return st.floats(low, high, exclude_max=kind.high_open).filter(lambda x: not kind.low_open or x >= 1e-3)
    if isinstance(kind, values.Integer):
        return st.integers(kind.low, min(kind.high, 10_000))
    if isinstance(kind, values.Flag):
        return st.booleans()
    if isinstance(kind, values.Choice):
        return st.sampled_from(kind.names)
    if isinstance(kind, values.Vector):
        return st.lists(of(kind.item), min_size=kind.size, max_size=kind.size)
    if isinstance(kind, values.Factors):
        factor = st.floats(-1e3, 1e3).filter(lambda x: abs(x) >= 1e-3)
        return factor | st.lists(factor, min_size=3, max_size=3)
    if isinstance(kind, values.FileName):
        return st.sampled_from(["teapot.ply", "mesh.obj"])
    if isinstance(kind, values.Optional):
        return st.none() | of(kind.kind)
    if isinstance(kind, composed.Texturable):
        return of(kind.plain) | of(kind.texture).filter(lambda source: source is not None)
    if isinstance(kind, composed.Rows):
        return st.lists(of(kind.item), min_size=kind.least, max_size=kind.least + 4)
    if isinstance(kind, composed.TextureSource):
        return st.none() | of(kind.kinds)
    if isinstance(kind, composed.OneOf):
        return st.one_of([of(record) for record in kind.kinds.values()])
    return record(kind.node)


def record(made):
    """Return a strategy for documents of a record: its required keys and some of the others."""
    required = {name: of(key.kind) for name, key in made.keys.items() if key.required}
    optional = {name: of(key.kind) for name, key in made.keys.items() if not key.required}
    if made in schema.EXACTLY_ONE:
        names = schema.EXACTLY_ONE[made]
        others = {name: kind for name, kind in optional.items() if name not in names}
        return st.sampled_from(names).flatmap(
            lambda name: st.fixed_dictionaries(required | {name: optional[name]}, optional=others))
    return st.fixed_dictionaries(required, optional=optional)


SEMANTIC = ("must differ from position", "parallel", "must not be [0, 0, 0]", "must not have the normal",
            "dropped", "width times height", "mesh 'teapot.ply'",
            "mesh 'mesh.obj'", "must end in 0, 0, 0, 1", "must be invertible", "leads beyond", "no such file",
            "must not be greater than", "must be the only environment", "has no lens")


@settings(max_examples=60, deadline=None)
@given(record(schema.Scene))
def test_what_the_declarations_allow_loads(document):
    """Unless keys contradict each other, which is then said."""
    try:
        loaded = from_dict(document)
    except SceneError as error:
        assert all(any(word in problem.message for word in SEMANTIC) for problem in error.problems)
    else:
        assert from_dict(json.loads(json.dumps(document))) == loaded


def places(value, path=()):
    """Return the paths of everything in a document."""
    found = [path]
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for step, inner in items:
        found += places(inner, (*path, step))
    return found


ODD = st.sampled_from([
    None, True, False, 0, -1, 1.5, 10**30, -1e19, 1e-40, "", "phong", "sphere", "\ud800", "\0", [], [0, 0, 0], {},
    {"type": "sphere"}, {"type": "ambient", "intensity": 3}, {"type": "mesh"}, [[1]], [None], "x" * 200,
])
KEYS = st.sampled_from([
    "raduis", "lights", "objects", "look_at", "transparency", "hasTexture", "texturefile", "color", "type", "scene",
    "camera", "rendermode", "intensity", "material", "", "a b", "\n", "é", "Radius", "halfspaces", "position",
])


@st.composite
def spoilt(draw):
    """Return a shipped scene with a few values replaced, removed, added or renamed."""
    document = copy.deepcopy(draw(st.sampled_from(ORIGINALS)))
    for _ in range(draw(st.integers(1, 4))):
        path = draw(st.sampled_from(places(document)[1:] or [()]))
        if not path:
            break
        place = document
        for step in path[:-1]:
            place = place[step]
        how = draw(st.sampled_from(["replace", "remove", "add", "rename"]))
        if how == "replace":
            place[path[-1]] = copy.deepcopy(draw(ODD))
        elif how == "remove":
            del place[path[-1]]
        elif isinstance(place, dict):
            value = copy.deepcopy(draw(ODD)) if how == "add" else place.pop(path[-1])
            place[draw(KEYS)] = value
    return document


@settings(max_examples=300, deadline=None)
@given(document=spoilt(), strict=st.booleans(), indent=st.sampled_from([None, 1]))
def test_a_spoilt_scene_is_told_with_a_place_or_loads(tmp_path_factory, document, strict, indent):
    """Nothing but SceneError is raised, and every problem and warning has a place that lies in the file."""
    path = tmp_path_factory.getbasetemp() / "spoilt.json"
    text = json.dumps(document, indent=indent)
    path.write_text(text, encoding="utf-8")
    try:
        told = load(path, strict=strict).warnings
    except SceneError as error:
        told = error.problems
        assert told
    lines = text.split("\n")
    for problem in told:
        assert 1 <= problem.line <= len(lines)
        assert 1 <= problem.column <= len(lines[problem.line - 1])
        str(problem).encode("utf-8")


RULES = jsonschema.Draft202012Validator(json.loads(reference.schema_json()))
# what no single key shows; what is left out of other authors' files; and the range of float32, known by one end only
BEYOND_KEYS = (*SEMANTIC, "no such file", "exactly one of", "rendered by this version", "path tracer", "32-bit float")


@settings(max_examples=300, deadline=None)
@given(document=spoilt())
def test_a_library_agrees_about_spoilt_scenes(document):
    """jsonschema accepts what loads without a remark, and refuses where the loader finds a key that is wrong."""
    try:
        if not from_dict(copy.deepcopy(document), strict=True).warnings and '"hasTexture"' not in json.dumps(document):
            assert RULES.is_valid(document)
    except SceneError as error:
        if not all(any(words in problem.message for words in BEYOND_KEYS) for problem in error.problems):
            assert not RULES.is_valid(document)


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200) | st.text(max_size=100).map(str.encode)
       | st.tuples(st.integers(0, 700), st.binary(max_size=3)).map(
           lambda cut: json.dumps(ORIGINALS[0]).encode()[: cut[0]] + cut[1]))
def test_any_bytes_are_told_in_words(tmp_path_factory, content):
    """Whatever lies in the file, only SceneError is raised."""
    path = tmp_path_factory.getbasetemp() / "any.json"
    path.write_bytes(content)
    try:
        load(path)
    except SceneError as error:
        assert error.problems
