"""The text of a scene file: read, parsed as strict JSON, and asked for the places of what was found in it."""

from __future__ import annotations

import json
import os
from pathlib import Path

from renderer.core.errors import Problem, SceneError
from renderer.scene.findings import AT_KEY, AT_PARENT, NOTE, NOTHING, Finding, linked, nearest_file, quoted, spelt_out

MAX_FILE = 2**29  # bytes; more is certainly not a scene description


class Source:
    """The name and text of a scene file, and the translation of findings about it into problems."""

    def __init__(self, name, text):
        self.name, self.text = name, text
        self.moved = {}  # path in the translated document: path in the file

    def original(self, path):
        """Return the path in the file of a path in the translated document."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.moved:
                return self.moved[path[:length]] + path[length:]
        return path

    def problems(self, findings):
        """Return the findings as problems in the order of the text."""
        paths = [spelt_out(finding.at) for finding in findings]
        paths = [path if finding.as_written else self.original(path)
                 for finding, path in zip(findings, paths, strict=True)]
        found = self._places(paths)
        told = []
        for finding, path in zip(findings, paths, strict=True):
            place, token = self._nearest_place(finding, path, found)
            line, column = self.line_and_column(place) if place is not None else (0, 0)
            message, is_note = message_of(finding, token), finding.severity == NOTE
            told.append(Problem(self.name, message, key_path(path), line, column, is_note))
        order = sorted(range(len(told)), key=lambda index: (told[index].line, told[index].column))
        return tuple(told[index] for index in order)

    def problem(self, message, *keys):
        """Return a problem at a path of the file itself, for what is found only when the scene is used."""
        return self.problems([Finding(linked(keys), message, as_written=True)])[0]

    def _places(self, paths):
        if self.text is None:
            return {}
        from renderer.scene import locate

        return locate.places(self.text, {path[:length] for path in paths for length in range(len(path) + 1)})

    @staticmethod
    def _nearest_place(finding, path, found):
        """Return the offset that the finding points to and the token that stands there as its value."""
        exact = found.get(path)
        if exact is not None and finding.anchor != AT_PARENT:
            return (exact.key if finding.anchor == AT_KEY else exact.start), exact.token
        for length in range(len(path) - 1, -1, -1):  # what is missing is reported where it should have been
            if path[:length] in found:
                return found[path[:length]].start, None
        return None, None

    def line_and_column(self, offset):
        from renderer.scene import locate

        return locate.line_and_column(self.text, offset)


def key_path(path):
    """Return a path in the form `scene.shapes[3].radius`."""
    told = ""
    for step in path:
        if isinstance(step, int):
            told += f"[{step}]"
        elif step.isidentifier():
            told += f".{step}" if told else step
        else:
            told += f"[{quoted(step)}]"
    return told


def message_of(finding, token):
    """Return the finding's message, with the value found as the user wrote it."""
    if finding.value is NOTHING:
        return finding.message
    return f"{finding.message}, got {_shown(finding.value, token)}"


def _shown(value, token):
    """Return a value of the file in a few words."""
    if value is None or value is True or value is False:
        return json.dumps(value)
    if type(value) is dict:
        return "an object" if value else "an empty object"
    if type(value) in (list, tuple):
        return f"a list of {len(value)} value{'' if len(value) == 1 else 's'}"
    if type(value) is str:
        return "an empty text" if not value else f"the text {quoted(value)}"
    text = token if token is not None and token not in "{[" else repr(value)
    return text if len(text) <= 40 else f"{text[:30]}... ({len(text)} characters)"


