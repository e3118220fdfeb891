"""Parameter records as device data: structure is code, values are data.

A kernel reads record k by a literal index (one scalar load), or the record of each lane by a lane index. The
kernel's code depends on how many records there are, never on what they hold, so that an edited value finds the
compiled kernel in the cache.
"""

import drjit as dr

from renderer.core.backend import Float, UInt32, Vector3f

SELECT_LIMIT = 12  # records; up to here a chain of selects is faster than a gather, which costs a load a lane
# Iterations; longer loops are traced once. Unrolled code is twice as fast also beyond (measured to 128 spheres), but
# its compilation grows: 0.6 s for 32 spheres and a light, 1.2 s for 64, 3.4 s for 128.
UNROLL_LIMIT = 32
AXIS_VALUES = (-1, 0, 1)  # components of directions along the axes
ALL_CONSTANT = False  # True compiles all values into the kernel, so that every edit compiles another; for measuring


class Rows:
    """`count` records of `width` values each, of one array type.

    `directions` are columns whose zeros and ones count as structure: along the axes most terms of a dot product vanish.
    """

    def __init__(self, records, array_type=Float, directions=()):
        self._directions = frozenset(directions)
        self.count, self.width = len(records), len(records[0])
        self._type = array_type
        self._host = [value for record in records for value in record]
        self._data = array_type(self._host)
        self._scalars = {}
        dr.eval(self._data)
        if self.count <= UNROLL_LIMIT:  # now, because a variable made in a loop must not be kept beyond it
            for place in range(self.count * self.width):
                self._scalar(place)

    def __getitem__(self, index):
        """Return the record at a literal index (int) or at a lane index (UInt32)."""
        return Row(self, index)

    def row(self, index, active):
        """Return the record at a lane index that is only meaningful where `active`."""
        return Row(self, index, active)

    def chosen(self, masks):
        """Return the record of the last true mask of each lane; `masks` are those of the records from the second on."""
        return Row(self, 0, masks=masks)

    def column(self, column):
        """Return one column of all records, a lane each."""
        return dr.gather(self._type, self._data, dr.arange(UInt32, self.count) * self.width + column)

    def read(self, index, column, active, masks):
        """Return one column of one record, or of one record a lane."""
        if masks is None and isinstance(index, int) and isinstance(column, int):
            return self._scalar(index * self.width + column)
        if masks is None:
            return dr.gather(self._type, self._data, index * self.width + column, active)
        value = self.read(0, column, True, None)
        for k, mask in enumerate(masks, start=1):
            value = dr.select(mask, self.read(k, column, True, None), value)
        return value

    def _scalar(self, place):
        """Return one value as a variable of its own: a gather would make a new one for every time it is read."""
        if place not in self._scalars:
            value = self._host[place]
            constant = place % self.width in self._directions and value in AXIS_VALUES
            self._scalars[place] = self._type(value) if constant or ALL_CONSTANT else dr.opaque(self._type, value)
        return self._scalars[place]


class Columns:
    """A record that is read column by column; where `record[column]` comes from is its own affair."""

    def vector(self, column):
        """Return three neighbouring columns as a vector."""
        return Vector3f(self[column], self[column + 1], self[column + 2])


class Row(Columns):
    """One record of Rows."""

    def __init__(self, rows, index, active=True, masks=None):
        self._rows, self._index, self._active, self._masks = rows, index, active, masks
        if not isinstance(index, int) and rows.count <= SELECT_LIMIT:
            self._masks = [index == k for k in range(1, rows.count)]

    def __getitem__(self, column):
        return self._rows.read(self._index, column, self._active, self._masks)

    @property
    def width(self):
        """Columns of the record."""
        return self._rows.width


def repeat(count, body, state, label, unroll=None):
    """Return `state` after `state = body(i, *state)` for i from 0 to count - 1.

    `i` is an int where the loop is unrolled, else a UInt32 of lanes; `unroll` says which, by default the count does.
    """
    if count <= UNROLL_LIMIT if unroll is None else unroll:
        for i in range(count):
            state = body(i, *state)
        return state
    counter = dr.zeros(UInt32, max(dr.width(part) for part in state))
    result = dr.while_loop(
        (counter, *state),
        lambda i, *rest: i < count,
        lambda i, *rest: (i + 1, *body(i, *rest)),
        label=label,
    )
    return result[1:]
