"""What no vehicle can be: the constants of a model that do not go together."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt
from typing import NamedTuple

from hal.sim.model import Model
from hal.sim.rotor_power import rotor_power

_RESERVE = 1.2
"""Least thrust over the weight."""
_DEGREE = pi / 180
_MOST_OVERLAP = 0.5
"""Of two neighbouring rotors, as a share of their radius: more leaves no air to the one below."""
_ROUNDED = 1e-6
"""Share by which a value may be beyond its bound, from being written in decimals."""


class Impossibility(NamedTuple):
    """One thing that cannot be."""

    path: tuple[str, ...]
    """The keys that lead to the value in a model's file."""
    message: str
    hint: str


def impossibilities(model: Model) -> Iterator[Impossibility]:
    """Why a model cannot be, from the most to the least of it; nothing for one that can."""
    yield from _of_inertia(model)
    yield from _of_rotors(model)
    yield from _of_thrust(model)
    yield from _of_battery(model)


def _of_inertia(model: Model) -> Iterator[Impossibility]:
    path = ("inertia",)
    for axis in range(3):
        own = model.inertia[axis]
        one, other = (model.inertia[(axis + k) % 3] for k in (1, 2))
        # Of any body Ix + Iy - Iz = 2 ∫ z² dm, and so about.
        if own > (one + other) * (1 + _ROUNDED):
            message = (
                f"no body has an inertia of {own:g} kg m² about {'xyz'[axis]}: it is more than "
            )
            message += f"about the two others together ({one + other:g} kg m²)"
            yield Impossibility(path, message, "about z it is the largest, and at most the sum")
            return
        sides = [side for other, side in enumerate(model.size) if other != axis]
        most = model.mass * (sides[0] ** 2 + sides[1] ** 2) / 4
        if own > most * (1 + _ROUNDED):
            message = f"{model.mass:g} kg in this box cannot have {own:g} kg m² about "
            message += f"{'xyz'[axis]}: with all of it in the corners it has {most:.3g} kg m²"
            yield Impossibility(path, message, "inertia is in kg m², and the size in metres")


def _of_rotors(model: Model) -> Iterator[Impossibility]:
    arm, radius = model.rotors.arm, model.rotors.radius
    out = arm / sqrt(2)
    if 2 * (radius - out) > _MOST_OVERLAP * radius:
        message = f"rotors of {radius:g} m radius on arms of {arm:g} m cover each other: "
        message += f"their axes are {2 * out:.3g} m apart"
        yield Impossibility(("rotors", "radius"), message, "arm and radius are of one rotor")
    side = min(model.size[:2])
    if 2 * (out + radius) > side * (1 + _ROUNDED):
        message = f"its rotors reach {2 * (out + radius):.3g} m from side to side, its box is "
        message += f"{side:g} m"
        yield Impossibility(("size",), message, "the size is that of the whole, rotors included")


def _of_thrust(model: Model) -> Iterator[Impossibility]:
    if model.max_thrust < _RESERVE * model.weight:
        message = f"it cannot hover: its four rotors give {model.max_thrust:.3g} N at most, and it "
        message += f"weighs {model.weight:.3g} N"
        hint = (
            f"max_thrust is of one rotor: {_RESERVE * model.weight / 4:.3g} N or more, to climb too"
        )
        yield Impossibility(("rotors", "max_thrust"), message, hint)
        return
    tilts: dict[tuple[str, ...], float] = {("limits", "max_tilt"): model.max_tilt}
    for name, limits in model.profiles.items():
        if limits.max_tilt is not None:
            tilts["profiles", name, "max_tilt"] = limits.max_tilt
    for path, tilt in tilts.items():
        if tilt > model.steepest * (1 + _ROUNDED):
            message = f"tilted by {tilt / _DEGREE:.3g} deg its rotors do not carry it: "
            message += f"{model.max_thrust:.3g} N for {model.weight:.3g} N"
            yield Impossibility(path, message, f"{model.steepest / _DEGREE:g} deg at most")


def _of_battery(model: Model) -> Iterator[Impossibility]:
    pack = model.battery
    if pack.empty >= pack.full:
        message = (
            f"an empty battery has less than a full one: not {pack.empty:g} V of {pack.full:g} V"
        )
        yield Impossibility(
            ("battery", "empty"), message, "both without load, of all cells together"
        )
        return
    hover = pack.standby + rotor_power(model.rotors, model.weight)
    if 4 * pack.resistance * hover > pack.empty**2:
        message = f"this battery cannot give the {hover:.3g} W that hovering takes"
        hint = f"its resistance: {pack.empty**2 / 4 / hover:.2g} ohm at most"
        yield Impossibility(("battery", "resistance"), message, hint)