def read_text(path):
    """Return the text of the file. Raises: SceneError in the words of the file system's trouble."""
    name = str(path)
    try:
        if os.path.isdir(path):
            raise SceneError(Problem(name, "is a directory; name a scene file (JSON) in it"))
        with open(path, "rb") as file:
            data = file.read(MAX_FILE + 1)
    except FileNotFoundError:
        raise SceneError(Problem(name, f"no such file{nearest_file(path)} (tried {Path(path).absolute()})")) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise SceneError(Problem(name, f"cannot be read: {reason}")) from None
    if len(data) > MAX_FILE:
        raise SceneError(Problem(name, f"is larger than {MAX_FILE >> 20} MiB; that is no scene file"))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        start = data.rfind(b"\n", 0, error.start) + 1
        column = len(data[start : error.start].decode("utf-8", "replace")) + 1
        message = f"is not UTF-8 text (byte 0x{data[error.start]:02x}); save it as UTF-8"
        raise SceneError(Problem(name, message, "", data.count(b"\n", 0, error.start) + 1, column)) from None


def parse(source):
    """Return the document in the text. Raises: SceneError for what is not JSON, or only almost."""
    odd = []

    def members(pairs):
        table = dict(pairs)
        if len(table) != len(pairs):
            odd.append("repeated")
        return table

    if not source.text.strip():
        raise SceneError(Problem(source.name, "is empty; a scene file holds a JSON object {...}"))
    try:
        document = json.loads(source.text, object_pairs_hook=members, parse_constant=odd.append)
    except json.JSONDecodeError as error:
        message = f"is not JSON: {_plainly(error, source.text)}"
        raise SceneError(Problem(source.name, message, "", error.lineno, error.colno)) from None
    except RecursionError:
        raise SceneError(_placed(source, "is nested too deeply for a scene file", "deepest")) from None
    except ValueError:  # Python refuses to convert whole numbers of more than 4300 digits
        raise SceneError(_placed(source, "holds a number with thousands of digits", "longest_number")) from None
    if odd:
        raise SceneError(*_oddities(source))
    return document


def _placed(source, message, search):
    """Return a problem of the whole text at the offset that the named function of `locate` finds."""
    from renderer.scene import locate

    return Problem(source.name, message, "", *source.line_and_column(getattr(locate, search)(source.text)))


def _oddities(source):
    """Return problems for what Python's parser lets through though JSON does not: NaN, Infinity, repeated keys."""
    from renderer.scene import locate

    told = [(offset, path, "this key is given twice") for path, offset in locate.repeated_keys(source.text)]
    told += [(offset, path, f"{token} is not a number that JSON knows; write a finite one")
             for path, token, offset in locate.non_numbers(source.text)]
    return [Problem(source.name, message, key_path(path), *source.line_and_column(offset))
            for offset, path, message in sorted(told)]


SYNTAX = {
    "Expecting value": "a value is expected here",
    "Expecting ',' delimiter": "a comma (or the closing bracket) is expected here",
    "Expecting ':' delimiter": "a colon is expected here",
    "Expecting property name enclosed in double quotes": "a key in double quotes is expected here",
    "Unterminated string starting at": "this text has no closing quote",
    "Extra data": "the document has ended before this",
}


NOT_IN_JSON = {"'": "JSON has double quotes only"}
NOT_IN_JSON |= dict.fromkeys("TFN", "JSON writes true, false and null in lower case")


def _plainly(error, text):
    """Return a JSON syntax error in plain words."""
    said = SYNTAX.get(error.msg, error.msg[:1].lower() + error.msg[1:])
    before = text[: error.pos].rstrip()
    if error.pos >= len(text.rstrip()):
        return f"{said}, but the file ends"
    if before.endswith(",") and text[error.pos] in "}]":
        return f"{said}; the comma before it is one too many"
    found = text[error.pos]
    if error.msg.startswith("Expecting") and text.startswith(("//", "/*", "#"), error.pos):
        return f"{said}; JSON has no comments"
    if error.msg == "Expecting value" and found in NOT_IN_JSON:
        return f"{said}; {NOT_IN_JSON[found]}"
    return f"{said}, found {quoted(found)}" if error.msg.startswith("Expecting") else said
