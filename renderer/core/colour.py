"""Colours: linear RGB with the primaries of sRGB."""

LUMINANCE = (0.2126, 0.7152, 0.0722)  # of the channels [ITU-R BT.709]


def luminance(colour):
    """Return the luminance of a colour, in lanes or of numbers on the host."""
    return sum(weight * channel for weight, channel in zip(LUMINANCE, colour))
