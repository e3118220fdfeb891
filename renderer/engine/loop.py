"""The only loop over path vertices.

One lane a pixel: as soon as its path ends it starts its next sample, so that the lanes of a packet never wait for
the longest path among them. The image stays in registers, and memory does not depend on the number of samples.
"""

import drjit as dr

from renderer.core.backend import Float, Float64, UInt32, Vector2f, Vector3f
from renderer.samplers.base import LENS, PIXEL, Draws


def pixel_corner(pixel, width):
    """Return column and row of a pixel number, as Vector2f of its top left corner in pixels.

    Division in double precision, because integer division has no vector instruction; exact for 2^28 pixels.
    """
    row = UInt32((Float64(pixel) + 0.5) / Float64(width))
    return Vector2f(Float(pixel - row * width), Float(row))


def sample_pixels(integrator, camera, sampler, corner, film, first, end, centred=False):
    """Return the Film (one lane a pixel) with the samples from `first` up to `end`, added in their order.

    `centred` sends every ray through the middle of its pixel and of the lens; `first` and `end` are opaque UInt32.
    """
    kind, camera_row = camera
    lanes = dr.width(corner)

    def camera_ray(sample):
        if centred:
            return kind.ray(camera_row, corner + Vector2f(0.5))
        position = corner + sampler.u2(sample, PIXEL)
        return kind.ray(camera_row, position, sampler.u2(sample, LENS) if kind.has_lens else None)

    sample = first + dr.zeros(UInt32, lanes)
    path = integrator.restart(integrator.start(lanes), True, *camera_ray(sample))

    def advance(sample, path, current, film):
        added, alive, path = integrator.step(path, Draws(sampler, sample))
        current = current + added
        film = film.add(current, ~alive)
        sample = sample + dr.select(alive, UInt32(0), 1)
        current = dr.select(alive, current, 0)
        return sample, integrator.restart(path, ~alive, *camera_ray(sample)), current, film

    _, _, _, film = dr.while_loop(
        (sample, path, dr.zeros(Vector3f, lanes), film),
        lambda sample, path, current, film: sample < end, advance, label="samples",
    )
    return film
