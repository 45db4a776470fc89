"""Landings that are tried again beside a place on which the vehicle does not stand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, hypot, pi, sin
from typing import Any

from behaviors.flight import Flight
from behaviors.manoeuvre import PendingOrder
from fsm.host import Outcome
from hal.orders import Order
from hal.vehicle import Observation, Position
from vencejo.geometry import Point, bearing, distance, horizontal_distance, turned

TRIES = 3
"""Further tries of a landing."""
AWAY = 1.5
"""Distance of a try from the place before, metres."""
RISE = 1.0
"""Height of the way there above the place before, metres."""
PATIENCE = 10.0
"""Seconds after which it comes down short of the place, since something is in the way."""
_THERE = 0.2
"""Distance within which a place of the way is reached, metres."""
_OVER_ONE_PLACE, _TRAVELLING = 0.3, 1.0
"""Speeds over the ground of a vehicle that comes down, and of one that flies elsewhere, m/s."""
_SINKING = 0.1
"""Least descent of a vehicle that comes down, m/s."""
_SLID = 0.05
"""Least distance that tells whereto it slid, metres."""
_LEANS = 0.035
"""Least sine of a tilt that tells to which side it leans."""


def is_unstable(seen: Observation) -> bool:
    """Whether the vehicle has just found that it does not stand where it came down."""
    return any(event.name == "vehicle.unstable" for event in seen.events)


class Descent:
    """Watches a landing: where it comes down, and to which side it slides."""

    def __init__(self) -> None:
        self._over: Point | None = None
        """The place over which it comes down."""
        self._before: float | None = None
        """The direction of the last try, radians."""

    def watch(self, seen: Observation) -> None:
        """Take the observation of a period in which it lands."""
        vx, vy, vz = seen.velocity
        speed = hypot(vx, vy)
        if speed > _TRAVELLING:
            self._over = None
        elif self._over is None and speed < _OVER_ONE_PLACE and vz < -_SINKING:
            self._over = seen.position

    def aside(self, seen: Observation) -> Aside:
        """The way to the next try: to the side to which it slid or leans, else on as before.

        Without any of them it goes back, for it has mostly come from there.
        """
        over, self._over = self._over, None
        lean = turned((0.0, 0.0, 1.0), seen.attitude)
        if over is not None and horizontal_distance(over, seen.position) > _SLID:
            direction = bearing(over, seen.position)
        elif hypot(lean.x, lean.y) > _LEANS:
            direction = bearing((0.0, 0.0, 0.0), lean)
        elif self._before is not None:
            direction = self._before
        else:
            direction = seen.yaw + pi
        self._before = direction
        return Aside(seen, direction)


class Aside:
    """The way of a vehicle that has to land beside its place: up, and over."""

    def __init__(self, seen: Observation, direction: float) -> None:
        x, y, z = seen.position
        top = z + RISE
        east, north = AWAY * cos(direction), AWAY * sin(direction)
        self._places = [Point(x, y, top), Point(x + east, y + north, top)]
        self._since = seen.time

    def step(self, seen: Observation) -> Position | None:
        """The set-point of this period, mission frame; None once it is there and may land."""
        place = self._places[0]
        if distance(place, seen.position) < _THERE or seen.time - self._since >= PATIENCE:
            self._places.pop(0)
            self._since = seen.time
        return Position(self._places[0]) if self._places else None


class PendingLanding(PendingOrder):
    """An order to land that a behaviour waits for, and its further tries."""

    def __init__(
        self,
        order: Callable[[], Order],
        now: float,
        timeout: float,
        progress: Mapping[str, Any] | None = None,
    ) -> None:
        """``order`` gives the order, ``timeout`` is in seconds and counts for all tries."""
        super().__init__(order(), now, timeout, progress)
        self.tries = (progress or {}).get("tries", 0)
        self._descent = Descent()
        self._aside: Aside | None = None

    def progress(self) -> dict[str, Any]:
        """The seconds waited and the tries, as JSON; resumed, it lands where it is then."""
        return {**super().progress(), "tries": self.tries}

    def step(self, flight: Flight) -> Outcome | str | None:
        """The outcome, as of PendingOrder; ``failed`` also when it stood nowhere."""
        seen, order = flight.observation, self.order
        if order.state == "refused" and is_unstable(seen) and self.tries < TRIES:
            self.tries += 1
            self._aside = self._descent.aside(seen)
        if self._aside is None:
            self._descent.watch(seen)
            return super().step(flight)
        setpoint = self._aside.step(seen)
        if setpoint is not None:
            flight.command(setpoint)
            return self.too_slow(flight)
        self._aside = None
        self.order = flight.land()
        return None
