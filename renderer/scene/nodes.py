"""Records: plain frozen data whose keys are declared with their kind, default, unit and sentence."""

from __future__ import annotations

import dataclasses

from renderer.scene.findings import NOTHING, listed


class Key:
    """A declared key: its kind, whether a file must have it, its default, unit and sentence."""

    def __init__(self, kind, description, unit, required, default):
        self.kind, self.description, self.unit = kind, description, unit
        self.required, self.default = required, default


def key(kind, description, *, default=NOTHING, unit="", required=None):
    """Return the declaration of one key; without a default, a file must have it."""
    required = default is NOTHING if required is None else required
    metadata = {"key": Key(kind, description, unit, required, None if default is NOTHING else default)}
    if default is NOTHING:
        return dataclasses.field(metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


class Node:
    """Base of the records: frozen, compared by value, made with keywords only.

    Written out rather than generated for each record, because generating costs half a millisecond a record at every
    start. `dataclasses.fields`, `replace` and `asdict` work on records.
    """

    keys, defaults = {}, {}  # name: Key; name: default of what may be absent

    def __init__(self, **values):
        state = self.__dict__
        state.update(self.defaults)
        state.update(values)
        if len(state) != len(self.keys):
            odd = listed(sorted(state.keys() ^ self.keys.keys()))
            raise TypeError(f"{type(self).__name__}: missing or unknown: {odd}")

    @classmethod
    def complete(cls, state):
        """Return the record of a dictionary with all keys, which becomes the record's own."""
        made = cls.__new__(cls)
        object.__setattr__(made, "__dict__", state)
        return made

    def __setattr__(self, name, value):
        raise dataclasses.FrozenInstanceError(f"cannot assign to {name}")

    def __delattr__(self, name):
        raise dataclasses.FrozenInstanceError(f"cannot delete {name}")

    def __eq__(self, other):
        return self.__dict__ == other.__dict__ if type(other) is type(self) else NotImplemented

    def __hash__(self):
        return hash((type(self), *(self.__dict__[name] for name in self.keys)))

    def __repr__(self):
        return f"{type(self).__name__}({listed(f'{name}={self.__dict__[name]!r}' for name in self.keys)})"


def node(declared):
    """Class decorator for subclasses of Node: fill in `keys` and `defaults` from the declarations."""
    made = dataclasses.dataclass(init=False, repr=False, eq=False)(declared)
    made.keys = {field.name: field.metadata["key"] for field in dataclasses.fields(made)}
    made.defaults = {field.name: field.default for field in dataclasses.fields(made)
                     if field.default is not dataclasses.MISSING}
    return made
