"""Kinds of JSON values that are made of others: lists, records, one of several records; see `values.py`."""

from __future__ import annotations

import marshal

from renderer.scene.findings import AT_KEY, AT_PARENT, ERROR, IGNORED, NOTHING, Finding, listed, nearest, quoted
from renderer.scene.values import FILE_NAME, Kind

MAX_SHARED = 4096  # different objects of one kind that are remembered


class Rows(Kind):
    """A list of any length from `least` on, of items of one kind."""

    def __init__(self, item, what, least=0):
        self.item, self.what, self.least = item, what, least

    def quick(self, value):
        if type(value) is not list and type(value) is not tuple or len(value) < self.least:
            return NOTHING
        made = tuple(map(self.item.quick, value))
        return NOTHING if NOTHING in made else made

    def explained(self, value, at, findings):
        if type(value) is not list and type(value) is not tuple:
            findings.append(Finding(at, f"must be a list of {self.what}", value))
            return None
        if len(value) < self.least:
            findings.append(Finding(at, f"must hold at least {self.least} {self.what}", value))
            return None
        read = self.item.read
        return tuple([read(entry, (at, index), findings) for index, entry in enumerate(value)])

    def words(self):
        return f"a list of {self.what}" + (f", at least {self.least}" if self.least else "")

    def json_schema(self):
        least = {"minItems": self.least} if self.least else {}
        return {"type": "array", "items": self.item.json_schema(), **least}


class Record(Kind):
    """An object with the declared keys of `made`, a class decorated by `nodes.node`.

    partial: after a mistake, return a record with None for what is missing, so that the rest can still be checked.
    shared: objects of equal text become one record, because files repeat them often.
    """

    def __init__(self, made, partial=False, shared=False):
        self.node, self.partial, self._known = made, partial, {} if shared else None
        self._quick = {name: key.kind.quick for name, key in made.keys.items()}
        self._absent = {name: value for name, value in made.defaults.items() if not made.keys[name].required}

    def quick(self, value):
        if self._known is None:
            return self._made(value)
        try:
            text = marshal.dumps(value, 2)  # tells 1 from 1.0 and true, as comparing does not
        except ValueError:  # something that is not in JSON files
            return self._made(value)
        found = self._known.get(text)
        if found is None:
            found = self._made(value)
            if found is not NOTHING:
                if len(self._known) >= MAX_SHARED:
                    self._known.clear()
                self._known[text] = found
        return found

    def _made(self, value):
        """Return the record of an object without any mistake or unknown key; else NOTHING."""
        if type(value) is not dict:
            return NOTHING
        quick, state = self._quick, self._absent.copy()
        for name, item in value.items():
            if name not in quick:
                return NOTHING
            made = quick[name](item)
            if made is NOTHING:
                return NOTHING
            state[name] = made
        return self.node.complete(state) if len(state) == len(quick) else NOTHING

    def read(self, value, at, findings):
        # What is partial holds lists of most of the file: one mistake in them must not have all of them read twice.
        return self.explained(value, at, findings) if self.partial else super().read(value, at, findings)

    def explained(self, value, at, findings):
        if type(value) is not dict:
            findings.append(Finding(at, f"must be an object {{...}} with the keys of {self.words()}", value))
            return None
        values, before, used = {}, len(findings), 0
        for name, key in self.node.keys.items():
            if name in value:
                used += 1
                values[name] = key.kind.read(value[name], (at, name), findings)
            elif key.required:
                findings.append(Finding((at, name), f"is missing; it is {key.kind.words()}", anchor=AT_PARENT))
        if used != len(value):
            self._unknown(value, at, findings)
        if len(findings) != before and any(finding.severity == ERROR for finding in findings[before:]):
            return self.node(**(dict.fromkeys(self.node.keys) | values)) if self.partial else None
        return self.node(**values)

    def _unknown(self, value, at, findings):
        """Remark on every key that nobody declared."""
        known = self.node.keys
        for name in value:
            if name not in known:
                message = f"unknown key{nearest(name, known)}"
                findings.append(Finding((at, name), message, anchor=AT_KEY, severity=IGNORED))

    def words(self):
        return f"a {self.node.__name__.lower()}"

    def json_schema(self):
        return {"$ref": f"#/$defs/{self.node.__name__}"}


class OneOf(Kind):
    """An object whose `type` names one of several records; `what` names the family in messages."""

    def __init__(self, what, kinds):
        self.what, self.kinds = what, kinds

    def quick(self, value):
        name = value.get("type") if type(value) is dict else None
        return self.kinds[name].quick(value) if type(name) is str and name in self.kinds else NOTHING

    def explained(self, value, at, findings):
        if type(value) is not dict:
            findings.append(Finding(at, f"must be a {self.what}: an object {{...}}", value))
            return None
        name = value.get("type", NOTHING)
        if name is NOTHING:
            message = f"is missing; a {self.what} is one of {listed(self.kinds)}"
            findings.append(Finding((at, "type"), message, anchor=AT_PARENT))
            return None
        if type(name) is not str:
            findings.append(Finding((at, "type"), f"must be one of {listed(self.kinds)}", name))
            return None
        record = self.kinds.get(name)
        if record is None:
            message = f"unknown {self.what} type {quoted(name)}{nearest(name, self.kinds)}"
            findings.append(Finding((at, "type"), f"{message} (known: {listed(self.kinds)})"))
            return None
        return record.read(value, at, findings)

    def words(self):
        return f"a {self.what}: one of {listed(self.kinds)}"

    def json_schema(self):
        return {"oneOf": [record.json_schema() for record in self.kinds.values()]}


class TextureSource(Kind):
    """A file name, a record by type, or null for none."""

    def __init__(self, kinds):
        self.kinds = kinds

    def quick(self, value):
        if type(value) is dict:
            return self.kinds.quick(value)
        return value if value is None else FILE_NAME.quick(value)

    def explained(self, value, at, findings):
        if type(value) is dict:
            return self.kinds.read(value, at, findings)
        findings.append(Finding(at, f"must be {self.words()}", value))
        return None

    def words(self):
        return f"a file name or an object with type {listed(self.kinds.kinds)}"

    def json_schema(self):
        return {"anyOf": [FILE_NAME.json_schema(), {"type": "null"}, self.kinds.json_schema()]}


class Texturable(Kind):
    """A plain value, or the texture that gives it at every point."""

    def __init__(self, plain, texture):
        self.plain, self.texture = plain, texture

    def quick(self, value):
        return self.texture.quick(value) if type(value) in (str, dict) else self.plain.quick(value)

    def explained(self, value, at, findings):
        if type(value) in (str, dict):
            return self.texture.read(value, at, findings)
        if type(value) in (int, float, list, tuple):
            return self.plain.read(value, at, findings)
        findings.append(Finding(at, f"must be {self.words()}", value))
        return None

    def words(self):
        return f"{self.plain.words()}, or {self.texture.words()}"

    def json_schema(self):
        return {"anyOf": [self.plain.json_schema(), *(kind for kind in self.texture.json_schema()["anyOf"]
                                                      if kind != {"type": "null"})]}
