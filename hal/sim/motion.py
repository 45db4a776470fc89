"""The equations of motion of a vehicle in the air, in plain floats.

    m·dv/dt = R·f - m·g·z        I·dω/dt = t - ω × (I·ω)        dq/dt = q·(ω, 0)/2

with the force f and the torque t along the body's axes, R and q from body to world (R. Mahony et
al., *Multirotor aerial vehicles*, IEEE RAM 2012). A step is semi-implicit, as in the engines: the
new velocities move the body.
"""

from __future__ import annotations

from math import cos, sin, sqrt

from hal.sim.model import AIR_DENSITY, Model
from hal.sim.physics import GRAVITY, STEP, BodyState, Triple, in_body
from vencejo.geometry import Quaternion

_SPINS = 10.0
"""Angular speed from which a step keeps the angular momentum exactly, rad/s: from there on Euler's
method, which lengthens it a little at each step, would make a spin faster and faster."""
_ROUNDS = 3
"""Rounds in which the angular velocity in the middle of such a step is found."""
_FALL = GRAVITY * STEP
"""The velocity that gravity gives in a step, m/s."""
_HALF = STEP / 2
Axes = tuple[float, float, float, float, float, float, float, float, float]
"""The rotation from body to world, row by row; its columns are the body's axes in the world."""


def axes_of(attitude: Quaternion) -> Axes:
    """The rotation matrix of an attitude."""
    x, y, z, w = attitude
    x2, y2, z2 = x + x, y + y, z + z
    xx, yy, zz = x * x2, y * y2, z * z2
    xy, xz, yz = x * y2, x * z2, y * z2
    xw, yw, zw = w * x2, w * y2, w * z2
    return (
        1.0 - yy - zz, xy - zw, xz + yw,
        xy + zw, 1.0 - xx - zz, yz - xw,
        xz - yw, yz + xw, 1.0 - xx - yy,
    )  # fmt: skip


class Airflow:
    """The force of the air on a model, along the body's axes.

    The body's drag is ½·ρ·A·|v|·v; the turning rotors' is linear in the speed across their axes
    (M. Faessler, A. Franchi, D. Scaramuzza, *Differential flatness of quadrotor dynamics subject to
    rotor drag*, RA-L 2018).
    """

    def __init__(self, model: Model) -> None:
        self._body = AIR_DENSITY * model.drag.area / 2
        self._rotors = model.drag.rotors

    def force(self, axes: Axes, velocity: Triple, wind: Triple, turning: bool) -> Triple:
        """Newtons. ``velocity`` and ``wind`` in the world, m/s; ``turning`` rotors or not."""
        x, y, z = velocity[0] - wind[0], velocity[1] - wind[1], velocity[2] - wind[2]
        a, b, c, d, e, f, g, h, i = axes
        body = self._body * (x * x + y * y + z * z) ** 0.5
        across = body + self._rotors if turning else body
        return (
            -across * (a * x + d * y + g * z),
            -across * (b * x + e * y + h * z),
            -body * (c * x + f * y + i * z),
        )


class Motion:
    """Integrates the motion of a model."""

    def __init__(self, model: Model) -> None:
        self._per_mass = STEP / model.mass
        self._inertia = ix, iy, iz = model.inertia
        self._precession = iz - iy, ix - iz, iy - ix
        """What the angular velocity about two axes turns it by about the third, kg·m²."""
        self._per_inertia = (STEP / ix, STEP / iy, STEP / iz)

    def step(self, state: BodyState, axes: Axes, force: Triple, torque: Triple) -> BodyState:
        """The state a physics step later, under a force (N) and a torque (N·m) of the body's axes.

        ``axes`` are those of the state's attitude.
        """
        (px, py, pz), (qx, qy, qz, qw), (vx, vy, vz), (wx, wy, wz) = state
        a, b, c, d, e, f, g, h, i = axes
        fx, fy, fz = force
        per_mass = self._per_mass
        vx += (a * fx + b * fy + c * fz) * per_mass
        vy += (d * fx + e * fy + f * fz) * per_mass
        vz += (g * fx + h * fy + i * fz) * per_mass - _FALL

        about_x, about_y, about_z = self._precession
        per_x, per_y, per_z = self._per_inertia
        tx, ty, tz = torque
        if wx * wx + wy * wy + wz * wz > _SPINS * _SPINS:
            wx, wy, wz = self._spun((wx, wy, wz))
            wx, wy, wz = wx + tx * per_x, wy + ty * per_y, wz + tz * per_z
        else:
            wx, wy, wz = (
                wx + (tx - about_x * wy * wz) * per_x,
                wy + (ty - about_y * wz * wx) * per_y,
                wz + (tz - about_z * wx * wy) * per_z,
            )

        # The turn of the step as a quaternion, by the series of sine and cosine of half its angle;
        # the next power is below 1e-8 at 20 rad/s.
        hx, hy, hz = wx * _HALF, wy * _HALF, wz * _HALF
        square = hx * hx + hy * hy + hz * hz
        sine = 1.0 - square * (1 / 6 - square / 120)
        cosine = 1.0 - square * (0.5 - square / 24)
        hx, hy, hz = hx * sine, hy * sine, hz * sine
        x = qw * hx + qx * cosine + qy * hz - qz * hy
        y = qw * hy - qx * hz + qy * cosine + qz * hx
        z = qw * hz + qx * hy - qy * hx + qz * cosine
        w = qw * cosine - qx * hx - qy * hy - qz * hz
        # One round of Newton's method keeps its length at 1.
        scale = 1.5 - (x * x + y * y + z * z + w * w) / 2
        return (
            (px + vx * STEP, py + vy * STEP, pz + vz * STEP),
            (x * scale, y * scale, z * scale, w * scale),
            (vx, vy, vz),
            (wx, wy, wz),
        )

    def _spun(self, turning: Triple) -> Triple:
        """The angular velocity a step later without a torque, by the implicit midpoint rule.

        The angular momentum stays the same in the world: along the body's axes it is turned back by
        as much as the body turns.
        """
        (ix, iy, iz), (wx, wy, wz) = self._inertia, turning
        momentum = ix * wx, iy * wy, iz * wz
        x, y, z = turning
        for _ in range(_ROUNDS):
            size = sqrt(x * x + y * y + z * z)
            share = sin(size * STEP / 2) / size
            turn = x * share, y * share, z * share, cos(size * STEP / 2)
            mx, my, mz = in_body(momentum, turn)
            x, y, z = (wx + mx / ix) / 2, (wy + my / iy) / 2, (wz + mz / iz) / 2
        return mx / ix, my / iy, mz / iz
