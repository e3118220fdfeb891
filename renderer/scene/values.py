"""Kinds of JSON values: how each is read, what it allows in words, and its JSON Schema.

A kind's `read(value, at, findings)` returns the checked value and appends a `Finding` for every mistake; it never
raises, so that one reading reports them all. `at` is a linked path `(parent path, key)` that costs one small tuple
on the way down and is spelt out only when there is something to report. Files of a hundred thousand shapes are read
by `quick`, which returns NOTHING for whatever is worth a finding, however small, and leaves that to `explained`:
each kind has its rule once, in `quick`. This is our own because the usual validation
libraries take a third of the time that a whole picture may take only to be imported.
"""

from __future__ import annotations

import marshal

from renderer.scene.findings import (
    AT_KEY, AT_PARENT, ERROR, IGNORED, NOTHING, Finding, listed, nearest, quoted,
)

# float32 holds up to 3.4e38 and loses precision below 1.2e-38; rays are intersected with squares of lengths.
LARGEST, SMALLEST = 1e18, 1e-18
MAX_SHARED = 4096  # different objects of one kind that are remembered


class Kind:
    """What may stand at a key: `quick(value)` returns it checked, `explained` what `quick` found no plain good value."""

    def read(self, value, at, findings):
        made = self.quick(value)
        return self.explained(value, at, findings) if made is NOTHING else made


class Number(Kind):
    """A real number with `low <= x <= high` (`low < x` and `x < high` where open)."""

    def __init__(self, low=-LARGEST, high=LARGEST, low_open=False, high_open=False):
        self.low, self.high, self.low_open, self.high_open = low, high, low_open, high_open

    def quick(self, value):
        kind = type(value)
        if (kind is float or kind is int) and self.low <= value <= self.high:
            if not (self.low_open and value < SMALLEST or self.high_open and value == self.high):
                return float(value)
        return NOTHING

    def explained(self, value, at, findings):
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


class Integer(Kind):
    """A whole number from `low` to `high`; 8.0 counts as 8, because writers of JSON differ about it."""

    def __init__(self, low, high):
        self.low, self.high = low, high

    def quick(self, value):
        kind = type(value)
        if kind is int and self.low <= value <= self.high:
            return value
        if kind is float and self.low <= value <= self.high and value == int(value):
            return int(value)
        return NOTHING

    def explained(self, value, at, findings):
        numeric = type(value) is int or type(value) is float and value.is_integer()
        wanted = self.range() if numeric else self.words()
        findings.append(Finding(at, f"must be {wanted}", value))
        return None

    def range(self):
        return f"between {self.low} and {self.high}"

    def words(self):
        return f"a whole number {self.range()}"

    def json_schema(self):
        return {"type": "integer", "minimum": self.low, "maximum": self.high}


class Flag(Kind):
    """true or false."""

    def quick(self, value):
        return value if value is True or value is False else NOTHING

    def explained(self, value, at, findings):
        findings.append(Finding(at, "must be true or false", value))
        return None

    def words(self):
        return "true or false"

    def json_schema(self):
        return {"type": "boolean"}


class Choice(Kind):
    """One of a few words; `what` names the family in messages."""

    def __init__(self, what, names):
        self.what, self.names = what, names

    def quick(self, value):
        return value if type(value) is str and value in self.names else NOTHING

    def explained(self, value, at, findings):
        if type(value) is str:
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


class Vector(Kind):
    """`size` numbers of one kind; `what` says what they are together. Bounds of `item` must be closed ones."""

    def __init__(self, size, item, what):
        self.size, self.item, self.what = size, item, what

    def quick(self, value):
        if type(value) is not list and type(value) is not tuple or len(value) != self.size:
            return NOTHING
        low, high, out = self.item.low, self.item.high, ()
        for number in value:
            if type(number) is not float:
                if type(number) is not int:
                    return NOTHING
                number = float(number) if -LARGEST <= number <= LARGEST else LARGEST * 2
            if not low <= number <= high:
                return NOTHING
            out += (number,)
        return out

    def explained(self, value, at, findings):
        if type(value) is not list and type(value) is not tuple or len(value) != self.size:
            findings.append(Finding(at, f"must be {self.words()}", value))
            return None
        return tuple(self.item.read(number, (at, index), findings) for index, number in enumerate(value))

    def words(self):
        inner = self.item.range()
        return f"{self.what}: {self.size} numbers" + (f", each {inner}" if inner else "")

    def json_schema(self):
        return {"type": "array", "items": self.item.json_schema(), "minItems": self.size, "maxItems": self.size}


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
        return value if value is None or type(value) is str and value and "\0" not in value else NOTHING

    def explained(self, value, at, findings):
        if type(value) is dict:
            return self.kinds.read(value, at, findings)
        findings.append(Finding(at, f"must be {self.words()}", value))
        return None

    def words(self):
        return f"a file name or an object with type {listed(self.kinds.kinds)}"

    def json_schema(self):
        return {"anyOf": [{"type": "string", "minLength": 1}, {"type": "null"}, self.kinds.json_schema()]}
