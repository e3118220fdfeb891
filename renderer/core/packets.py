"""Parameter records of many things, each lane reading its own: whole records come by packet gathers.

Up to 8 words come to 16 lanes in about the time that three single gathers take.
"""

import dataclasses

import drjit as dr

from renderer.core.backend import ArrayXf, Float
from renderer.core.rows import Columns


class Packets:
    """Records like `Rows`, padded to 2, 4 or 8 words, or a multiple of 8; only lane indices read them."""

    def __init__(self, records):
        self.count, words = len(records), len(records[0])
        self._words = 1 << (words - 1).bit_length() if words <= 8 else -(-words // 8) * 8
        padding = [0.0] * (self._words - words)
        self._data = Float([value for record in records for value in (*record, *padding)])
        dr.eval(self._data)

    def row(self, index, active):
        """Return the record at a lane index that is only meaningful where `active`."""
        words, lanes = [], dr.width(index)
        part = min(self._words, 8)
        parts = self._words // part
        for k in range(parts):
            found = dr.gather(ArrayXf, self._data, index * parts + k, active, shape=(part, lanes))
            words += [found[word] for word in range(part)]
        return Packet(words)


@dataclasses.dataclass
class Packet(Columns):
    """One record a lane."""

    _words: list

    def __getitem__(self, column):
        return self._words[column]
