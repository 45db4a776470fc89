"""What the simulator says of its vehicles' flight, without flying."""

from __future__ import annotations

from functools import partial
from math import dist, hypot, inf, sqrt

from hal.flight_model import FlightModel
from hal.limits import Limits
from hal.sim.model import Model
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

    A rotor's mean thrust in level flight, in hover and in a steady climb is the weight, since the
    simulator has no drag: so it is the time that costs (see :class:`hal.sim.battery.Battery`).
    """
    length, rise = dist(begin, end), abs(end.z - begin.z)
    level = hypot(end.x - begin.x, end.y - begin.y)
    if length == 0.0:
        return stay / model.endurance
    over_ground = model.max_speed * length / level if level else inf
    climbing = model.max_climb * length / rise if rise else inf
    reached = min(over_ground, climbing, speed or inf, sqrt(length * ACCELERATION))
    # A begin and an end at a steady acceleration take as long again as the way they shorten.
    return (length / reached + reached / ACCELERATION + SMOOTHING + stay) / model.endurance
