"""What the simulator says of its vehicles' flight, without flying."""

from __future__ import annotations

from functools import partial
from math import dist, hypot, inf, sqrt

from hal.flight_model import FlightModel
from hal.limits import Limits
from hal.sim.model import Model
from hal.sim.rotor_power import level_power
from vencejo.geometry import Point

RETURN_HEIGHT = 5.0
"""Least height above home of a return, metres."""
ACCELERATION = 1.5
"""With which legs are begun and ended, m/s²: that of the behaviours, on average."""
SMOOTHING = 0.6
"""Time by which a leg takes longer since it begins and ends smoothly, seconds."""


def flight_model_of(model: Model) -> FlightModel:
    """What plans may ask of a model's flight."""
    own = Limits(model.max_speed, model.max_climb, model.max_tilt, model.max_yaw_rate)
    return FlightModel(partial(_leg_charge, model), RETURN_HEIGHT, model.profiles, own)


def _leg_charge(model: Model, begin: Point, end: Point, speed: float | None, stay: float) -> float:
    """The share of a full battery that a leg takes (see :data:`hal.flight_model.LegCharge`).

    The power is that of hovering, or of level flight at the leg's speed where that is more. Up to
    5 m/s it is within a tenth of it; a climb takes more, and the way back down less by about as
    much (see :func:`hal.sim.rotor_power.level_power`).
    """
    length, rise = dist(begin, end), abs(end.z - begin.z)
    level = hypot(end.x - begin.x, end.y - begin.y)
    if length == 0.0:
        return stay / model.endurance
    over_ground = model.max_speed * length / level if level else inf
    climbing = model.max_climb * length / rise if rise else inf
    reached = min(over_ground, climbing, speed or inf, sqrt(length * ACCELERATION))
    power = max(1.0, level_power(model, reached * level / length) / model.hover_power)
    # A begin and an end at a steady acceleration take as long again as the way they shorten.
    slow = reached / ACCELERATION + SMOOTHING + stay
    return (power * length / reached + slow) / model.endurance
