"""What smooth and rough glass have in common: factors of what is mirrored and refracted, and an index by side."""

import drjit as dr

REFLECTANCE, TRANSMITTANCE, ETA, INVERSE = 0, 3, 6, 7  # columns; the index, and its inverse
TINTED = "tinted"
WHITE = (1.0, 1.0, 1.0)


def pack(bsdf, eta):
    """Return the factors, and an index relative to the outside; host."""
    return [*bsdf.reflectance, *bsdf.transmittance, eta, 1 / eta]


def features(bsdf):
    """Return TINTED where the factors are not 1; host."""
    return () if tuple(bsdf.reflectance) == WHITE == tuple(bsdf.transmittance) else (TINTED,)


def tinted(value, is_mirrored, p, has):
    """Return what is mirrored or refracted, times its factor."""
    if TINTED not in has:
        return value
    return value * dr.select(is_mirrored, p.vector(REFLECTANCE), p.vector(TRANSMITTANCE))


def seen_from(wi, p):
    """Return the index behind the surface over the one where wi is, and its inverse."""
    outside = wi.z > 0
    return dr.select(outside, p[ETA], p[INVERSE]), dr.select(outside, p[INVERSE], p[ETA])


def albedo(p):
    """Return the factor of what is refracted."""
    return p.vector(TRANSMITTANCE)
