"""JSON text to validated description: every mistake reported at once, each with its place and in plain words.

A good file is parsed and read once. Only where something was found does the text get walked again for lines and
columns, and only then are strangers' spellings (aliases.py) translated and the file read a second time.
"""

from __future__ import annotations

import dataclasses
import gc
from pathlib import Path

from renderer.core.errors import Problem, SceneError, UsageError
from renderer.scene import checks, schema
from renderer.scene.findings import ERROR, IGNORED, NOTE, WARNING, Finding, nearest, quoted
from renderer.scene.loaded import LoadedScene
from renderer.scene.source import Source, message_of, parse, read_text

MAX_REPORTED = 100  # problems listed one by one; the rest are counted


def load(path, *, strict=False, mode=None):
    """Return the scene in the file at `path` as a LoadedScene; its warnings say what was ignored or translated.

    strict: whatever this version would ignore, drop or leave out is a mistake instead of a warning.
    mode: render mode that replaces the file's, which may then be one that this version does not have.
    Raises: SceneError with all problems; UsageError if `mode` is unknown.
    """
    source = Source(str(path), read_text(path))
    collects = gc.isenabled()
    gc.disable()  # a description has no cycles; looking for them doubles the time that large files take
    try:
        return _loaded(source, parse(source), Path(path).parent, strict, mode)
    finally:
        if collects:
            gc.enable()


def from_dict(document, *, directory=".", name="<scene>", strict=False, mode=None):
    """Return the LoadedScene of a scene given as parsed JSON, whose files lie in `directory`; see `load`.

    The document is not changed. Problems carry `name` as their file and no line.
    """
    return _loaded(Source(name, None), _copied(document), Path(directory), strict, mode)


def override(loaded, *, mode=None, width=None, height=None, samples=None, nbounces=None):
    """Return the scene with the given settings replaced; None keeps the scene's own.

    Raises: UsageError that names the setting, the value and what is allowed.
    """
    top, camera = schema.Scene.keys, schema.Camera.keys
    given = {"mode": (mode, top["rendermode"]), "width": (width, camera["width"]), "height": (height, camera["height"]),
             "samples": (samples, top["samples"]), "nbounces": (nbounces, top["nbounces"])}
    checked, complaints = {}, []
    for name, (value, key) in given.items():
        if value is not None:
            findings = []
            checked[name] = key.kind.read(value, None, findings)
            complaints += [f"{name}: {message_of(finding, None)}" for finding in findings]
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
    return LoadedScene(source.name, directory, description, tuple(kept), warnings, source)


def _described(source, document, mode):
    """Return the description (with None for its faulty parts) and the findings, translated where that is needed."""
    findings, own_mode = [], document.get("rendermode", "phong")
    if mode is not None:
        document = {**document, "rendermode": mode}
    description = schema.SCENE.read(document, None, findings)
    if not findings and (mode is None or own_mode in schema.RENDER_MODES):
        return description, findings
    from renderer.scene import aliases

    notes = aliases.translate(document, source)
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
