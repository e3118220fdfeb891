"""Places of key paths in JSON text, against the standard parser."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderer.scene import locate

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(alphabet=st.characters(codec="utf-8")) | st.sampled_from(['"', "\\", '{"a": [1]}', ",:", "\\u0041"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
    max_leaves=20,
)


def leaves(value, path=()):
    """Yield (path, value) of a document and of everything in it."""
    yield path, value
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for step, inner in items:
        yield from leaves(inner, (*path, step))


@given(VALUES, st.sampled_from([None, 0, 1, 3]), st.booleans())
def test_every_place_holds_its_value(document, indent, ascii_only):
    """Whatever the layout and the escapes, decoding at the place found gives the value of the path."""
    text = json.dumps(document, indent=indent, ensure_ascii=ascii_only)
    wanted = dict(leaves(document))
    found = locate.places(text, wanted)
    assert found.keys() == wanted.keys()
    for path, place in found.items():
        assert json.JSONDecoder().raw_decode(text, place.start)[0] == wanted[path]
        if path and isinstance(path[-1], str):
            assert json.JSONDecoder().raw_decode(text, place.key)[0] == path[-1]


@given(VALUES)
def test_no_key_is_repeated_in_what_the_parser_wrote(document):
    """Equal keys of different objects are no repetition."""
    assert locate.repeated_keys(json.dumps(document)) == []


def test_the_last_of_repeated_keys_is_located():
    """It is the one that the parser takes."""
    assert locate.places('{"a": 1, "a": 2}', [("a",)])[("a",)].token == "2"


@pytest.mark.parametrize(("offset", "place"), [(0, (1, 1)), (2, (1, 3)), (3, (2, 1)), (8, (3, 2)), (9, (3, 3))])
def test_line_and_column_count_from_one(offset, place):
    """A line ends with its line break, also a Windows one."""
    assert locate.line_and_column("ab\nde\r\nfgh", offset) == place


def test_deep_nesting_does_not_exhaust_the_stack():
    """The walk has its own stack."""
    depth = 100_000
    assert locate.deepest("[" * depth + "]" * depth) == depth - 1
    assert locate.non_numbers("[" * depth + "NaN" + "]" * depth)[0][1:] == ("NaN", depth)
