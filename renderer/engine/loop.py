"""The only loop over path vertices.

One lane a pixel: as soon as its path ends it starts its next sample, so that the lanes of a packet never wait for
the longest path among them. The image stays in registers, and memory does not depend on the number of samples.
"""

import drjit as dr

from renderer.core.backend import Float, Float64, UInt32, Vector2f


def pixel_corner(pixel, width):
    """Return column and row of a pixel number, as Vector2f of its top left corner in pixels.

    Division in double precision, because integer division has no vector instruction; exact for 2^28 pixels.
    """
    row = UInt32((Float64(pixel) + 0.5) / Float64(width))
    return Vector2f(Float(pixel - row * width), Float(row))


def sample_pixels(integrator, camera, sampler, corner, radiance, first, end):
    """Return radiance (Vector3f, one lane a pixel) plus the sum of the samples from `first` up to `end`.

    Samples are added one by one in their order, so that the sum does not depend on how passes split them.
    `sampler` is None for one ray through the middle of each pixel; `first` and `end` are opaque UInt32.
    """
    kind, camera_row = camera
    lanes = dr.width(corner)

    def camera_ray(sample):
        offset = Vector2f(0.5) if sampler is None else sampler.u2(sample)
        return kind.ray(camera_row, corner + offset)

    sample = first + dr.zeros(UInt32, lanes)
    path = integrator.restart(integrator.start(lanes), True, *camera_ray(sample))

    def advance(sample, path, radiance):
        added, alive, path = integrator.step(path)
        sample = sample + dr.select(alive, UInt32(0), 1)
        return sample, integrator.restart(path, ~alive, *camera_ray(sample)), radiance + added

    _, _, radiance = dr.while_loop(
        (sample, path, radiance), lambda sample, path, radiance: sample < end, advance, label="samples"
    )
    return radiance
