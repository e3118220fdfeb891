"""Kinds of JSON values: how each is read, what it allows in words, and its JSON Schema.

A kind's `read(value, at, findings)` returns the checked value and appends a `Finding` for every mistake; it never
raises, so that one reading reports them all. `at` is a linked path `(parent path, key)` that costs one small tuple
on the way down and is spelt out only when there is something to report. Files of a hundred thousand shapes are read
by `quick`, which returns NOTHING for whatever is worth a finding, however small, and leaves that to `explained`. This
is our own because the usual validation libraries take a third of the time that a whole picture may take only to be
imported.

Plain values are here, what is made of them in `composed.py`.
"""

from __future__ import annotations

from renderer.scene.findings import NOTHING, Finding, listed, nearest, quoted

# float32 holds up to 3.4e38 and loses precision below 1.2e-38; rays are intersected with squares of lengths.
LARGEST, SMALLEST = 1e18, 1e-18


class Kind:
    """What may stand at a key: `quick` returns it checked, `explained` takes what `quick` found no plain good value."""

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


class Factors(Kind):
    """Three numbers that are not 0, or one number that stands for all three."""

    def __init__(self, item):
        self.vector = Vector(3, item, "factors [x, y, z]")

    def quick(self, value):
        made = self.vector.quick(value if type(value) in (list, tuple) else [value] * 3)
        return NOTHING if made is NOTHING or not all(abs(factor) >= SMALLEST for factor in made) else made

    def explained(self, value, at, findings):
        if type(value) in (list, tuple) and len(value) == 3:
            for index, factor in enumerate(value):
                self._explain_one(factor, (at, index), findings)
        elif type(value) in (int, float):
            self._explain_one(value, at, findings)
        else:
            findings.append(Finding(at, f"must be {self.words()}", value))
        return None

    def _explain_one(self, factor, at, findings):
        self.vector.item.read(factor, at, findings)
        if factor == 0 and type(factor) in (int, float):
            findings.append(Finding(at, "must not be 0, which would make everything flat", factor))
        elif type(factor) is float and abs(factor) < SMALLEST:
            message = f"must be at least {SMALLEST:g} in size, because its square must not vanish in a 32-bit float"
            findings.append(Finding(at, message, factor))

    def words(self):
        return "a number other than 0, or three of them [x, y, z]"

    def json_schema(self):
        item = {**self.vector.item.json_schema(), "not": {"const": 0}}
        return {"anyOf": [item, {"type": "array", "items": item, "minItems": 3, "maxItems": 3}]}


class FileName(Kind):
    """The name of a file."""

    def quick(self, value):
        return value if type(value) is str and value and "\0" not in value else NOTHING

    def explained(self, value, at, findings):
        findings.append(Finding(at, f"must be {self.words()}", value))
        return None

    def words(self):
        return "a file name"

    def json_schema(self):
        return {"type": "string", "minLength": 1}


FILE_NAME = FileName()


class Optional(Kind):
    """What another kind reads, or null, which is the same as leaving the key out."""

    def __init__(self, kind):
        self.kind = kind

    def quick(self, value):
        return value if value is None else self.kind.quick(value)

    def explained(self, value, at, findings):
        return self.kind.read(value, at, findings)

    def words(self):
        return self.kind.words()

    def json_schema(self):
        return {"anyOf": [self.kind.json_schema(), {"type": "null"}]}
