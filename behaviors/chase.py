"""A reference that catches up with a moving target and stays with it.

The reference moves at a velocity u = v + c(e), where v is the target's and c a closing speed
along the way e that is left: k·|e| close by and √(2·b·(|e| − b/(2·k²))) farther off, from where it
can still be braked at b (the square-root controller of ArduPilot's ``AC_PosControl``). It is
accelerated towards u by 4·k·(u − its velocity), which closes the last of the way without
overshooting (both poles are at −2·k), within ACCELERATION and JERK. So nothing that is told of a
target, however wrong, makes a vehicle jump: speed, acceleration and jerk are bounded.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from behaviors.guidance import MAX_LEAD, STILL
from hal.vehicle import Observation, Position
from vencejo.geometry import Point, wrap

ACCELERATION = 4.0
"""Largest acceleration of the reference, m/s²."""
JERK = 40.0
"""Largest change of its acceleration, m/s³: a quadrotor must tilt first."""
BRAKING = 0.5
"""Deceleration with which it plans to stop, as a share of its acceleration."""


class Chase:
    """A moving reference point, mission frame; each period ``step``, then ``setpoint``."""

    def __init__(
        self,
        seen: Observation,
        stiffness: float = 1.5,
        acceleration: float = ACCELERATION,
    ) -> None:
        """``stiffness`` is k, 1/s: how fast the last of the way is closed."""
        self.position = seen.position
        """Where the vehicle is to be now."""
        self.velocity = seen.velocity
        """Its mean until the next period."""
        self.acceleration = STILL
        self._next = seen.position
        self._stiffness = stiffness
        self._most = acceleration

    def step(
        self,
        target: Point,
        moves: Point,
        speed: float,
        seen: Observation,
        dt: float,
    ) -> None:
        """Go on for ``dt`` seconds after a ``target`` that ``moves`` at a velocity, m/s.

        It is never faster than ``speed``, m/s, once it was not, and waits for a vehicle that is
        held up.
        """
        self.position = place = self._leashed(self._next, seen.position)
        wanted = _bound(moves.plus(self._closing(target.minus(place))), speed)
        k = 4 * self._stiffness
        asked = _bound(wanted.minus(self.velocity).times(k), self._most)
        change = _bound(asked.minus(self.acceleration), JERK * dt)
        self.acceleration = self.acceleration.plus(change)
        self.velocity = self.velocity.plus(self.acceleration.times(dt))
        self._next = place.plus(self.velocity.times(dt))

    def stop(self, seen: Observation, dt: float) -> None:
        """Slow down, and stay where that ends."""
        self.step(self._next, STILL, 0.0, seen, dt)

    def setpoint(self, yaw: float) -> Position:
        return Position(self.position, self.velocity, yaw, acceleration=self.acceleration)

    def _closing(self, left: Point) -> Point:
        """The velocity relative to the target with which the way that is ``left`` is closed."""
        far, k, braking = left.norm(), self._stiffness, BRAKING * self._most
        if far < 1e-9:
            return STILL
        near = braking / (k * k)
        closing = k * far if far <= near else sqrt(2 * braking * (far - near / 2))
        return left.times(closing / far)

    @staticmethod
    def _leashed(place: Point, vehicle: Point) -> Point:
        """The place, or that on the way to it which is MAX_LEAD from the vehicle."""
        lead = place.minus(vehicle)
        far = lead.norm()
        return place if far <= MAX_LEAD else vehicle.plus(lead.times(MAX_LEAD / far))

    def progress(self) -> list[list[float]]:
        """Its state, as JSON."""
        return [list(each) for each in (self._next, self.velocity, self.acceleration)]

    def go_on(self, progress: Sequence[Sequence[float]]) -> None:
        """Continue from the progress of another one."""
        self._next, self.velocity, self.acceleration = (Point(*each) for each in progress)
        self.position = self._next


def turned_towards(yaw: float, wanted: float, rate: float, dt: float) -> float:
    """A yaw turned towards the wanted one for ``dt`` seconds, by ``rate`` rad/s at most."""
    change = wrap(wanted - yaw)
    return wrap(yaw + max(-rate * dt, min(rate * dt, change)))


def _bound(vector: Point, most: float) -> Point:
    """The vector, shortened to a length of ``most``."""
    length = vector.norm()
    return vector if length <= most else vector.times(most / length)
