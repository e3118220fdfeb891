"""The counterpart of mode `pathtracer`: Mitsuba's own path integrator, with the coursework's material as a plugin."""

from __future__ import annotations

from converters.mitsuba import to_dict


def reference(loaded, seed=0):
    """Return linear radiance (H, W, 3) float32, with the scene's number of samples a pixel."""
    scene = to_dict(loaded, exact=True)  # chooses the variant
    import mitsuba as mi

    return mi.render(mi.load_dict(scene), spp=loaded.description.spp, seed=seed).numpy()
