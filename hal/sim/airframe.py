"""The airframe: a quadrotor of the AR.Drone 2.0's size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from types import MappingProxyType

from hal.limits import Limits
from hal.scene.appearance import ARM, SIZE

PROFILES: Mapping[str, Limits] = MappingProxyType(
    {
        "indoor": Limits(2.0, 0.7, 0.21, 1.75, 0.05, 3.0),
        "outdoor": Limits(5.0, 2.0, 20 * pi / 180, 3.5, 0.05, 100.0),
    }
)
"""Limits for flying in a room and outside. Indoors: the example configuration of the published
AR.Drone simulation (``altitude_min``, ``altitude_max``, ``euler_angle_max``, ``control_vz_max``,
``control_yaw``); the speed there, and all figures for outside, are assumed."""


@dataclass(frozen=True, slots=True)
class Airframe:
    """Constants of a quadrotor. Inertia and arm: Q. Li, *Grey-box system identification of a
    quadrotor unmanned aerial vehicle*, TU Delft 2014, identified on an AR.Drone 2.0.
    """

    mass: float = 0.436
    """kg, with battery and indoor hull."""
    inertia: tuple[float, float, float] = (2.237568e-3, 2.985236e-3, 4.80374e-3)
    """About the body's x, y and z, kg·m²."""
    arm: float = ARM
    """Distance from the centre to a motor, metres."""
    size: tuple[float, float, float] = SIZE
    """The box that collides with things, hull included, along the body's axes, metres."""
    max_thrust: float = 8.5
    """Total of the four motors, newtons; about twice the weight."""
    drag_ratio: float = 0.0301
    """A rotor's drag torque over its thrust, metres (2.423e-7 / 8.048e-6, as identified)."""
    max_speed: float = 5.0
    """Over the ground, m/s (the maker's figure)."""
    max_climb: float = 2.0
    """Up or down, m/s (the maker allows 0.7 indoors and 2 outdoors)."""
    max_tilt: float = 20 * pi / 180
    """Radians; within the maker's `euler_angle_max` of 0.52."""
    max_yaw_rate: float = 1.75
    """rad/s (the reference's `control_yaw`)."""
    capacity: float = 11.1 * 3600
    """Joules in a full battery: 1000 mAh at 11.1 V."""
    endurance: float = 12 * 60
    """Seconds of hovering on a full battery (the maker's figure)."""
    standby_power: float = 5.0
    """Power that the board draws with the motors off, watts (assumed)."""

    steepest_ground: float = 25 * pi / 180
    """Steepest slope on which it stands, radians (assumed; its skids slide from 32° on)."""
    steepest: float = 60 * pi / 180
    """Upper bound of the tilt limit, radians: the motors' thrust carries the weight up to there."""
    profiles: Mapping[str, Limits] = field(default_factory=lambda: PROFILES)
    """Named limits, altitudes above home."""

    @property
    def height(self) -> float:
        """Height of the centre of mass above the skids, metres."""
        return self.size[2] / 2

    @property
    def max_torques(self) -> tuple[float, float]:
        """Largest torques about a horizontal body axis and about z, N·m.

        Half of the maximum thrust is available for it, by two motors.
        """
        half = self.max_thrust / 2
        return half * self.arm / 2, half * self.drag_ratio
