"""The four rotors: from the thrust and torques that the controller wants to those that act."""

from __future__ import annotations

from math import exp, sqrt
from typing import Protocol

from hal.sim.model import Model
from hal.sim.physics import STEP

Wrench = tuple[float, float, float, float]
"""Thrust along the body's z (N), and torques about its x, y and z (N·m)."""

_TILT_SHARE = 0.25
"""Part of the rotors' range that tilt has in any case."""


class Drive(Protocol):
    """What turns a wanted wrench into the one that acts, once each physics step."""

    share: float
    """The largest thrust there is now, as a share of the model's."""
    excess: float
    """Thrust that was asked of the rotors beyond the wanted one, for the sake of tilt, in the last
    step, newtons; negative where it is less."""

    def step(self, wanted: Wrench) -> Wrench: ...

    def stop(self) -> None:
        """Stand still."""


class IdealDrive:
    """Gives what is wanted at once, up to the largest thrust and torques."""

    share = 1.0
    excess = 0.0

    def __init__(self, model: Model) -> None:
        self._most = model.max_thrust
        self._tilt, self._yaw = model.max_torques

    def step(self, wanted: Wrench) -> Wrench:
        thrust, x, y, z = wanted
        most, tilt, yaw = self._most, self._tilt, self._yaw
        return (
            most if thrust > most else thrust,
            tilt if x > tilt else -tilt if x < -tilt else x,
            tilt if y > tilt else -tilt if y < -tilt else y,
            yaw if z > yaw else -yaw if z < -yaw else z,
        )

    def stop(self) -> None:
        pass


class RotorDrive:
    """Four rotors in an X, each of which has a least and a largest thrust and a first-order lag.

    Where they cannot give everything, tilt goes before height, and height before yaw, as in
    M. Faessler et al., *Thrust mixing, saturation, and body-rate control for accurate aggressive
    quadrotor flight*, RA-L 2017; but for the sake of tilt they never lift it, and hardly drop it.
    """

    def __init__(self, model: Model) -> None:
        rotors = model.rotors
        self._most = rotors.max_thrust
        self._least = rotors.idle_thrust * rotors.max_thrust
        self._lever = rotors.arm / sqrt(2)
        """Distance of each rotor from the body's x and y axes, metres."""
        self._drag_ratio = rotors.drag_ratio
        self._carrying = model.weight / 4
        """Thrust of each with which it is carried, newtons."""
        # The exact step of a first-order lag under a constant command.
        self._follow = 1.0 - exp(-STEP / rotors.time_constant) if rotors.time_constant else 1.0
        self.share = 1.0
        self.excess = 0.0
        self._thrusts = (0.0, 0.0, 0.0, 0.0)
        """Of the rotors front left, rear left, rear right and front right, newtons."""

    def step(self, wanted: Wrench) -> Wrench:
        thrust, x, y, z = wanted
        lever, ratio = self._lever, self._drag_ratio
        least, most = self._least, self._most * self.share
        mean, roll, pitch, yaw = thrust / 4, x / lever / 4, y / lever / 4, z / ratio / 4
        spread = abs(roll) + abs(pitch)
        self.excess = 0.0
        if mean - spread - abs(yaw) < least or mean + spread + abs(yaw) > most:
            room = self._tilt_room(mean)
            mean, roll, pitch, yaw = _saturated(mean, roll, pitch, yaw, (least, most, room))
            self.excess = 4 * mean - thrust
        a, b, c, d = self._thrusts
        follow, up, down = self._follow, mean + yaw, mean - yaw
        a += (up + roll - pitch - a) * follow
        b += (down + roll + pitch - b) * follow
        c += (up - roll + pitch - c) * follow
        d += (down - roll - pitch - d) * follow
        self._thrusts = (a, b, c, d)
        # The rotors front left and rear right turn clockwise as seen from above.
        return (
            a + b + c + d,
            (a + b - c - d) * lever,
            (b + c - a - d) * lever,
            (a - b + c - d) * ratio,
        )

    def _tilt_room(self, mean: float) -> float:
        """The largest share of tilt in a rotor's thrust, newtons, with a wanted mean thrust.

        Tilt neither raises the mean above what carries the vehicle, nor, where a battery that sags
        leaves little more than that, lowers it far below.
        """
        most, carrying = self._most * self.share, self._carrying
        half = (most - self._least) / 2
        above = max(_TILT_SHARE * half, most - min(mean, carrying))
        return min(half, max(mean, carrying) - self._least, above)

    def stop(self) -> None:
        self._thrusts = (0.0, 0.0, 0.0, 0.0)


def _saturated(
    mean: float, roll: float, pitch: float, yaw: float, bounds: tuple[float, float, float]
) -> tuple[float, float, float, float]:
    """The shares of thrust, tilt and yaw in each rotor's thrust that its bounds allow.

    ``bounds``: its least and its largest thrust, and the largest share of tilt.
    """
    least, most, room = bounds
    spread = abs(roll) + abs(pitch)
    if spread > room:
        roll, pitch, spread = roll * room / spread, pitch * room / spread, room
    mean = max(least + spread, min(most - spread, mean))
    turn = max(0.0, min(most - mean, mean - least) - spread)
    return mean, roll, pitch, max(-turn, min(turn, yaw))
