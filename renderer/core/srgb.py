"""The transfer curve of sRGB, by which 8-bit colours are encoded [IEC1999]."""


def decoded(value):
    """Return the linear value of an encoded one, both from 0 to 1."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


BYTES = tuple(decoded(byte / 255) for byte in range(256))  # linear values of 8-bit ones
