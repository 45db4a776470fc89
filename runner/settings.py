"""The settings of a run: all that can change its course, defaults included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fsm.values.packing import pack, unpack
from hal.lights import Rgb
from hal.limits import Limits
from runner.by_vehicle import joined, vehicles_of
from runner.posts import Post, post_fields, post_of
from runner.referee import Contest, contest_fields, contest_of
from vencejo.geometry import Point
from worlds import Start


@dataclass(frozen=True)
class MissionSettings:
    """The mission of one vehicle."""

    file: str
    """Its path in the run folder; empty for a vehicle without a mission."""
    parameters: Mapping[str, Any]
    """The values of all its parameters."""
    model: str | None = None
    """The vehicle's model: a name, or its file in the run folder; None for the default."""
    start: Start | None = None
    """The vehicle's start, world frame; None for one of the world's."""
    color: Rgb | None = None
    """The colour asked for its hull; None for its start's, its model's, or one that its name
    decides."""


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
    """Events that missions were told, in the order of their times."""
    fleet: str = ""
    """The name of the fleet; empty where none joins the vehicles."""
    fleet_file: str = ""
    """The fleet's own file."""
    until: str = ""
    """The condition that ends the flight of a fleet; empty for none."""
    referee: Contest | None = None
    """What the referee of a fleet looks at."""
    own: Mapping[str, Any] = field(default_factory=dict)
    """Settings of that backend only, such as the simulator's ``noise``."""


_RUN = ("seed", "backend", "connect", "profile", "limits", "call_limit", "camera_file")
"""Settings that stand in files as they are, but for limits."""
_FLEET = ("fleet", "fleet_file", "until")
_ASKED = ("model", "start", "color")
"""What may be asked of a vehicle."""
_ORDER = ("mission", "parameters", *_ASKED, *_FLEET, "referee", "vehicles", "world", *_RUN, "post")


def settings_fields(settings: RunSettings) -> dict[str, Any]:
    """The settings as an object for JSON: those of the backend stand among the others.

    Values of parameters that JSON does not have are packed (see :mod:`fsm.values.packing`).
    """
    vehicles = {
        vehicle: {
            "mission": mission.file or None,
            "parameters": pack(mission.parameters),
            **_asked_fields(mission),
        }
        for vehicle, mission in settings.missions.items()
    }
    run = {name: getattr(settings, name) for name in ("world", *_RUN)}
    run |= {name: getattr(settings, name) for name in _FLEET if getattr(settings, name)}
    if settings.referee is not None:
        run["referee"] = contest_fields(settings.referee)
    run |= {"limits": settings.limits.given(), "post": list(map(post_fields, settings.post))}
    ours = joined(vehicles, run, _ORDER)
    others = {name: value for name, value in settings.own.items() if name not in ours}
    return {**ours, **others, "files": dict(settings.files)}


def _asked_fields(mission: MissionSettings) -> dict[str, Any]:
    """What is asked of a vehicle, without what is not."""
    start = mission.start
    fields = {
        "model": mission.model,
        "start": {"at": list(start.at), "heading": start.heading} if start else None,
        "color": list(mission.color) if mission.color else None,
    }
    return {name: value for name, value in fields.items() if value is not None}


def _mission_of(fields: Mapping[str, Any]) -> MissionSettings:
    start = fields.get("start")
    return MissionSettings(
        fields["mission"] or "",
        unpack(fields["parameters"]),
        fields.get("model"),
        Start(Point(*start["at"]), start["heading"]) if start else None,
        rgb(fields.get("color")),
    )


def rgb(parts: Sequence[int] | None) -> Rgb | None:
    """A colour from its parts, as JSON has them; None for none."""
    return (parts[0], parts[1], parts[2]) if parts else None


def settings_of(fields: Mapping[str, Any]) -> RunSettings:
    """The settings in that object. Raises KeyError, TypeError and ValueError for any other."""
    known = {*_ORDER, "files"}
    return RunSettings(
        missions={
            vehicle: _mission_of(mission) for vehicle, mission in vehicles_of(fields).items()
        },
        world=fields["world"],
        files=fields["files"],
        **{name: fields[name] for name in _RUN if name != "limits"},
        limits=Limits(**fields["limits"]),
        post=tuple(map(post_of, fields["post"])),
        **{name: fields[name] for name in _FLEET if name in fields},
        referee=contest_of(fields["referee"]) if "referee" in fields else None,
        own={name: value for name, value in fields.items() if name not in known},
    )
