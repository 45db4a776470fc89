"""Limits, checked and set."""

from __future__ import annotations

from math import pi, tan

from hal.sim.control import Controller
from hal.vehicle import Limits
from vencejo.errors import UserError

_STEEPEST = 60 * pi / 180
"""The largest tilt limit there may be, radians: the thrust of the motors carries no more."""


def set_limits(controller: Controller, limits: Limits) -> None:
    """Change the limits that are given; all or none. Raises UserError (``bad-limit``)."""
    limits.given()
    if limits.max_tilt is not None and limits.max_tilt > _STEEPEST:
        raise UserError("bad-limit", f"'max_tilt' can be {_STEEPEST:.2f} rad at most")
    if limits.max_speed is not None:
        controller.max_speed = limits.max_speed
    if limits.max_climb is not None:
        controller.max_climb = limits.max_climb
    if limits.max_tilt is not None:
        controller.max_lean = tan(limits.max_tilt)
    if limits.max_yaw_rate is not None:
        controller.max_yaw_rate = limits.max_yaw_rate
    if limits.max_altitude is not None:
        controller.max_altitude = limits.max_altitude
