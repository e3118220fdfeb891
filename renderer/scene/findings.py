"""Remarks about a scene file while it is being read, and the words they are told in."""

from __future__ import annotations

import os

# How much a finding weighs: a mistake; something not rendered as written; an unknown key; a harmless translation.
ERROR, WARNING, IGNORED, NOTE = "error", "warning", "ignored", "note"
AT_VALUE, AT_KEY, AT_PARENT = "value", "key", "parent"
NOTHING = object()


class Finding:
    """A remark about the value at `at`; `value` (if given) is quoted after it; `anchor` says where it points to.

    `as_written`: `at` is a path of the file itself, not of the document after translation.
    """

    def __init__(self, at, message, value=NOTHING, anchor=AT_VALUE, severity=ERROR, as_written=False):
        self.at, self.message, self.value = at, message, value
        self.anchor, self.severity, self.as_written = anchor, severity, as_written


def spelt_out(at):
    """Return the linked path as a tuple of keys and indices from the top of the file."""
    keys = []
    while at is not None:
        at, key = at
        keys.append(key)
    return tuple(reversed(keys))


def linked(path):
    """Return the tuple of keys and indices as a linked path."""
    at = None
    for key in path:
        at = (at, key)
    return at


def quoted(name):
    """Return a name from a file in quotes, cut to a readable length, with control characters escaped."""
    text = repr(str(name))
    return text if len(text) <= 60 else text[:56] + "...'"


def nearest(name, known):
    """Return ", did you mean '...'?" for the known name that resembles `name` most, or an empty string."""
    import difflib  # only needed once something is wrong

    folded = {candidate.lower(): candidate for candidate in reversed(list(known))}
    given = str(name)[:80].lower()
    found = difflib.get_close_matches(given, folded, n=1, cutoff=0.6)
    if not found and len(given) > 2:
        found = [candidate for candidate in folded if candidate.startswith(given)][:1]
    return f", did you mean '{folded[found[0]]}'?" if found else ""


def nearest_file(path):
    """Return ", did you mean '...'?" for the file beside `path`, of its kind, whose name resembles its name most."""
    folder, name = os.path.split(path)
    try:
        beside = os.listdir(folder or ".")
    except (OSError, ValueError):  # no such folder, or none that the system takes
        return ""
    kind = os.path.splitext(name)[1].lower()
    return nearest(name, (one for one in sorted(beside) if one.lower().endswith(kind) and one.isprintable()))


def listed(names):
    """Return the names as a readable list."""
    return ", ".join(str(name) for name in names)
