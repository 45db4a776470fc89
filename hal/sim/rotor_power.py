"""The power of rotors, by momentum theory."""

from __future__ import annotations

from math import atan, cos, sin, sqrt

from hal.sim.model import AIR_DENSITY, Model, Rotors

_ROUNDS = 4
"""Rounds of Newton's method; it starts within some per cent."""


def induced_velocity(thrust: float, area: float, climb: float, across: float) -> float:
    """The velocity (m/s) that rotors of a disc ``area`` (m²) give to the air for a thrust (N).

    ``climb`` is the speed through the air along the axes, ``across`` that across them, m/s.
    Glauert's formula v = vh² / √(across² + (climb + v)²) with vh² = thrust / 2ρA (J. G. Leishman,
    *Principles of Helicopter Aerodynamics*, 2.14); without speed across, that of axial flight. In a
    fast descent, in its own wake, a rotor does worse than this theory has it.
    """
    hover = thrust / (2 * AIR_DENSITY * area)
    if hover <= 0.0:
        return 0.0
    induced = sqrt(climb * climb / 4 + hover) - climb / 2
    if across > 0.0:
        square = across * across
        for _ in range(_ROUNDS):
            through = climb + induced
            speed = sqrt(square + through * through)
            # Newton's method for f(v) = v·speed - vh².
            induced -= (induced * speed - hover) / (speed + induced * through / speed)
    return induced


def rotor_power(rotors: Rotors, thrust: float, climb: float = 0.0, across: float = 0.0) -> float:
    """The electrical power (W) of a total thrust (N) at a speed through the air, m/s.

    Thrust times the speed of the air through the discs, which is what climbing costs too, over the
    efficiency. Never below zero: rotors driven by the air give nothing back.
    """
    through = climb + induced_velocity(thrust, rotors.area, climb, across)
    return max(0.0, thrust * through / rotors.efficiency)


def level_power(model: Model, speed: float) -> float:
    """The electrical power (W) of steady level flight at a speed (m/s) in still air.

    The vehicle leans so that its thrust carries the weight and the drag (see docs/physics.md); its
    own drag along its axes is what it carries besides.
    """
    body = AIR_DENSITY / 2 * model.drag.area * speed * speed
    tilt = atan((body + model.drag.rotors * speed) / model.weight)
    thrust = model.weight * cos(tilt) + body * sin(tilt)
    power = rotor_power(model.rotors, thrust, speed * sin(tilt), speed * cos(tilt))
    return model.battery.standby + power
