"""Limits of flight, which a vehicle keeps whatever it is commanded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import isfinite

from vencejo.errors import UserError
from vencejo.units import ANGLE, LENGTH, SPEED, TURN_RATE, Dimension


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits to set, also in flight; None leaves a limit as it is.

    Altitudes are heights of the world frame here, and stay where they are when its origin jumps;
    missions and the command line count them above home (see :meth:`raised`).
    """

    max_speed: float | None = None
    """Over the ground, m/s."""
    max_climb: float | None = None
    """Up or down, m/s."""
    max_tilt: float | None = None
    """Radians from upright."""
    max_yaw_rate: float | None = None
    """rad/s."""
    min_altitude: float | None = None
    """Metres. It binds set-points, but not take-off, landing and return."""
    max_altitude: float | None = None
    """Metres."""

    def given(self) -> dict[str, float]:
        """The limits to change, by name. Raises UserError (``bad-limit``) for impossible ones."""
        found = {name: value for name in DIMENSIONS if (value := getattr(self, name)) is not None}
        for name, value in found.items():
            if not isfinite(value) or (value <= 0 and DIMENSIONS[name] != LENGTH):
                raise UserError("bad-limit", f"'{name}' must be a number above 0, not {value:g}")
        low, high = self.min_altitude, self.max_altitude
        if low is not None and high is not None and low >= high:
            message = f"'min_altitude' ({low:g} m) must be below 'max_altitude' ({high:g} m)"
            raise UserError("bad-limit", message)
        return found

    def raised(self, height: float) -> Limits:
        """The same limits with altitudes raised by ``height``, metres, such as home's height."""
        low, high = self.min_altitude, self.max_altitude
        return replace(
            self,
            min_altitude=None if low is None else low + height,
            max_altitude=None if high is None else high + height,
        )

    def over(self, others: Limits) -> Limits:
        """These limits, completed by those of ``others`` that are None here."""
        return replace(others, **{name: getattr(self, name) for name in self.given()})


DIMENSIONS: Mapping[str, Dimension] = dict(
    zip(
        (field.name for field in fields(Limits)),
        (SPEED, SPEED, ANGLE, TURN_RATE, LENGTH, LENGTH),
        strict=True,
    )
)
"""The dimension of each limit, by name."""
