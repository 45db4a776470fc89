"""The flight controller: where to be becomes how fast, how leaned and how hard to push.

A cascade in plain floats: position → velocity (with feed-forward) once each mission period, then
velocity → acceleration → tilt and thrust → torques at every physics step. The thrust carries the
load factor 1/cos(tilt), as in the sum-of-rotors controllers of Gazebo's quadrotors; tilt, speed,
climb and turn rate are limited.
"""

from __future__ import annotations

from math import hypot, inf, sqrt, tan

from hal.sim.airframe import Airframe
from hal.sim.physics import GRAVITY, State, Triple
from vencejo.geometry import rotate_xy, wrap, yaw_of

_APPROACH = 1.8
"""Speed asked for per metre of distance, 1/s."""
_BRAKE = 2.0
"""Deceleration the approach to a place is planned with, m/s²."""
_PUSH = 6.0
"""Acceleration per metre per second of missing speed, 1/s."""
_MAX_SINK, _MAX_RISE = -5.0, 6.0
"""Vertical acceleration, m/s²."""
_LEVEL, _LEVEL_DAMPING = 625.0, 50.0
"""Turn acceleration per radian off the wanted tilt and per rad/s: critically damped at 25 rad/s."""
_TURN_APPROACH, _TURN_BRAKE, _TURN_PUSH = 3.0, 4.0, 15.0
"""The same three as above, for the heading: 1/s, rad/s², 1/s."""
_STOPPED_TURNING = 0.05
"""Slower than this, a turn is over and the heading is kept, rad/s."""
_LEAST_LIFT = 0.5
"""Cosine of the tilt beyond which the load factor grows no more."""
_LEAST_THRUST = 1e-6
"""Share of the largest thrust: with none at all its direction, the tilt, would not be defined."""


