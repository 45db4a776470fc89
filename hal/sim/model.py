"""The model of a quadrotor: the constants of its body, rotors, drag and battery, and its limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import cos, hypot, pi, sqrt

from hal.limits import Limits
from hal.sim.physics import GRAVITY
from hal.sim.sensors.camera_spec import CameraSpec
from worlds.things import Color

AIR_DENSITY = 1.225
"""kg/m³, at sea level (ISO 2533, the standard atmosphere)."""


@dataclass(frozen=True)
class Rotors:
    """Four equal rotors at the corners of a square, in an X about straight ahead."""

    arm: float
    """Distance from the centre to a rotor's axis, metres."""
    radius: float
    """Metres."""
    max_thrust: float
    """Of one rotor at a full battery, newtons."""
    idle_thrust: float
    """The least thrust while the motors run, as a share of the largest."""
    drag_ratio: float
    """The torque about a rotor's axis over its thrust, metres."""
    time_constant: float
    """Of the thrust, which follows the command as a first-order lag, seconds."""
    efficiency: float
    """Ideal (momentum theory) over electrical power: rotor, motor and its controller."""

    @cached_property
    def area(self) -> float:
        """Of all four discs, m²."""
        return 4 * pi * self.radius * self.radius


@dataclass(frozen=True)
class Drag:
    """How air holds a vehicle up."""

    area: float
    """Drag coefficient times frontal area, the same from all sides, m²."""
    rotors: float
    """Drag of the turning rotors per speed across their axes, N/(m/s)."""


@dataclass(frozen=True)
class BatteryPack:
    """A battery: a voltage that falls in a straight line with the charge, behind a resistance.

    Its charge is the share of the energy that is left, 0 to 1.
    """

    energy: float
    """In a full one, joules."""
    full: float
    """Voltage without load when full, volts."""
    empty: float
    """Voltage without load when empty, volts."""
    resistance: float
    """Ohms."""
    standby: float
    """Power that the board draws with the motors off, watts."""

    def voltage(self, charge: float) -> float:
        """Without load, volts."""
        return self.empty + (self.full - self.empty) * charge

    def current(self, power: float, charge: float) -> float:
        """The current that gives a power (watts), amperes.

        The smaller root I of P = (V - I·R)·I; where there is none the largest power is given.
        """
        voltage = self.voltage(charge)
        if self.resistance == 0.0:
            return power / voltage
        root = sqrt(max(0.0, voltage * voltage - 4 * self.resistance * power))
        return (voltage - root) / (2 * self.resistance)

    def drain(self, current: float, charge: float) -> float:
        """How fast a current (amperes) takes the charge, with what the resistance takes, 1/s."""
        return current * self.voltage(charge) / self.energy


@dataclass(frozen=True)
class Model:
    """A quadrotor. Body axes are FLU about the centre of mass, in the middle of its box."""

    name: str
    description: str
    mass: float
    """kg, with battery and hull."""
    inertia: tuple[float, float, float]
    """About the body's x, y and z, kg·m²."""
    size: tuple[float, float, float]
    """The box that collides with things, hull included, along the body's axes, metres."""
    rotors: Rotors
    drag: Drag
    battery: BatteryPack
    max_speed: float
    """Over the ground, m/s."""
    max_climb: float
    """Up or down, m/s."""
    max_tilt: float
    """Radians."""
    max_yaw_rate: float
    """rad/s."""
    profiles: Mapping[str, Limits]
    """Named limits, altitudes above home."""
    steepest_ground: float
    """Steepest slope on which it stands, radians."""
    withstands: float
    """Largest speed of an impact that stops no rotor, m/s."""
    cameras: Mapping[str, CameraSpec]
    """Its cameras by name, the first one active at first."""
    one_active_camera: bool
    """Whether only one of them delivers images at a time."""
    estimates_wind: bool
    """Whether it tells what the wind is (capability ``wind``)."""
    color: Color | None
    """Of its hull; None for one that its name decides."""

    @cached_property
    def height(self) -> float:
        """Height of the centre of mass above the skids, metres."""
        return self.size[2] / 2

    @cached_property
    def reach(self) -> float:
        """How far it reaches from its centre of mass, metres."""
        return hypot(*self.size) / 2

    @property
    def weight(self) -> float:
        """Newtons."""
        return self.mass * GRAVITY

    @cached_property
    def max_thrust(self) -> float:
        """Of all four rotors at a full battery, newtons."""
        return 4 * self.rotors.max_thrust

    @cached_property
    def steepest(self) -> float:
        """Upper bound of the tilt limit, radians: up to there the thrust carries the weight, with
        a twentieth of it to spare.
        """
        for degrees in range(60, 0, -1):
            if self.max_thrust * cos(degrees * pi / 180) >= 1.05 * self.weight:
                return degrees * pi / 180
        return 0.0

    @property
    def max_torques(self) -> tuple[float, float]:
        """Largest torques about a horizontal body axis and about z, N·m.

        Half of the maximum thrust is available for it, by two rotors.
        """
        half = self.max_thrust / 2
        return half * self.rotors.arm / 2, half * self.rotors.drag_ratio

    @property
    def hover_power(self) -> float:
        """Electrical power in hover in still air, far from the ground, watts (momentum theory)."""
        induced = sqrt(self.weight / (2 * AIR_DENSITY * self.rotors.area))
        return self.battery.standby + self.weight * induced / self.rotors.efficiency

    @cached_property
    def endurance(self) -> float:
        """Seconds of hovering on a full battery: the sum over a hundred parts of its charge."""
        pack, power = self.battery, self.hover_power
        charges = ((k + 0.5) / 100 for k in range(100))
        drains = (pack.drain(pack.current(power, charge), charge) for charge in charges)
        return sum(0.01 / drain for drain in drains)
