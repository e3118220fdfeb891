"""The transfer curve of sRGB, by which 8-bit colours are encoded [IEC1999]."""

STRAIGHT = 0.0031308  # linear values up to here are encoded by a straight line


def encoded(x, select):
    """Return the encoding of linear values from 0 to 1, in arrays or lanes, with their library's `select`."""
    curve = 1.055 * select(x > STRAIGHT, x, STRAIGHT) ** (1 / 2.4) - 0.055
    return select(x <= STRAIGHT, 12.92 * x, curve)


def decoded(value):
    """Return the linear value of an encoded one, both from 0 to 1."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


BYTES = tuple(decoded(byte / 255) for byte in range(256))  # linear values of 8-bit ones
