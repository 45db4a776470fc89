"""The downwash of a rotorcraft: the air that its rotors blow down, as a jet."""

from __future__ import annotations

from math import exp, log, pi, sqrt

from hal.sim.model import AIR_DENSITY, Rotors
from hal.sim.physics import Triple

_HALF_WIDTH = 0.1
"""Growth of a round jet's half-width (where the velocity is half of that in its middle) with the
distance: S. B. Pope, *Turbulent Flows*, Cambridge 2000, 5.1."""
_SPREAD = _HALF_WIDTH / sqrt(2.0 * log(2.0))
"""The same for the standard deviation of its profile, a Gaussian."""
_EDGE = 3.0
"""Standard deviations beyond which the air is taken to be still."""


def downwash(rotors: Rotors, thrust: float, offset: Triple) -> float:
    """How fast the air sinks at an ``offset`` from a vehicle with that total thrust (N), m/s.

    ``offset`` is that from the vehicle's centre, world frame, metres; above it there is none.
    Momentum theory gives the wake below the discs twice the induced velocity; further down it mixes
    with still air as a turbulent jet does, as L. Bauersfeld et al. found it under quadrotors
    (*Robotics meets fluid dynamics*, RA-L 2025). The jet is Gaussian over its width, grows in
    proportion to the distance, and carries the momentum of the thrust through each level. It points
    straight down: neither tilt nor wind bends it, and no ground.
    """
    x, y, z = offset
    if z >= 0.0 or thrust <= 0.0:
        return 0.0
    contracted = sqrt(rotors.area / (2.0 * pi))
    deviation = contracted - _SPREAD * z
    away = (x * x + y * y) / (deviation * deviation)
    if away > _EDGE * _EDGE:
        return 0.0
    wake = sqrt(2.0 * thrust / (AIR_DENSITY * rotors.area))
    return wake * contracted / deviation * exp(-away / 2.0)
