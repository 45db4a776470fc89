"""The flight controller: from position and velocity set-points to thrust and torques.

A cascade in plain floats: position → velocity (with feed-forward) once each mission period, then
velocity → acceleration → tilt and thrust → torques at every physics step. The thrust carries the
load factor 1/cos(tilt), as in the sum-of-rotors controllers of Gazebo's quadrotors; tilt, speed,
climb and turn rate are limited.
"""

from __future__ import annotations

from math import hypot, inf, sqrt, tan

from hal.sim.model import Model
from hal.sim.physics import GRAVITY, BodyState, Triple
from vencejo.geometry import rotate_xy, wrap, yaw_of

_POSITION_GAIN = 1.8
"""Proportional gain from position error to speed, 1/s."""
_DECELERATION = 2.0
"""Deceleration planned for the approach to a place, m/s²."""
_VELOCITY_GAIN = 6.0
"""Proportional gain from velocity error to acceleration, 1/s."""
_MAX_SINK, _MAX_RISE = -5.0, 6.0
"""Bounds of the vertical acceleration, m/s²."""
_TILT_GAIN, _TILT_DAMPING = 625.0, 50.0
"""Gains from tilt error, 1/s², and from angular velocity, 1/s, to angular acceleration: critically
damped at 25 rad/s."""
_YAW_GAIN, _YAW_DECELERATION, _YAW_RATE_GAIN = 3.0, 4.0, 15.0
"""The same three for the heading: position gain, 1/s; deceleration, rad/s²; rate gain, 1/s."""
_YAW_STOPPED = 0.05
"""Turn rate below which a turn has ended and the heading is held, rad/s."""
_LEAST_COSINE = 0.5
"""Cosine of the tilt above which the load factor is no longer increased."""
_LEAST_THRUST = 1e-6
"""Share of the largest thrust: with none at all its direction, the tilt, would not be defined."""