class Controller:
    """Thrust and torques that bring a vehicle where it should be.

    Heights are those of the skids, like everything that leaves the simulator.
    """

    __slots__ = (
        "_damp_x", "_damp_y", "_in_heading", "_lean", "_level_x", "_level_y", "_mass",
        "_max_lean", "_max_lean_torque", "_max_thrust", "_max_tilt", "_max_turn_torque",
        "_place", "_skids", "_thrust", "_tilt", "_turn_push", "_velocity", "_want_rate",
        "_want_x", "_want_y", "_want_z", "_yaw", "_yaw_rate", "acceleration", "height",
        "max_altitude", "max_climb", "max_speed", "max_yaw_rate",
        "min_altitude", "noise",
    )  # fmt: skip

    def __init__(self, airframe: Airframe) -> None:
        self._skids = airframe.height
        self._mass = airframe.mass
        self._max_thrust = airframe.max_thrust
        self._max_lean_torque, self._max_turn_torque = airframe.max_torques
        ix, iy, iz = airframe.inertia
        self._level_x, self._damp_x = ix * _LEVEL, ix * _LEVEL_DAMPING
        self._level_y, self._damp_y = iy * _LEVEL, iy * _LEVEL_DAMPING
        self._turn_push = iz * _TURN_PUSH
        self.max_speed = airframe.max_speed
        self.max_climb = airframe.max_climb
        self._max_lean = 0.0
        """Horizontal over vertical part of the thrust."""
        self.max_tilt = airframe.max_tilt
        self.max_yaw_rate = airframe.max_yaw_rate
        self.min_altitude, self.max_altitude = -inf, inf
        self.noise = (0.0, 0.0, 0.0)
        """Added to the velocity asked for, m/s."""
        self.acceleration = (0.0, 0.0, 0.0)
        """Feed-forward of a place that moves, m/s², for this mission period."""
        self.height: float | None = None
        """World height to be at; None to climb at the velocity alone."""
        self._place: tuple[float, float] | None = None
        self._tilt: tuple[float, float] | None = None
        """Lean asked for itself: forward and left part of the thrust over the vertical one."""
        self._lean: tuple[float, float] | None = None
        """The same in the world, east and north, in this mission period."""
        self._thrust: float | None = None
        """Asked for with a lean, instead of a climb, newtons."""
        self._velocity = (0.0, 0.0, 0.0)
        self._in_heading = False
        self._yaw: float | None = None
        self._yaw_rate = 0.0
        self._want_x = self._want_y = self._want_z = self._want_rate = 0.0

    @property
    def max_tilt(self) -> float:
        """The largest tilt, radians."""
        return self._max_tilt

    @max_tilt.setter
    def max_tilt(self, tilt: float) -> None:
        self._max_tilt = tilt
        self._max_lean = tan(tilt)

    # Targets.

    def fly_to(self, x: float, y: float, z: float, velocity: Triple = (0.0, 0.0, 0.0)) -> None:
        """Be at a place, moving at a velocity when there (for a place that moves)."""
        self._place = (x, y)
        self.height = z
        self._velocity = velocity
        self._in_heading = False
        self._tilt = None

    def fly_at(self, x: float, y: float, z: float, in_heading: bool = False) -> None:
        """Fly at a velocity: (east, north, up), or (forward, left, up) as the heading turns."""
        self._place = self.height = None
        self._velocity = (x, y, z)
        self._in_heading = in_heading
        self._tilt = None

    def tilt(self, roll: float, pitch: float, climb: float, thrust: float | None = None) -> None:
        """Fly by tilt: roll (right side down) and pitch (nose down), radians.

        Climb at m/s or, when it is given, push with a share (0 to 1) of the largest thrust.
        """
        self._place = self.height = None
        self._velocity = (0.0, 0.0, climb)
        self._in_heading = False
        self._tilt = tan(_clamped(pitch, self.max_tilt)), -tan(_clamped(roll, self.max_tilt))
        if thrust is not None:
            thrust = max(_LEAST_THRUST, min(1.0, thrust)) * self._max_thrust
        self._thrust = thrust

    def stay_over(self, x: float, y: float) -> None:
        """Be over a place; the height is left as it was."""
        self._place = (x, y)
        self._velocity = (0.0, 0.0, self._velocity[2])

    def climb_at(self, speed: float) -> None:
        """Climb at a speed; the place is left as it was."""
        self.height = None
        self._velocity = (*self._velocity[:2], speed)

    def turn(self, rate: float) -> None:
        """Turn at a rate; at zero, stop turning and keep the heading."""
        if rate != 0.0 or self._yaw_rate != 0.0:
            self._yaw = None
        self._yaw_rate = rate

    def face(self, yaw: float) -> None:
        """Turn to a heading the short way round."""
        self._yaw = yaw
        self._yaw_rate = 0.0

    # Control.

    def plan(self, state: State) -> None:
        """Choose the velocity and the turn rate of the next mission period."""
        (x, y, z), attitude, _, turning = state
        z -= self._skids
        yaw = yaw_of(attitude)

        want_x, want_y, want_z = self._velocity
        if self._place is not None:
            off_x, off_y = self._place[0] - x, self._place[1] - y
            off = hypot(off_x, off_y)
            gain = _approach(off, _APPROACH, _BRAKE) / off if off else 0.0
            want_x += off_x * gain
            want_y += off_y * gain
        elif self._in_heading:
            want_x, want_y = rotate_xy(want_x, want_y, yaw)
        speed = hypot(want_x, want_y)
        if speed > self.max_speed:
            want_x *= self.max_speed / speed
            want_y *= self.max_speed / speed

        if self.height is not None:
            want_z += _approach(self.height - z, _APPROACH, _BRAKE)
        if self.min_altitude > -inf:
            want_z = max(want_z, _approach(self.min_altitude - z, _APPROACH, _BRAKE))
        if self.max_altitude < inf:
            want_z = min(want_z, _approach(self.max_altitude - z, _APPROACH, _BRAKE))
        want_z = max(-self.max_climb, min(self.max_climb, want_z))

        noise_x, noise_y, noise_z = self.noise
        self._want_x, self._want_y, self._want_z = (
            want_x + noise_x,
            want_y + noise_y,
            want_z + noise_z,
        )

        self._lean = None if self._tilt is None else rotate_xy(*self._tilt, yaw)

        rate = self._yaw_rate
        if rate == 0.0 and self._yaw is None and abs(turning[2]) < _STOPPED_TURNING:
            self._yaw = yaw
        if self._yaw is not None:
            rate = _approach(wrap(self._yaw - yaw), _TURN_APPROACH, _TURN_BRAKE)
        self._want_rate = max(-self.max_yaw_rate, min(self.max_yaw_rate, rate))

    def step(self, state: State) -> tuple[float, float, float, float]:
        """Thrust (N) and torques about the body's axes (N·m) for the next physics step."""
        _, (qx, qy, qz, qw), (vx, vy, vz), (wx, wy, wz) = state

        # Velocity → acceleration → the direction and size of the thrust.
        east, north, up = self.acceleration
        up += (self._want_z - vz) * _PUSH
        up = GRAVITY + (_MAX_RISE if up > _MAX_RISE else _MAX_SINK if up < _MAX_SINK else up)
        lean = self._lean
        if lean is None:
            east += (self._want_x - vx) * _PUSH
            north += (self._want_y - vy) * _PUSH
        else:
            if self._thrust is not None:
                up = self._thrust / self._mass * max(_LEAST_LIFT, 1.0 - 2.0 * (qx * qx + qy * qy))
            east, north = up * lean[0], up * lean[1]
        sideways = sqrt(east * east + north * north)
        most = up * self._max_lean
        if sideways > most:
            east *= most / sideways
            north *= most / sideways
            sideways = most

        # The body's axes in the world: (r11, r21, r31) is its x, (r13, r23, r33) its z.
        xx, yy, zz = 2.0 * qx * qx, 2.0 * qy * qy, 2.0 * qz * qz
        xy, xz, yz = 2.0 * qx * qy, 2.0 * qx * qz, 2.0 * qy * qz
        xw, yw, zw = 2.0 * qx * qw, 2.0 * qy * qw, 2.0 * qz * qw
        r11, r21, r31 = 1.0 - yy - zz, xy + zw, xz - yw
        r12, r22, r32 = xy - zw, 1.0 - xx - zz, yz + xw
        r33 = 1.0 - xx - yy

        thrust = self._mass * up / (r33 if r33 > _LEAST_LIFT else _LEAST_LIFT)
        if thrust > self._max_thrust:  # noqa: PLR1730 - min() takes thrice as long
            thrust = self._max_thrust

        # Tilt → torques: turn the body's z into the thrust's direction.
        size = sqrt(sideways * sideways + up * up)
        lean_x = (r11 * east + r21 * north + r31 * up) / size
        lean_y = (r12 * east + r22 * north + r32 * up) / size
        tx = -self._level_x * lean_y - self._damp_x * (r11 * wx + r21 * wy + r31 * wz)
        ty = self._level_y * lean_x - self._damp_y * (r12 * wx + r22 * wy + r32 * wz)
        limit = self._max_lean_torque
        tx = limit if tx > limit else -limit if tx < -limit else tx
        ty = limit if ty > limit else -limit if ty < -limit else ty

        # Turn rate → torque about the body's z.
        turning = (xz + yw) * wx + (yz - xw) * wy + r33 * wz
        tz = self._turn_push * (self._want_rate - turning)
        limit = self._max_turn_torque
        tz = limit if tz > limit else -limit if tz < -limit else tz
        return thrust, tx, ty, tz


def _clamped(value: float, most: float) -> float:
    return max(-most, min(most, value))


def _approach(off: float, gain: float, brake: float) -> float:
    """The speed at which to close a distance: proportional when near, beyond that never faster
    than a deceleration can stop (the square-root controller of ArduPilot's ``AC_PosControl``).
    """
    near = brake / (gain * gain)
    if off > near:
        return sqrt(2.0 * brake * (off - near / 2.0))
    if off < -near:
        return -sqrt(2.0 * brake * (-off - near / 2.0))
    return off * gain
