"""The flight controller: from position and velocity set-points to thrust and torques.

A cascade in plain floats: position → velocity (with feed-forward) once each mission period, then
velocity → acceleration → tilt and thrust → torques at every physics step. The thrust carries the
load factor 1/cos(tilt), as in the sum-of-rotors controllers of Gazebo's quadrotors; tilt, speed,
climb and turn rate are limited.
"""

from __future__ import annotations

from math import exp, hypot, inf, sqrt, tan

from hal.sim.model import Model
from hal.sim.motion import Axes
from hal.sim.noise import NO_NOISE
from hal.sim.physics import GRAVITY, STEP, BodyState, Triple
from hal.sim.rotors import Wrench
from vencejo.geometry import rotate_xy, wrap, yaw_of

_POSITION_GAIN = 1.8
"""Proportional gain from position error to speed, 1/s."""
_DECELERATION = 2.0
"""Deceleration planned for the approach to a place, m/s²."""
_VELOCITY_GAIN = 6.0
"""Proportional gain from velocity error to acceleration, 1/s."""
_MAX_SINK, _MAX_RISE = -5.0, 6.0
"""Bounds of the vertical acceleration, m/s²."""
_TILT_RATE = 25.0
"""Natural frequency of the tilt under ideal rotors, rad/s; critically damped."""
_MOST_LEAD, _QUICKEST = 2.0, 0.6
"""Largest feedback of the angular acceleration, and the largest part of a rotor's lag that it may
make up for in one step."""
_RIGHTING = 0.3
"""Share of the largest torque with which it turns over when it is upside down."""
_OBSERVER = 20.0
"""Bandwidth of the disturbance observer, 1/s."""
_YAW_GAIN, _YAW_DECELERATION, _YAW_RATE_GAIN = 3.0, 4.0, 15.0
"""The same three for the heading: position gain, 1/s; deceleration, rad/s²; rate gain, 1/s."""
_YAW_STOPPED = 0.05
"""Turn rate below which a turn has ended and the heading is held, rad/s."""
_LEAST_UP = 1.0
"""Least vertical part of the thrust over the mass, m/s²: without any it has no direction."""
_LEAST_LIFT = 0.3
"""Vertical acceleration that the largest thrust leaves at the largest tilt, m/s²: where a battery
sags, height goes before place."""
_LEAST_COSINE = 0.5
"""Cosine of the tilt above which the load factor is no longer increased."""
_NOTHING = (0.0, 0.0, 0.0)
_LEAST_THRUST = 1e-6
"""Share of the largest thrust: with none at all its direction, the tilt, would not be defined."""


