"""JSON text to validated description: every mistake reported at once, each with its place and in plain words.

A good file is parsed and read once. Only where something was found does the text get walked again for lines and
columns, and only then are strangers' spellings (aliases.py) translated and the file read a second time.
"""

from __future__ import annotations

import dataclasses
import json
import os
from pathlib import Path

from renderer.core.errors import Problem, SceneError, UsageError
from renderer.scene import checks, schema
from renderer.scene.loaded import LoadedScene
from renderer.scene.values import (
    AT_KEY, AT_PARENT, ERROR, IGNORED, NOTE, NOTHING, WARNING, Finding, nearest, quoted, spelt_out,
)

MAX_FILE = 2**29  # bytes; more is certainly not a scene description
MAX_REPORTED = 100  # problems listed one by one; the rest are counted
OVERRIDES = ("mode", "width", "height", "samples", "nbounces")


def load(path, *, strict=False, mode=None):
    """Return the scene in the file at `path` as a LoadedScene; its warnings say what was ignored or translated.

    strict: whatever this version would ignore, drop or leave out is a mistake instead of a warning.
    mode: render mode that replaces the file's, which may then be one that this version does not have.
    Raises: SceneError with all problems; UsageError if `mode` is unknown.
    """
    source = Source(str(path), _text(path))
    return _loaded(source, _parsed(source), Path(path).parent, strict, mode)


def from_dict(document, *, directory=".", name="<scene>", strict=False, mode=None):
    """Return the LoadedScene of a scene given as parsed JSON, whose files lie in `directory`; see `load`.

    The document is not changed. Problems carry `name` as their file and no line.
    """
    return _loaded(Source(name, None), _copied(document), Path(directory), strict, mode)


def override(loaded, *, mode=None, width=None, height=None, samples=None, nbounces=None):
    """Return the scene with the given settings replaced; None keeps the scene's own.

    Raises: UsageError that names the setting, the value and what is allowed.
    """
    given = dict(zip(OVERRIDES, (mode, width, height, samples, nbounces), strict=True))
    top, camera = schema.Scene.keys, schema.Camera.keys
    kinds = {"mode": top["rendermode"], "width": camera["width"], "height": camera["height"]}
    kinds |= {"samples": top["samples"], "nbounces": top["nbounces"]}
    checked, complaints = {}, []
    for name, value in given.items():
        if value is not None:
            findings = []
            checked[name] = kinds[name].kind.read(value, None, findings)
            complaints += [f"{name}: {_message(finding, None)}" for finding in findings]
    if complaints:
        raise UsageError("\n".join(complaints))
    return _with_settings(loaded, checked)


def _with_settings(loaded, settings):
    """Return the scene with checked settings in place of its own."""
    description = loaded.description
    sizes = {name: settings[name] for name in ("width", "height") if name in settings}
    camera = dataclasses.replace(description.camera, **sizes)
    if camera.width * camera.height > schema.MAX_PIXELS:
        raise UsageError(checks.too_many_pixels(camera.width, camera.height))
    top = {name: settings[name] for name in ("samples", "nbounces") if name in settings}
    if "mode" in settings:
        top["rendermode"] = settings["mode"]
    description = dataclasses.replace(description, camera=camera, **top)
    return dataclasses.replace(loaded, description=description)


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
            told.append(Problem(self.name, _message(finding, token), key_path(path), line, column))
        order = sorted(range(len(told)), key=lambda index: (told[index].line, told[index].column))
        return tuple(told[index] for index in order)

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


def _message(finding, token):
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
    text = token if token is not None and token not in "{[" else str(value) if type(value) is float else f"{value:d}"
    return text if len(text) <= 40 else f"{text[:30]}... ({len(text)} characters)"


def _text(path):
    """Return the text of the file. Raises: SceneError in the words of the file system's trouble."""
    name = str(path)
    try:
        if os.path.isdir(path):
            raise SceneError(Problem(name, "is a directory; name a scene file (JSON) in it"))
        with open(path, "rb") as file:
            data = file.read(MAX_FILE + 1)
    except FileNotFoundError:
        raise SceneError(Problem(name, f"no such file (tried {Path(path).absolute()})")) from None
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


def _parsed(source):
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
    return f"{said}, found {quoted(found)}" if error.msg.startswith("Expecting") else said


def _copied(document):
    """Return a copy of nested lists and objects: translation works in place."""
    if isinstance(document, dict):
        return {name: _copied(value) for name, value in document.items()}
    if isinstance(document, (list, tuple)):
        return [_copied(value) for value in document]
    return document


def _loaded(source, document, directory, strict, mode):
    """Return the LoadedScene of a parsed document. Raises: SceneError with all problems."""
    if mode is not None and mode not in schema.RENDER_MODES:
        known = ", ".join(schema.RENDER_MODES)
        raise UsageError(f"mode: unknown mode {quoted(mode)}{nearest(mode, schema.RENDER_MODES)} (known: {known})")
    if type(document) is not dict:
        message = "must be an object {...} with the keys camera and scene"
        raise SceneError(*source.problems([Finding(None, message, document)]))
    description, findings = _described(source, document, mode)
    kept = checks.check(description, directory, findings)
    findings = _gathered(findings)
    worst = (ERROR, WARNING, IGNORED) if strict else (ERROR,)
    if any(finding.severity in worst for finding in findings):
        raise SceneError(*_shortened(source, findings))
    for finding in findings:
        if finding.severity == IGNORED:
            finding.message += " (ignored)"
    if source.moved:
        kept = [(source.original(("scene", "shapes", index))[-1], shape) for index, shape in kept]
    warnings = source.problems(findings) if findings else ()
    return LoadedScene(source.name, directory, description, tuple(kept), warnings)


def _described(source, document, mode):
    """Return the description (with None for its faulty parts) and the findings, translated where that is needed."""
    findings, own_mode = [], document.get("rendermode", "phong")
    if mode is not None:
        document = {**document, "rendermode": mode}
    description = schema.SCENE.read(document, None, findings)
    if not findings and (mode is None or own_mode in schema.RENDER_MODES):
        return description, findings
    from renderer.scene import aliases

    notes = aliases.translate(document, source.moved)
    if mode is not None:
        notes += aliases.replaced_mode(own_mode, mode)
    findings = []
    description = schema.SCENE.read(document, None, findings)
    return description, findings + notes


def _gathered(findings):
    """Return the findings with remarks that differ only in their place told once, with their count."""
    told, kept = {}, []
    for finding in findings:
        last = finding.at[1] if finding.at else None
        group = (finding.severity, finding.message, last if type(last) is str else None)
        if finding.severity == ERROR or group not in told:
            told[group] = [finding, 1]
            kept.append(finding)
        else:
            told[group][1] += 1
    for finding, count in told.values():
        if count > 1:
            finding.message += f" (here and in {count - 1} more place{'' if count == 2 else 's'})"
    return kept


def _shortened(source, findings):
    """Return the problems of a scene that is refused: mistakes, and what was ignored as it may explain them."""
    problems = source.problems([finding for finding in findings if finding.severity != NOTE])
    if len(problems) <= MAX_REPORTED:
        return problems
    more = len(problems) - MAX_REPORTED
    return *problems[:MAX_REPORTED], Problem(source.name, f"and {more} more problems in this file")
