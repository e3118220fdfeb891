"""Kinds of JSON values: how each is read, what it allows in words, and its JSON Schema.

A kind's `read(value, at, findings)` returns the checked value and appends a `Finding` for every mistake; it never
raises, so that one reading reports them all. `at` is a linked path `(parent path, key)` that costs one small tuple
on the way down and is spelt out only when there is something to report. This is our own because the usual validation
libraries take a third of the time that a whole picture may take only to be imported.
"""

from __future__ import annotations

from renderer.scene.findings import (
    AT_KEY, AT_PARENT, ERROR, IGNORED, NOTHING, Finding, listed, nearest, quoted,
)

# float32 holds up to 3.4e38 and loses precision below 1.2e-38; rays are intersected with squares of lengths.
LARGEST, SMALLEST = 1e18, 1e-18


class Number:
    """A real number with `low <= x <= high` (`low < x` and `x < high` where open)."""

    def __init__(self, low=-LARGEST, high=LARGEST, low_open=False, high_open=False):
        self.low, self.high, self.low_open, self.high_open = low, high, low_open, high_open

    def read(self, value, at, findings):
        kind = type(value)
        if (kind is float or kind is int) and self.low <= value <= self.high:
            if not (self.low_open and value < SMALLEST or self.high_open and value == self.high):
                return float(value)
        findings.append(Finding(at, self._complaint(value), value))
        return None

    def _complaint(self, value):
        """Return what is wrong with `value`, preferring the bound that it breaks."""
        if type(value) not in (int, float):
            return f"must be {self.words()}"
        if value != value or value in (float("inf"), float("-inf")):
            return "must be a finite number"
        if abs(value) > LARGEST == self.high and not self.low >= 0 > value:
            return f"must not be beyond {LARGEST:g} in size, because its square must fit a 32-bit float"
        if self.low_open and 0 < value < SMALLEST:
            return f"must be at least {SMALLEST:g}, because its square must not vanish in a 32-bit float"
        return f"must be {self.range()}"

    def range(self):
        """Return the allowed range in words; empty where only float32's own limits apply."""
        bounds = []
        if self.low > -LARGEST:
            bounds.append(f"{'greater than' if self.low_open else 'at least'} {self.low:g}")
        if self.high < LARGEST:
            bounds.append(f"{'less than' if self.high_open else 'at most'} {self.high:g}")
        if len(bounds) == 2 and not (self.low_open or self.high_open):
            return f"between {self.low:g} and {self.high:g}"
        return " and ".join(bounds)

    def words(self):
        return " ".join(filter(None, ("a number", self.range())))

    def json_schema(self):
        bounds = {"exclusiveMinimum" if self.low_open else "minimum": self.low}
        bounds["exclusiveMaximum" if self.high_open else "maximum"] = self.high
        return {"type": "number", **bounds}


class Integer:
    """A whole number from `low` to `high`; 8.0 counts as 8, because writers of JSON differ about it."""

    def __init__(self, low, high):
        self.low, self.high = low, high

    def read(self, value, at, findings):
        kind = type(value)
        if kind is int and self.low <= value <= self.high:
            return value
        if kind is float and self.low <= value <= self.high and value == int(value):
            return int(value)
        numeric = kind is int or kind is float and value.is_integer()
        wanted = self.range() if numeric else self.words()
        findings.append(Finding(at, f"must be {wanted}", value))
        return None

    def range(self):
        return f"between {self.low} and {self.high}"

    def words(self):
        return f"a whole number {self.range()}"

    def json_schema(self):
        return {"type": "integer", "minimum": self.low, "maximum": self.high}


class Flag:
    """true or false."""

    def read(self, value, at, findings):
        if value is True or value is False:
            return value
        findings.append(Finding(at, "must be true or false", value))
        return None

    def words(self):
        return "true or false"

    def json_schema(self):
        return {"type": "boolean"}


class Choice:
    """One of a few words; `what` names the family in messages."""

    def __init__(self, what, names):
        self.what, self.names = what, names

    def read(self, value, at, findings):
        if type(value) is str:
            if value in self.names:
                return value
            message = f"unknown {self.what} {quoted(value)}{nearest(value, self.names)}"
            findings.append(Finding(at, f"{message} (known: {listed(self.names)})"))
        else:
            findings.append(Finding(at, f"must be {self.words()}", value))
        return None

    def words(self):
        names = listed(f'"{name}"' for name in self.names)
        return names if len(self.names) == 1 else f"one of {names}"

    def json_schema(self):
        return {"const": self.names[0]} if len(self.names) == 1 else {"enum": list(self.names)}


class Vector:
    """`size` numbers of one kind; `what` says what they are together. Bounds of `item` must be closed ones."""

    def __init__(self, size, item, what):
        self.size, self.item, self.what = size, item, what

    def read(self, value, at, findings):
        if type(value) is not list and type(value) is not tuple or len(value) != self.size:
            findings.append(Finding(at, f"must be {self.words()}", value))
            return None
        low, high, out = self.item.low, self.item.high, []
        for index, number in enumerate(value):
            kind = type(number)
            if (kind is float or kind is int) and low <= number <= high:
                out.append(float(number))
            else:
                self.item.read(number, (at, index), findings)
        return tuple(out)

    def words(self):
        inner = self.item.range()
        return f"{self.what}: {self.size} numbers" + (f", each {inner}" if inner else "")

    def json_schema(self):
        return {"type": "array", "items": self.item.json_schema(), "minItems": self.size, "maxItems": self.size}


class Rows:
    """A list of any length from `least` on, of items of one kind."""

    def __init__(self, item, what, least=0):
        self.item, self.what, self.least = item, what, least

    def read(self, value, at, findings):
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


class Record:
    """An object with the declared keys of `made`, a class decorated by `nodes.node`.

    partial: after a mistake, return a record with None for what is missing, so that the rest can still be checked.
    """

    def __init__(self, made, partial=False):
        self.node, self.partial = made, partial

    def read(self, value, at, findings):
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


class OneOf:
    """An object whose `type` names one of several records; `what` names the family in messages."""

    def __init__(self, what, kinds):
        self.what, self.kinds = what, kinds

    def read(self, value, at, findings):
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


class TextureSource:
    """A file name, a record by type, or null for none."""

    def __init__(self, kinds):
        self.kinds = kinds

    def read(self, value, at, findings):
        if type(value) is dict:
            return self.kinds.read(value, at, findings)
        if value is None or type(value) is str and value and "\0" not in value:
            return value
        findings.append(Finding(at, f"must be {self.words()}", value))
        return None

    def words(self):
        return f"a file name or an object with type {listed(self.kinds.kinds)}"

    def json_schema(self):
        return {"anyOf": [{"type": "string", "minLength": 1}, {"type": "null"}, self.kinds.json_schema()]}
