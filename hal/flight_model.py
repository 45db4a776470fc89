"""What a backend says of its vehicles' flight before it is opened, for plans."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from hal.limits import Limits
from vencejo.geometry import Point

LegCharge = Callable[[Point, Point, float | None, float], float]
"""The share of a full battery that a straight leg and a stay at its end take: begin, end (m), speed
along it (m/s, None for the vehicle's own), stay (s)."""


@dataclass(frozen=True)
class FlightModel:
    """How the vehicles of a backend fly, as far as plans ask."""

    leg_charge: LegCharge
    return_height: float
    """Least height above home at which they return by their own means, metres."""
    profiles: Mapping[str, Limits]
    """Their named limits, altitudes above home."""
