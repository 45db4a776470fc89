"""Functions that every mission may `call`: limits, lights, battery, cameras of its own vehicle.

A refusal by the vehicle becomes ``error.execution`` in the mission.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from behaviors.channel import PICTURE_NAME, Channel
from fsm.host import Function, Parameter
from fsm.values.functions import EvaluationError
from fsm.values.types import TEXT, Number, Text
from hal.base import not_to_be_swapped
from hal.lights import COLORS, PATTERNS, Lights
from hal.limits import DIMENSIONS, Limits
from hal.orders import Order
from hal.vehicle import Unavailable
from vencejo.errors import UserError, nearest
from vencejo.units import FREQUENCY, TIME


def set_limits(channel: Channel, profile: str | None = None, **limits: float) -> None:
    """Change limits of flight: a named profile of the vehicle, single limits, or both.

    Altitudes are above home. Raises EvaluationError when the vehicle refuses them.
    """
    wanted = Limits(**limits)
    try:
        if profile is not None:
            wanted = wanted.over(profile_of(channel, profile))
        answer = channel.configure(wanted)
    except UserError as error:
        raise EvaluationError(error.faults[0].message) from None
    if not answer.accepted:
        raise EvaluationError(f"limits refused: {answer.reason}")


def profile_of(channel: Channel, name: str) -> Limits:
    """The vehicle's limits of that name. Raises EvaluationError when it has none."""
    profiles = channel.vehicle.profiles
    if name not in profiles:
        hint = nearest(name, profiles, "this vehicle has none")
        raise EvaluationError(f"there is no profile '{name}' ({hint})")
    return profiles[name]


def show_lights(channel: Channel, **settings: Any) -> None:
    """Show a pattern on the vehicle's lamps. Raises EvaluationError where it has none."""
    try:
        channel.vehicle.lights(Lights(**settings))
    except UserError as error:
        raise EvaluationError(error.faults[0].message) from None
    except Unavailable as error:
        raise EvaluationError(str(error)) from None


def swap_battery(channel: Channel) -> Order:
    """Take a full battery. Raises EvaluationError where that cannot be done now."""
    seen = channel.observation
    reason = not_to_be_swapped(aloft=seen.flying, armed=seen.armed)
    if reason:
        raise EvaluationError(f"the battery cannot be swapped now: {reason}")
    try:
        return channel.vehicle.swap_battery()
    except Unavailable as error:
        raise EvaluationError(str(error)) from None


def use_camera(channel: Channel, name: str) -> None:
    """Make a camera the active one, or with ``toggle`` the next one. Raises EvaluationError."""
    try:
        channel.vehicle.use_camera(None if name == TOGGLE else name)
    except Unavailable as error:
        raise EvaluationError(str(error)) from None


def save_picture(channel: Channel, name: str, camera: str | None = None) -> None:
    """Keep the newest frame of a camera, without one of the active camera, as a photo.

    Raises EvaluationError for a name that no file gets, and where there is no such camera or frame.
    """
    if not PICTURE_NAME.fullmatch(name):
        raise EvaluationError(
            f"'{name:.70}' is no name of a picture: up to 64 letters, digits, _, -"
        )
    chosen = camera or channel.vehicle.active_camera
    if chosen is None:
        raise EvaluationError("all cameras are active: say which `camera` the picture is of")
    try:
        frame = channel.camera(chosen).latest()
    except Unavailable as error:
        raise EvaluationError(str(error)) from None
    if frame is None:
        raise EvaluationError(f"the camera '{chosen}' has taken no picture yet")
    channel.on_photo(name, chosen, frame)


TOGGLE = "toggle"
"""The word for the camera after the active one."""
HostFunction = Callable[..., Order | None]
"""Gives its order, where the vehicle may still refuse it."""
HOST_FUNCTIONS: Mapping[str, tuple[Function, HostFunction]] = MappingProxyType(
    {
        "limits": (
            Function(
                "limits",
                "Change limits of flight: a profile of the vehicle (indoor, outdoor), or single "
                "limits. Altitudes are above home; what the vehicle refuses is error.execution.",
                {
                    "profile": Parameter("profile", TEXT),
                    **{name: Parameter(name, Number(unit)) for name, unit in DIMENSIONS.items()},
                },
            ),
            set_limits,
        ),
        "lights": (
            Function(
                "lights",
                "Show a pattern on the vehicle's lamps; without a duration it stays.",
                {
                    "pattern": Parameter("pattern", Text(PATTERNS), "standard"),
                    "color": Parameter("color", Text(tuple(COLORS)), "white"),
                    "rate": Parameter("rate", Number(FREQUENCY, 0.0, 20.0), 1.0),
                    "duration": Parameter("duration", Number(TIME, 0.0)),
                },
            ),
            show_lights,
        ),
        "swap_battery": (
            Function(
                "swap_battery",
                "Take a full battery: on the ground with the motors off, otherwise it is "
                "error.execution. Needs the capability battery.swap.",
            ),
            swap_battery,
        ),
        "camera": (
            Function(
                "camera",
                "Make a camera the active one, or with toggle the next one, on a vehicle that has "
                "one active at a time; where all are active nothing happens.",
                {"name": Parameter("name", TEXT, required=True)},
            ),
            use_camera,
        ),
        "save_picture": (
            Function(
                "save_picture",
                "Keep the newest picture of the active camera, or of the one named, under a name "
                "in the run folder's photos.",
                {
                    "name": Parameter("name", TEXT, required=True),
                    "camera": Parameter("camera", TEXT),
                },
            ),
            save_picture,
        ),
    }
)
"""The functions that missions may call, by name: the declaration and the implementation."""
