"""What a BSDF kind provides, and the registry that finds it by its name in the scene file.

A kind is a set of stateless functions on lanes. `p` reads the parameters of each lane's instance in the columns that
`pack` wrote (`p[COLUMN]`, `p.vector(COLUMN)`), textures already looked up. Directions are unit, local (z is the shading
normal), and both point away from the surface: `wi` to where the path came from, `wo` to where it goes. For kinds that
only reflect, the frame is turned so that wi.z > 0: they look alike from both sides. Kinds that transmit get the frame
as it is: wi.z > 0 outside.

- `pack(bsdf, outside)`: host; the validated description as floats; `outside` is the index of refraction around it.
- `features(bsdf)`: host; names of what this instance needs in a kernel. `has` is the union over the scene's instances:
  code for what is not in it is not compiled.
- `sample(p, wi, u, u2, has) -> BsdfSample`; u picks a lobe, u2 a direction.
- `evaluate(p, wi, wo, has) -> (value, pdf_sa)`: the BSDF times |wo.z|, and the density of `sample` per steradian;
  without delta parts; 0 where wi or wo is on the wrong side.
- `smooth(bsdf)`: host; whether `evaluate` is ever greater than 0, so that lights are worth sampling.
- `albedo(p)`: colour that tells the material apart, for pictures of first hits; about its reflectance.
- `textured`: columns of the parameters that may be textured, by their key.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr

from renderer.core.backend import Bool, Float, Vector3f
from renderer.core.registry import Registry


@dataclass
class BsdfSample:
    """A direction in which a path goes on; where sampling failed, weight and pdf_sa are 0 and `delta` is False."""

    wo: Vector3f  # local, unit
    weight: Vector3f  # value / pdf_sa; of delta parts, their share over the probability that they were picked
    pdf_sa: Float  # 0 where delta
    delta: Bool  # whether the direction was the only possible one of its lobe
    eta: Float  # index of refraction where wo goes over that where wi came from; 1 for reflection


@dataclass(frozen=True)
class BsdfKind:
    """The functions of one kind; see the module docstring for their contracts."""

    name: str
    pack: Callable
    sample: Callable
    evaluate: Callable
    albedo: Callable
    features: Callable = lambda bsdf: ()
    smooth: Callable = lambda bsdf: True
    transmits: bool = False  # the frame is not turned
    textured: dict | None = None  # key: (column, width 1 or 3)


KINDS = Registry()
register = KINDS.register
BLACK = (0.0, 0.0, 0.0)


def constant(colour):
    """Return a colour of the description, black where a texture gives it; host."""
    return colour if isinstance(colour, tuple) else BLACK


def mirrored(w, where):
    """Return a local direction, mirrored by the surface in the lanes `where`."""
    return Vector3f(w.x, w.y, dr.select(where, -w.z, w.z))


def turned(w, wi):
    """Return a local direction in the frame that is turned to wi."""
    return mirrored(w, wi.z < 0)


def nothing(p, wi, wo, has):
    """Return value and density, as `evaluate` does, of a kind all of whose directions are delta."""
    return Vector3f(0), Float(0)
