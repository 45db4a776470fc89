"""The dynamics of a vehicle: controller, rotors, air, and motion by an engine or in free flight."""

from __future__ import annotations

from math import hypot

from hal.sim.control import Controller
from hal.sim.effects import Effects
from hal.sim.model import Model
from hal.sim.motion import Airflow, Motion, axes_of
from hal.sim.physics import BodyState, Physics, Triple, in_body
from hal.sim.pose_history import PoseHistory
from hal.sim.rotor_power import rotor_power
from hal.sim.rotors import Drive, IdealDrive, RotorDrive
from hal.sim.starts import StartPose
from hal.vehicle import PERIOD
from vencejo.geometry import yaw_quaternion

STEPS_PER_PERIOD = 6
"""Physics steps in a mission period."""
_NEAR = 0.05
"""Width of the gap to another vehicle within which both are near each other, metres."""


class Dynamics:
    """Moves a vehicle: `begin_period`, then six times `drive`, the engine's step and `sense`.

    While nothing can touch the vehicle it is in free flight: `drive` then integrates its motion,
    and the engine's world is without it.
    """

    def __init__(
        self,
        name: str,
        physics: Physics,
        model: Model,
        effects: Effects,
        start: StartPose,
        pose_history: PoseHistory,
    ) -> None:
        self._model, self.effects = model, effects
        self.rotors = model.rotors
        self.body = physics.add_body(
            model.mass,
            model.inertia,
            model.size,
            (start.home.x, start.home.y, start.home.z + start.raised + model.height),
            yaw_quaternion(start.heading),
            name,
        )
        self.state: BodyState = self.body.state()
        self.pose_history = pose_history
        self._add_pose = self.pose_history.append
        self._add_pose(self.state)
        lag = model.rotors.time_constant if effects.rotors else 0.0
        self.controller = Controller(model, lag, observes=effects.rotors or effects.drag)
        self._drive: Drive = RotorDrive(model) if effects.rotors else IdealDrive(model)
        self._air_force = Airflow(model).force if effects.drag else None
        # The calls of each physics step, looked up once.
        self._control, self._rotate = self.controller.step, self._drive.step
        self._move = Motion(model).step
        self._read_state, self._push = self.body.state, self.body.push
        self.wind: Triple = (0.0, 0.0, 0.0)
        """Velocity of the air about it in this mission period, m/s, world frame."""
        self.velocity_before: Triple = (0.0, 0.0, 0.0)
        """Before the last physics step, m/s, world frame."""
        self.free = False
        """True in a mission period of free flight."""
        self._motors_run = False
        """In this mission period."""
        self._supported = True
        """Whether it stood on something when this mission period began."""
        self._ground_effect = 1.0
        """The thrust in this mission period over that far from the ground."""
        self._thrust_sum = 0.0
        """Sum of the thrust over the steps of the period, newtons."""
        self._reach = model.reach + _NEAR
        """Distance from its centre at which another vehicle is near, metres."""

    def can_meet(self, other: Dynamics) -> bool:
        """Whether two vehicles can touch in the next mission period."""
        (ax, ay, az), _, (au, av, aw), _ = self.state
        (bx, by, bz), _, (bu, bv, bw), _ = other.state
        x, y, z = ax - bx, ay - by, az - bz
        way = PERIOD * (abs(au - bu) + abs(av - bv) + abs(aw - bw))
        reach = self._reach + other._reach + way
        return x * x + y * y + z * z < reach * reach

    def begin_period(self, *, free: bool, motors_run: bool, supported: bool) -> None:
        """Begin a mission period, in free flight or not."""
        if free and not self.free:
            self.body.withdraw()
        elif self.free and not free:
            self.body.place(self.state)
        self.free, self._motors_run, self._supported = free, motors_run, supported
        self._thrust_sum = 0.0
        if not motors_run:
            self._drive.stop()
            self.controller.forget()

    @property
    def thrust(self) -> float:
        """Mean thrust of all rotors in the last mission period, newtons."""
        return self._thrust_sum / STEPS_PER_PERIOD

    def set_air(self, *, voltage: float, height: float, touched: bool) -> None:
        """Set what the thrust of this mission period depends on.

        ``voltage``: the battery's over that of a full one; ``height`` of the rotors above ground,
        metres; ``touched``: something holds it, so that the controller observes no forces.
        """
        controller, effects = self.controller, self.effects
        if effects.sag:
            self._drive.share = voltage * voltage
            controller.limit_thrust(self._model.max_thrust * self._drive.share)
        self._ground_effect = self._gain_at(height) if effects.ground_effect else 1.0
        controller.observe(not touched)

    def _gain_at(self, height: float) -> float:
        """The thrust at a height of the rotors above ground over that far from it.

        1 / (1 - (R/4h)²) for rotors of the radius R at the height h, which holds from h = R/2 on
        (I. C. Cheeseman, W. E. Bennett, *The effect of the ground on a helicopter rotor in forward
        flight*, ARC R&M 3021, 1955).
        """
        radius = self._model.rotors.radius
        ratio = radius / (4 * max(height, radius / 2))
        return 1 / (1 - ratio * ratio)

    def drive(self, steps: int = 1) -> None:
        """Apply the forces of the next physics step; in free flight, make so many steps."""
        free, motors_run, state = self.free, self._motors_run, self.state
        if self._supported and not motors_run and not free:
            return
        control, rotate, air_force = self._control, self._rotate, self._air_force
        wind, ground_effect = self.wind, self._ground_effect
        for _ in range(steps):
            self.velocity_before = state[2]
            axes = axes_of(state[1])
            x = y = z = fx = fy = fz = 0.0
            if motors_run:
                thrust, x, y, z = rotate(control(state, axes))
                if self._drive.excess:
                    self.controller.expect(self._drive.excess, axes)
                self._thrust_sum += thrust
                fz = thrust * ground_effect
            if air_force is not None:
                fx, fy, az = air_force(axes, state[2], wind, motors_run)
                fz += az
            if free:
                state = self._move(state, axes, (fx, fy, fz), (x, y, z))
                self._add_pose(state)
            else:
                self._push((fx, fy, fz), (x, y, z))
        self.state = state

    def sense(self) -> None:
        """Read the state after a physics step of the engine."""
        if not self.free:
            self.state = state = self._read_state()
            self._add_pose(state)

    def power(self, armed: bool) -> float:
        """Electrical power in this mission period, watts."""
        rotors, thrust = self.rotors, self.thrust
        standby = self._model.battery.standby
        if not self.effects.power:
            return standby + rotor_power(rotors, thrust)
        if not self._motors_run:
            idle = 4 * rotors.idle_thrust * rotors.max_thrust if armed else 0.0
            return standby + rotor_power(rotors, idle)
        _, attitude, (vx, vy, vz), _ = self.state
        x, y, z = self.wind
        across_x, across_y, climb = in_body((vx - x, vy - y, vz - z), attitude)
        return standby + rotor_power(rotors, thrust, climb, hypot(across_x, across_y))
