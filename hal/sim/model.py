"""The model of a quadrotor: the constants of its body, rotors, drag and battery, and its limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import cos, pi, sqrt
from types import MappingProxyType

from hal.limits import Limits
from hal.scene.appearance import ARM, SIZE
from hal.sim.physics import GRAVITY

AIR_DENSITY = 1.225
"""kg/m³, at sea level (ISO 2533, the standard atmosphere)."""

PROFILES: Mapping[str, Limits] = MappingProxyType(
    {
        "indoor": Limits(2.0, 0.7, 0.21, 1.75, 0.05, 3.0),
        "outdoor": Limits(5.0, 2.0, 20 * pi / 180, 3.5, 0.05, 100.0),
    }
)
"""Limits for flying in a room and outside. Indoors: the example configuration of the published
AR.Drone simulation (``altitude_min``, ``altitude_max``, ``euler_angle_max``, ``control_vz_max``,
``control_yaw``); the speed there, and all figures for outside, are assumed."""


@dataclass(frozen=True)
class Rotors:
    """Four equal rotors at the corners of a square, in an X about straight ahead."""

    arm: float = ARM
    """Distance from the centre to a rotor's axis, metres."""
    radius: float = 0.1
    """Metres."""
    max_thrust: float = 8.5 / 4
    """Of one rotor at a full battery, newtons."""
    idle_thrust: float = 0.05
    """The least thrust while the motors run, as a share of the largest."""
    drag_ratio: float = 0.0301
    """The torque about a rotor's axis over its thrust, metres."""
    time_constant: float = 0.02
    """Of the thrust, which follows the command as a first-order lag, seconds."""
    efficiency: float = 0.3258
    """Ideal (momentum theory) over electrical power: rotor, motor and its controller."""

    @property
    def area(self) -> float:
        """Of all four discs, m²."""
        return 4 * pi * self.radius * self.radius


@dataclass(frozen=True)
class Drag:
    """How air holds a vehicle up."""

    area: float = 0.005
    """Drag coefficient times frontal area, the same from all sides, m²."""
    rotors: float = 0.25
    """Drag of the turning rotors per speed across their axes, N/(m/s)."""


@dataclass(frozen=True)
class BatteryPack:
    """A battery: a voltage that falls in a straight line with the charge, behind a resistance.

    Its charge is the share of the energy that is left, 0 to 1.
    """

    energy: float = 11.1 * 3600
    """In a full one, joules: 1000 mAh at 11.1 V."""
    full: float = 12.6
    """Voltage without load when full, volts."""
    empty: float = 9.6
    """Voltage without load when empty, volts."""
    resistance: float = 0.06
    """Ohms."""
    standby: float = 5.0
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

    def drain(self, power: float, charge: float) -> float:
        """How fast a power (watts) takes the charge, with what the resistance takes, 1/s."""
        return self.current(power, charge) * self.voltage(charge) / self.energy


@dataclass(frozen=True)
class Model:
    """A quadrotor. Body axes are FLU about the centre of mass, in the middle of its box."""

    name: str = "ardrone2"
    mass: float = 0.436
    """kg, with battery and hull."""
    inertia: tuple[float, float, float] = (2.237568e-3, 2.985236e-3, 4.80374e-3)
    """About the body's x, y and z, kg·m²."""
    size: tuple[float, float, float] = SIZE
    """The box that collides with things, hull included, along the body's axes, metres."""
    rotors: Rotors = Rotors()
    drag: Drag = Drag()
    battery: BatteryPack = BatteryPack()
    max_speed: float = 5.0
    """Over the ground, m/s (the maker's figure)."""
    max_climb: float = 2.0
    """Up or down, m/s (the maker allows 0.7 indoors and 2 outdoors)."""
    max_tilt: float = 20 * pi / 180
    """Radians; within the maker's `euler_angle_max` of 0.52."""
    max_yaw_rate: float = 1.75
    """rad/s (the reference's `control_yaw`)."""
    profiles: Mapping[str, Limits] = field(default_factory=lambda: PROFILES)
    """Named limits, altitudes above home."""
    steepest_ground: float = 25 * pi / 180
    """Steepest slope on which it stands, radians (its skids slide from 32° on)."""
    withstands: float = 5.0
    """Largest speed of an impact that stops no rotor, m/s."""

    @property
    def height(self) -> float:
        """Height of the centre of mass above the skids, metres."""
        return self.size[2] / 2

    @property
    def weight(self) -> float:
        """Newtons."""
        return self.mass * GRAVITY

    @property
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
        drains = (self.battery.drain(self.hover_power, (k + 0.5) / 100) for k in range(100))
        return sum(0.01 / drain for drain in drains)


ARDRONE2 = Model()
"""The AR.Drone 2.0 with its indoor hull. Inertia and arm: Q. Li, *Grey-box system identification of
a quadrotor unmanned aerial vehicle*, TU Delft 2014; rotor drag: 0.58 1/s times the mass, as in
J. Engel et al., *Camera-based navigation of a low-cost quadrocopter*, IROS 2012; efficiency: that
of the maker's 12 minutes in the air. All else is assumed."""