class Controller:
    """Computes the thrust and torques by which a vehicle follows its set-points.

    Heights are those of the skids, as in everything that the simulator reports.
    """

    def __init__(self, model: Model, lag: float = 0.0, *, observes: bool = False) -> None:
        """``lag``: time constant of the rotors, seconds; ``observes``: whether to estimate the
        forces that are not the rotors'.
        """
        self._estimates = observes
        self._center_height = model.height
        self._mass = model.mass
        self.max_thrust = model.max_thrust
        """Newtons (see :meth:`limit_thrust`)."""
        self._observes = False
        """True to estimate, in this mission period, the forces that are not the rotors'."""
        self._disturbance = self._disturbance_before = (0.0, 0.0, 0.0)
        """Acceleration by those forces, as estimated now and when the mission period began, m/s²,
        world frame."""
        self._expected: Triple | None = None
        """Velocity that the next step is to find without them, m/s."""
        ix, iy, iz = model.inertia
        gain, damping, lead = _tilt_gains(lag)
        self._gain_x, self._damping_x, self._lead_x = ix * gain, ix * damping, ix * lead / STEP
        self._gain_y, self._damping_y, self._lead_y = iy * gain, iy * damping, iy * lead / STEP
        self._righting = _RIGHTING * model.max_torques[0]
        """Largest torque upside down, where rotors that turn it over push it down, N·m."""
        self._turning = (0.0, 0.0)
        """Angular velocity about x and y in the last step, rad/s."""
        self._yaw_rate_gain = iz * _YAW_RATE_GAIN
        self.max_speed = model.max_speed
        self.max_climb = model.max_climb
        self._max_tilt_tan = 0.0
        """Tangent of the largest tilt: horizontal over vertical part of the thrust."""
        self.max_tilt = model.max_tilt
        self.max_yaw_rate = model.max_yaw_rate
        self.min_altitude, self.max_altitude = -inf, inf
        self.noise = NO_NOISE
        """Noise added to the target velocity and turn rate."""
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
        self._limit_tilt()

    def limit_thrust(self, thrust: float) -> None:
        """Set the largest thrust, newtons, and with it how far it can lean and keep its height."""
        self.max_thrust = thrust
        self._limit_tilt()

    def _limit_tilt(self) -> None:
        ratio = self.max_thrust / self._mass / (GRAVITY + _LEAST_LIFT)
        carried = sqrt(ratio * ratio - 1.0) if ratio > 1.0 else 0.0
        self._max_tilt_tan = min(tan(self._max_tilt), carried)

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
            thrust = max(_LEAST_THRUST, min(1.0, thrust)) * self.max_thrust
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
        vz = _clamped(vz, self.max_climb)

        noise_x, noise_y, noise_z, noise_yaw = self.noise
        if self._in_heading_frame:
            noise_x, noise_y = rotate_xy(noise_x, noise_y, yaw)
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
        self._target_yaw_rate = _clamped(rate, self.max_yaw_rate) + noise_yaw

    def step(self, state: BodyState, axes: Axes) -> Wrench:
        """The thrust (N) and the torques about the body's axes (N·m) wanted in the next step.

        ``axes`` are those of the state's attitude.
        """
        _, _, (vx, vy, vz), (wx, wy, wz) = state
        r11, r12, r13, r21, r22, r23, r31, r32, r33 = axes

        # Velocity → acceleration → the direction and size of the thrust.
        east, north, up = self.acceleration
        dx, dy, dz = self._observe(vx, vy, vz) if self._observes else self._disturbance
        up += (self._target_vz - vz) * _VELOCITY_GAIN
        up = _MAX_RISE if up > _MAX_RISE else _MAX_SINK if up < _MAX_SINK else up
        up += GRAVITY - dz
        up = _LEAST_UP if up < _LEAST_UP else up
        tilt = self._world_tilt
        if tilt is None:
            east += (self._target_vx - vx) * _VELOCITY_GAIN - dx
            north += (self._target_vy - vy) * _VELOCITY_GAIN - dy
        else:
            if self._thrust is not None:
                up = self._thrust / self._mass * (r33 if r33 > _LEAST_COSINE else _LEAST_COSINE)
            east, north = up * tilt[0], up * tilt[1]
        sideways = sqrt(east * east + north * north)
        most = up * self._max_tilt_tan
        if sideways > most:
            east *= most / sideways
            north *= most / sideways
            sideways = most

        thrust = self._mass * up / (r33 if r33 > _LEAST_COSINE else _LEAST_COSINE)
        thrust = self.max_thrust if thrust > self.max_thrust else thrust

        # Tilt → torques: turn the body's z into the thrust's direction, here in the body's axes.
        size = sqrt(sideways * sideways + up * up)
        direction_x = (r11 * east + r21 * north + r31 * up) / size
        direction_y = (r12 * east + r22 * north + r32 * up) / size
        limit = inf
        if r33 < 0.0:
            thrust, limit = 0.0, self._righting
            across = hypot(direction_x, direction_y)
            direction_x, direction_y = (
                (direction_x / across, direction_y / across) if across else (1.0, 0.0)
            )
        if self._estimates:
            push = thrust / self._mass * STEP
            self._expected = vx + r13 * push, vy + r23 * push, vz + r33 * push - GRAVITY * STEP
        last_x, last_y = self._turning
        self._turning = wx, wy
        tx = -self._gain_x * direction_y - self._damping_x * wx - self._lead_x * (wx - last_x)
        ty = self._gain_y * direction_x - self._damping_y * wy - self._lead_y * (wy - last_y)
        return (
            thrust,
            limit if tx > limit else -limit if tx < -limit else tx,
            limit if ty > limit else -limit if ty < -limit else ty,
            self._yaw_rate_gain * (self._target_yaw_rate - wz),
        )

    def _observe(self, vx: float, vy: float, vz: float) -> Triple:
        """The acceleration by forces that are not the rotors', m/s², world frame.

        A disturbance observer: the difference between the velocity that came and the one that was
        expected, through a first-order low-pass (K. Ohnishi, M. Shibata, T. Murakami, *Motion
        control for advanced mechatronics*, IEEE/ASME Trans. Mechatronics 1996).
        """
        if self._expected is None:
            return self._disturbance
        x, y, z = self._expected
        a, b, c = self._disturbance
        self._disturbance = disturbance = (
            a + (vx - x - a * STEP) * _OBSERVER,
            b + (vy - y - b * STEP) * _OBSERVER,
            c + (vz - z - c * STEP) * _OBSERVER,
        )
        return disturbance

    def expect(self, excess: float, axes: Axes) -> None:
        """Expect that much more thrust (N) in the next step than was wanted.

        That which the rotors give for the sake of tilt is no force of the air.
        """
        if self._expected is not None:
            (x, y, z), push = self._expected, excess / self._mass * STEP
            self._expected = x + axes[2] * push, y + axes[5] * push, z + axes[8] * push

    def observe(self, on: bool) -> None:
        """Begin a mission period with observation, or discard that of the last one.

        The forces of a contact end with it: they are nothing to make up for.
        """
        if on:
            self._disturbance_before = self._disturbance
        else:
            self._disturbance = self._disturbance_before
        self._observes = on and self._estimates

    def forget(self) -> None:
        """Forget what has been observed, since something else acts on the vehicle now."""
        self._disturbance = self._disturbance_before = _NOTHING
        self._expected, self._turning = None, (0.0, 0.0)


def _tilt_gains(lag: float) -> tuple[float, float, float]:
    """The gains from tilt error, 1/s², angular velocity, 1/s, and angular acceleration, 1, to
    angular acceleration.

    Feedback m of the angular acceleration makes a rotor's lag 1 + m times as short (as incremental
    nonlinear dynamic inversion does: E. Smeur et al., *Adaptive incremental nonlinear dynamic
    inversion*, JGCD 2016), as far as the steps allow. Behind the lag T that is left the tilt is of
    third order, T·s³ + s² + d·s + k. Its poles are placed at -w and, with a damping ratio of 0.7,
    at the natural frequency w, which makes w = 1/(2.4·T), d = w and k = w²/2.4; where that is more
    than under ideal rotors, d = 2·w and k = w².
    """
    gain, damping = _TILT_RATE * _TILT_RATE, 2.0 * _TILT_RATE
    if lag == 0.0:
        return gain, damping, 0.0
    lead = max(0.0, min(_MOST_LEAD, _QUICKEST / (1.0 - exp(-STEP / lag)) - 1.0))
    rate = (1.0 + lead) / (2.4 * lag)
    if rate < damping:
        gain, damping = rate * rate / 2.4, rate
    return gain * (1.0 + lead), damping * (1.0 + lead), lead


def _clamped(value: float, most: float) -> float:
    return -most if value < -most else most if value > most else value


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
