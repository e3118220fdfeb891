"""Finds the places of key paths in JSON text. Runs only once there is something to report.

The standard parser forgets where values stood. This walks the text's tokens again with an explicit stack, so that
nesting cannot exhaust Python's. The text is known to be valid JSON, except that NaN and Infinity are let through
to be complained about.
"""

from __future__ import annotations

import re
from typing import NamedTuple

TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\]:,]|[^\s{}\[\]:,"]+', re.DOTALL)
NOT_NUMBERS = ("NaN", "Infinity", "-Infinity")


class Place(NamedTuple):
    """Where a value stands: offsets of its key (or of itself, where it has none) and of its first token."""

    key: int
    start: int
    token: str


def line_and_column(text, offset):
    """Return line and column of an offset, both from 1, in characters."""
    line_start = text.rfind("\n", 0, offset) + 1
    return text.count("\n", 0, offset) + 1, offset - line_start + 1


def walk(text):
    """Yield `(is_key, steps, token, offset)` for every key and every value's first token, in the text's order.

    `steps` is the path to it, a list that changes as the walk goes on.
    """
    steps, objects, expects_key = [], [], False
    for match in TOKEN.finditer(text):
        token = match.group()
        if token == ",":
            expects_key = objects[-1]
            if not expects_key:
                steps[-1] += 1
        elif token == "}" or token == "]":
            steps.pop()
            objects.pop()
            expects_key = False
        elif expects_key:
            steps[-1], expects_key = _string(token), False
            yield True, steps, token, match.start()
        elif token != ":":
            yield False, steps, token, match.start()
            if token == "{" or token == "[":
                expects_key = token == "{"
                objects.append(expects_key)
                steps.append(None if expects_key else 0)


def _string(token):
    """Return what a string token says."""
    if "\\" not in token:
        return token[1:-1]
    import json

    return json.loads(token, strict=False)


def places(text, paths):
    """Return {path: Place} for those of `paths` (tuples of keys and indices) that the text has.

    Where a key is given twice, the last one counts, as it does for the parser.
    """
    wanted, keys, found = set(paths), {}, {}
    for is_key, steps, token, offset in walk(text):
        path = tuple(steps)
        if path in wanted:
            if is_key:
                keys[path] = offset
            else:
                found[path] = Place(keys.get(path, offset), offset, token)
    return found


def repeated_keys(text):
    """Return `(path, offset)` for every key that its object already had, outermost ones only."""
    seen, twice = set(), {}
    for is_key, steps, _, offset in walk(text):
        path = tuple(steps)
        if is_key:
            if path in seen and not any(path[:length] in twice for length in range(1, len(path))):
                twice[path] = offset
            seen.add(path)
    return list(twice.items())


def non_numbers(text):
    """Return `(path, token, offset)` for every NaN and Infinity that stands for a value."""
    return [(tuple(steps), token, offset) for is_key, steps, token, offset in walk(text) if token in NOT_NUMBERS]


def deepest(text):
    """Return the offset of the first bracket that is nested more deeply than any other; works on any text."""
    depth, most, place = 0, -1, 0
    for match in TOKEN.finditer(text):
        token = match.group()
        if token in ("{", "["):
            depth += 1
            if depth > most:
                most, place = depth, match.start()
        elif token in ("}", "]"):
            depth -= 1
    return place


def longest_number(text):
    """Return the offset of the longest run of digits."""
    return max((match for match in re.finditer(r"\d+", text)), key=lambda match: len(match.group())).start()
