"""The settings of a run: all that can change its course, defaults included."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fsm.values.packing import pack, unpack
from hal.limits import Limits
from runner.by_vehicle import joined, vehicles_of
from runner.posts import Post, post_fields, post_of


@dataclass(frozen=True)
class MissionSettings:
    """The mission of one vehicle."""

    file: str
    """Its path in the run folder."""
    parameters: Mapping[str, Any]
    """The values of all its parameters."""


@dataclass(frozen=True)
class RunSettings:
    """All that can change the course of a run. Files are named by their path in its folder."""

    missions: Mapping[str, MissionSettings]
    """By the name of the vehicle that flies it."""
    world: str
    """The file of its world."""
    files: Mapping[str, str]
    """SHA-256 (hexadecimal) of every file that the flight depends on, by its path."""
    backend: str
    seed: int
    connect: str | None = None
    """Address of a real vehicle."""
    profile: str | None = None
    """Named limits of flight of the vehicle."""
    limits: Limits = field(default_factory=Limits)
    """Limits of flight that override the profile's, altitudes above home."""
    call_limit: float | None = None
    """Seconds that a call into people's code may take; None for any time."""
    camera_file: str | None = None
    post: tuple[Post, ...] = ()
    """Events that every mission was told, in the order of their times."""
    own: Mapping[str, Any] = field(default_factory=dict)
    """Settings of that backend only, such as the simulator's ``noise``."""


_RUN = ("seed", "backend", "connect", "profile", "limits", "call_limit", "camera_file")
"""Settings that stand in files as they are, but for limits."""
_ORDER = ("mission", "parameters", "vehicles", "world", *_RUN, "post")


def settings_fields(settings: RunSettings) -> dict[str, Any]:
    """The settings as an object for JSON: those of the backend stand among the others.

    Values of parameters that JSON does not have are packed (see :mod:`fsm.values.packing`).
    """
    vehicles = {
        vehicle: {"mission": mission.file, "parameters": pack(mission.parameters)}
        for vehicle, mission in settings.missions.items()
    }
    run = {name: getattr(settings, name) for name in ("world", *_RUN)}
    run |= {"limits": settings.limits.given(), "post": list(map(post_fields, settings.post))}
    ours = joined(vehicles, run, _ORDER)
    others = {name: value for name, value in settings.own.items() if name not in ours}
    return {**ours, **others, "files": dict(settings.files)}


def settings_of(fields: Mapping[str, Any]) -> RunSettings:
    """The settings in that object. Raises KeyError, TypeError and ValueError for any other."""
    known = {*_ORDER, "files"}
    return RunSettings(
        missions={
            vehicle: MissionSettings(mission["mission"], unpack(mission["parameters"]))
            for vehicle, mission in vehicles_of(fields).items()
        },
        world=fields["world"],
        files=fields["files"],
        **{name: fields[name] for name in _RUN if name != "limits"},
        limits=Limits(**fields["limits"]),
        post=tuple(map(post_of, fields["post"])),
        own={name: value for name, value in fields.items() if name not in known},
    )
