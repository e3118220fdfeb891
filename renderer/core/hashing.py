"""A hash of 32 bits, for random numbers that need no state and for keys."""


def mix(x):
    """Return a bijective hash of UInt32 in which each bit depends on all bits of x.

    Two rounds of xor-shift and multiply, found by a search for low avalanche bias [Wellons2018].
    """
    x = (x ^ (x >> 16)) * 0x7FEB352D
    x = (x ^ (x >> 15)) * 0x846CA68B
    return x ^ (x >> 16)