class Controller:
    """Computes the thrust and torques by which a vehicle follows its set-points.

    Heights are those of the skids, as in everything that the simulator reports.
    """

    __slots__ = (
        "_center_height", "_damping_x", "_damping_y", "_gain_x", "_gain_y", "_in_heading_frame",
        "_mass", "_max_thrust", "_max_tilt", "_max_tilt_tan", "_max_tilt_torque",
        "_max_yaw_torque", "_place", "_target_vx", "_target_vy", "_target_vz", "_target_yaw_rate",
        "_thrust", "_tilt", "_velocity", "_world_tilt", "_yaw", "_yaw_rate", "_yaw_rate_gain",
        "acceleration", "height", "max_altitude", "max_climb", "max_speed", "max_yaw_rate",
        "min_altitude", "noise",
    )  # fmt: skip

    def __init__(self, model: Model) -> None:
        self._center_height = model.height
        self._mass = model.mass
        self._max_thrust = model.max_thrust
        self._max_tilt_torque, self._max_yaw_torque = model.max_torques
        ix, iy, iz = model.inertia
        self._gain_x, self._damping_x = ix * _TILT_GAIN, ix * _TILT_DAMPING
        self._gain_y, self._damping_y = iy * _TILT_GAIN, iy * _TILT_DAMPING
        self._yaw_rate_gain = iz * _YAW_RATE_GAIN
        self.max_speed = model.max_speed
        self.max_climb = model.max_climb
        self._max_tilt_tan = 0.0
        """Tangent of the largest tilt: horizontal over vertical part of the thrust."""
        self.max_tilt = model.max_tilt
        self.max_yaw_rate = model.max_yaw_rate
        self.min_altitude, self.max_altitude = -inf, inf
        self.noise = (0.0, 0.0, 0.0)
        """Noise added to the target velocity, world frame, m/s."""
        self.acceleration = (0.0, 0.0, 0.0)
        """Feed-forward acceleration of a moving place in this mission period, m/s²."""
        self.height: float | None = None
        """Target height, world frame, metres; None to climb at the target velocity alone."""
        self._place: tuple[float, float] | None = None
        self._tilt: tuple[float, float] | None = None
        """Target when flown by tilt: forward and left part of the thrust over the vertical one."""
        self._world_tilt: tuple[float, float] | None = None
        """The same in the world frame, east and north, for this mission period."""
        self._thrust: float | None = None
        """Thrust when flown by tilt, newtons; None to climb instead."""
        self._velocity = (0.0, 0.0, 0.0)
        self._in_heading_frame = False
        self._yaw: float | None = None
        self._yaw_rate = 0.0
        self._target_vx = self._target_vy = self._target_vz = self._target_yaw_rate = 0.0

    @property
    def max_tilt(self) -> float:
        """The largest tilt, radians."""
        return self._max_tilt

    @max_tilt.setter
    def max_tilt(self, tilt: float) -> None:
        self._max_tilt = tilt
        self._max_tilt_tan = tan(tilt)

    # Targets.

    def fly_to(self, x: float, y: float, z: float, velocity: Triple = (0.0, 0.0, 0.0)) -> None:
        """Fly to a place, with the velocity of a place that moves as feed-forward."""
        self._place = (x, y)
        self.height = z
        self._velocity = velocity
        self._in_heading_frame = False
        self._tilt = None

    def fly_at(self, x: float, y: float, z: float, in_heading: bool = False) -> None:
        """Fly at a velocity, m/s: (east, north, up), or (forward, left, up) of the heading."""
        self._place = self.height = None
        self._velocity = (x, y, z)
        self._in_heading_frame = in_heading
        self._tilt = None

    def tilt(self, roll: float, pitch: float, climb: float, thrust: float | None = None) -> None:
        """Fly by tilt: roll (right side down) and pitch (nose down), radians.

        ``climb`` is in m/s; ``thrust``, a share (0 to 1) of the largest thrust, replaces it.
        """
        self._place = self.height = None
        self._velocity = (0.0, 0.0, climb)
        self._in_heading_frame = False
        self._tilt = tan(_clamped(pitch, self.max_tilt)), -tan(_clamped(roll, self.max_tilt))
        if thrust is not None:
            thrust = max(_LEAST_THRUST, min(1.0, thrust)) * self._max_thrust
        self._thrust = thrust

    def stay_over(self, x: float, y: float) -> None:
        """Fly to a horizontal position; the vertical target stays."""
        self._place = (x, y)
        self._velocity = (0.0, 0.0, self._velocity[2])

    def climb_at(self, speed: float) -> None:
        """Climb at a speed, m/s; the horizontal target stays."""
        self.height = None
        self._velocity = (*self._velocity[:2], speed)

    def turn(self, rate: float) -> None:
        """Turn at a rate, rad/s; at zero, stop turning and hold the heading."""
        if rate != 0.0 or self._yaw_rate != 0.0:
            self._yaw = None
        self._yaw_rate = rate

    def face(self, yaw: float) -> None:
        """Turn to a heading, radians, in the shorter direction."""
        self._yaw = yaw
        self._yaw_rate = 0.0

    # Control.

    def plan(self, state: BodyState) -> None:
        """Compute the target velocity and turn rate of a mission period."""
        (x, y, z), attitude, _, turning = state
        z -= self._center_height
        yaw = yaw_of(attitude)

        vx, vy, vz = self._velocity
        if self._place is not None:
            dx, dy = self._place[0] - x, self._place[1] - y
            distance = hypot(dx, dy)
            approach = _approach_speed(distance, _POSITION_GAIN, _DECELERATION)
            gain = approach / distance if distance else 0.0
            vx += dx * gain
            vy += dy * gain
        elif self._in_heading_frame:
            vx, vy = rotate_xy(vx, vy, yaw)
        speed = hypot(vx, vy)
        if speed > self.max_speed:
            vx *= self.max_speed / speed
            vy *= self.max_speed / speed

        if self.height is not None:
            vz += _approach_speed(self.height - z, _POSITION_GAIN, _DECELERATION)
        if self.min_altitude > -inf:
            vz = max(vz, _approach_speed(self.min_altitude - z, _POSITION_GAIN, _DECELERATION))
        if self.max_altitude < inf:
            vz = min(vz, _approach_speed(self.max_altitude - z, _POSITION_GAIN, _DECELERATION))
        vz = max(-self.max_climb, min(self.max_climb, vz))

        noise_x, noise_y, noise_z = self.noise
        self._target_vx, self._target_vy, self._target_vz = (
            vx + noise_x,
            vy + noise_y,
            vz + noise_z,
        )

        self._world_tilt = None if self._tilt is None else rotate_xy(*self._tilt, yaw)

        rate = self._yaw_rate
        if rate == 0.0 and self._yaw is None and abs(turning[2]) < _YAW_STOPPED:
            self._yaw = yaw
        if self._yaw is not None:
            rate = _approach_speed(wrap(self._yaw - yaw), _YAW_GAIN, _YAW_DECELERATION)
        self._target_yaw_rate = max(-self.max_yaw_rate, min(self.max_yaw_rate, rate))

    def step(self, state: BodyState) -> tuple[float, float, float, float]:
        """Thrust (N) and torques about the body's axes (N·m) for the next physics step."""
        _, (qx, qy, qz, qw), (vx, vy, vz), (wx, wy, wz) = state

        # Velocity → acceleration → the direction and size of the thrust.
        east, north, up = self.acceleration
        up += (self._target_vz - vz) * _VELOCITY_GAIN
        up = GRAVITY + (_MAX_RISE if up > _MAX_RISE else _MAX_SINK if up < _MAX_SINK else up)
        tilt = self._world_tilt
        if tilt is None:
            east += (self._target_vx - vx) * _VELOCITY_GAIN
            north += (self._target_vy - vy) * _VELOCITY_GAIN
        else:
            if self._thrust is not None:
                up = self._thrust / self._mass * max(_LEAST_COSINE, 1.0 - 2.0 * (qx * qx + qy * qy))
            east, north = up * tilt[0], up * tilt[1]
        sideways = sqrt(east * east + north * north)
        most = up * self._max_tilt_tan
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

        thrust = self._mass * up / (r33 if r33 > _LEAST_COSINE else _LEAST_COSINE)
        if thrust > self._max_thrust:  # noqa: PLR1730 - min() takes thrice as long
            thrust = self._max_thrust

        # Tilt → torques: turn the body's z into the thrust's direction, here in the body's axes.
        size = sqrt(sideways * sideways + up * up)
        direction_x = (r11 * east + r21 * north + r31 * up) / size
        direction_y = (r12 * east + r22 * north + r32 * up) / size
        tx = -self._gain_x * direction_y - self._damping_x * (r11 * wx + r21 * wy + r31 * wz)
        ty = self._gain_y * direction_x - self._damping_y * (r12 * wx + r22 * wy + r32 * wz)
        limit = self._max_tilt_torque
        tx = limit if tx > limit else -limit if tx < -limit else tx
        ty = limit if ty > limit else -limit if ty < -limit else ty

        # Turn rate → torque about the body's z.
        turning = (xz + yw) * wx + (yz - xw) * wy + r33 * wz
        tz = self._yaw_rate_gain * (self._target_yaw_rate - turning)
        limit = self._max_yaw_torque
        tz = limit if tz > limit else -limit if tz < -limit else tz
        return thrust, tx, ty, tz


def _clamped(value: float, most: float) -> float:
    return max(-most, min(most, value))


def _approach_speed(distance: float, gain: float, deceleration: float) -> float:
    """The speed of approach at a distance, with the sign of the distance.

    It is ``gain`` times the distance when near; farther away it is the speed from which
    ``deceleration`` stops in time (the square-root controller of ArduPilot's ``AC_PosControl``).
    """
    near = deceleration / (gain * gain)
    if distance > near:
        return sqrt(2.0 * deceleration * (distance - near / 2.0))
    if distance < -near:
        return -sqrt(2.0 * deceleration * (-distance - near / 2.0))
    return distance * gain
