"""What an integrator provides to the loop that feeds it camera rays, and the registry by render mode.

An integrator works on lanes that each follow one camera ray until its radiance is known:
- `start(lanes)` returns the state of lanes that have nothing to do yet;
- `restart(state, where, o, d)` puts a fresh camera ray into the lanes `where`;
- `step(state, draws) -> (radiance, alive, state)` follows each lane's ray to its next hit, and returns what this adds to
  the sample and whether the lane needs another step; `draws` (samplers.base.Draws) has the sample's random numbers.
"""

from renderer.core.registry import Registry

INTEGRATORS = Registry()


def register(mode):
    """Return a class decorator that registers an integrator under a render mode."""

    def enter(integrator):
        INTEGRATORS.add(mode, integrator)
        return integrator

    return enter
