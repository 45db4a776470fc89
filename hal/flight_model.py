"""What a backend says of its vehicles before it is opened, for plans and lists."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from hal.limits import Limits
from vencejo.errors import Where
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
    limits: Limits = field(default_factory=Limits)
    """The limits that they have unless others are set; None where there is none."""


@dataclass(frozen=True)
class VehicleModel:
    """A model of a backend's vehicles, as far as checks and lists ask."""

    name: str
    description: str
    capabilities: frozenset[str]
    """Those of a vehicle with the default settings."""
    one_active_camera: bool
    """Whether only one of its cameras delivers images at a time."""
    flight: FlightModel
    figures: Mapping[str, float]
    """Its main figures by name, the unit at the end: ``mass_kg``, ``endurance_s``."""


class Models(Protocol):
    """The models that a backend has."""

    def names(self) -> list[str]:
        """Those that have a name."""

    def find(self, word: str | None, where: Where | None = None) -> VehicleModel:
        """One by name or path, None for the backend's default; ``where`` names it.

        Raises UserError (``unknown-model`` and others).
        """
