"""What an integrator provides to the loop that feeds it camera rays, and the registry by render mode.

An integrator works on lanes that each follow one camera ray until its radiance is known:
- `start(lanes)` returns the state of lanes that have nothing to do yet;
- `restart(state, where, o, d)` puts a fresh camera ray into the lanes `where`;
- `step(state, draws) -> (radiance, alive, state)` follows each lane's ray to its next hit, and returns what this adds
  to the sample and whether the lane needs another step; `draws` (samplers.base.Draws) has the sample's random numbers.

Where many rays hit nothing, an integrator may set `looks_ahead`: `trace(state)` returns the hits of the lanes' rays,
and `missed(state)` what the rays without one bring. Their lanes then begin another sample before the step, which takes
the hits as a third argument, so that fewer lanes are idle while surfaces are shaded.

`uneven` tells whether pixels differ so much in what they cost that lanes had better render several one after the other.
"""

from renderer.core.registry import Registry

INTEGRATORS = Registry()
register = INTEGRATORS.under  # a render mode
