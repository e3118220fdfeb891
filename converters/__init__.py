"""Scene descriptions to other formats, above all to Mitsuba, the reference that the renderer is checked against.

Everything here starts from the validated description (`renderer.scene.loaded`) and computes its own geometry, so that
a comparison with Mitsuba shares nothing with what it checks.
"""
