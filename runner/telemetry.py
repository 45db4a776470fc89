"""The rows of ``telemetry.csv``: where a vehicle was and what it was told, period by period."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from hal.vehicle import Attitude, Hold, Observation, Position, Setpoint, Velocity
from vencejo.geometry import Point, roll_pitch_of

_COMMANDED = (
    *("setpoint", "sp_x", "sp_y", "sp_z", "sp_vx", "sp_vy", "sp_vz", "sp_yaw", "sp_yaw_rate"),
    *("sp_roll", "sp_pitch", "sp_climb", "sp_thrust"),
)
_BEFORE, _AFTER = "t,vehicle,x,y,z,vx,vy,vz,roll,pitch,yaw,battery", "mode,state"
COLUMNS = ",".join((_BEFORE, *_COMMANDED, _AFTER))
KNOWN_COLUMNS = (COLUMNS, f"{_BEFORE},{_AFTER}")
"""Those of this release, and of earlier ones, which did not keep set-points."""
_ROW = "%.3f,%s,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.5f,%.5f,%.5f,%.5f,%s,%s,%s"
_POSITION = "position,%.4f,%.4f,%.4f,%s,%s,%s,,,,"
_SPEEDS = "%.4f,%.4f,%.4f"
_VELOCITY = "%s,,,,%.4f,%.4f,%.4f,,%.5f,,,,"
_ATTITUDE = "%s,,,,,,,,%.5f,%.5f,%.5f,%.4f,%s"
_HOLD = "hold" + "," * (len(_COMMANDED) - 1)


class Sample(NamedTuple):
    """A row: a vehicle's state at the end of a mission period, and what it was told then."""

    time: float
    """Seconds of the vehicle's clock."""
    position: Point
    """World frame, metres."""
    velocity: Point
    """World frame, m/s."""
    roll: float
    """Radians, as pitch and yaw."""
    pitch: float
    yaw: float
    """Counter-clockwise from east."""
    battery: float
    """Charge left, 0 to 1."""
    mode: str
    states: tuple[str, ...]
    """Paths of the active leaf states of its mission; none once it has ended."""
    setpoint: Setpoint | None = None
    """The set-point for the period that begins, world frame; None for none."""
    manoeuvre: str = ""
    """The verb of the order that it flies instead (``takeoff``); empty for none."""


def row_of(
    seen: Observation,
    vehicle: str,
    states: Sequence[str],
    setpoint: Setpoint | None = None,
    manoeuvre: str = "",
) -> str:
    """A row without its end; ``seen`` and ``setpoint`` are of the world frame."""
    roll, pitch = roll_pitch_of(seen.attitude)
    place = (seen.time, _cell(vehicle), *seen.position, *seen.velocity)
    mode, state = _cell(seen.mode), _cell("|".join(states))
    told = _commanded(setpoint) if setpoint is not None else _flown_order(manoeuvre)
    return _ROW % (*place, roll, pitch, seen.yaw, seen.battery, told, mode, state)


def sample_of(line: bytes, columns: str = COLUMNS) -> tuple[str, Sample]:
    """A vehicle's name and its sample. Raises ValueError for what is no row of these columns."""
    text = line.decode()
    cells = next(csv.reader([text], strict=True)) if '"' in text else text.split(",")
    count = columns.count(",") + 1
    if len(cells) != count:
        raise ValueError(f"it has {len(cells)} columns, not {count}")
    time, vehicle, *numbers = cells[:12]
    x, y, z, vx, vy, vz, roll, pitch, yaw, battery = map(float, numbers)
    position, velocity = Point(x, y, z), Point(vx, vy, vz)
    *told, mode, state = cells[12:]
    states = tuple(state.split("|")) if state else ()
    setpoint = _setpoint(told) if told else None
    manoeuvre = told[0] if told and not setpoint else ""
    flown = position, velocity, roll, pitch, yaw, battery, mode, states
    return vehicle, Sample(float(time), *flown, setpoint, manoeuvre)


@lru_cache(maxsize=256)
def _cell(text: str) -> str:
    """A text in one cell of a line of CSV (RFC 4180): an autopilot may call its mode anything."""
    text = text.replace("\r", " ").replace("\n", " ")
    return '"' + text.replace('"', '""') + '"' if "," in text or '"' in text else text


# -- set-points ------------------------------------------------------------------------------------


def _flown_order(manoeuvre: str) -> str:
    return manoeuvre + "," * (len(_COMMANDED) - 1)


def _commanded(setpoint: Setpoint) -> str:
    """The cells of a set-point; those that it does not give are empty."""
    if isinstance(setpoint, Position):
        x, y, z = setpoint.xyz
        moves = ",," if setpoint.velocity is None else _SPEEDS % setpoint.velocity
        return _POSITION % (x, y, z, moves, _angle(setpoint.yaw), _angle(setpoint.yaw_rate))
    if isinstance(setpoint, Velocity):
        kind = "heading-velocity" if setpoint.frame == "heading" else "velocity"
        return _VELOCITY % (kind, setpoint.x, setpoint.y, setpoint.z, setpoint.yaw_rate)
    if isinstance(setpoint, Attitude):
        roll, pitch, climb, thrust, yaw_rate, unit = setpoint
        kind = "attitude-share" if unit == "share" else "attitude"
        share = "" if thrust is None else f"{thrust:.4f}"
        return _ATTITUDE % (kind, yaw_rate, roll, pitch, climb, share)
    return _HOLD


def _angle(value: float | None) -> str:
    return "" if value is None else f"{value:.5f}"


def _setpoint(cells: Sequence[str]) -> Setpoint | None:
    """The set-point in its cells; None where they hold no more than the verb of an order."""
    kind, x, y, z, vx, vy, vz, yaw, yaw_rate, roll, pitch, climb, thrust = cells
    match kind:
        case "position":
            velocity = Point(float(vx), float(vy), float(vz)) if vx else None
            place = Point(float(x), float(y), float(z))
            return Position(place, velocity, _optional(yaw), _optional(yaw_rate))
        case "velocity":
            return Velocity(float(vx), float(vy), float(vz), "world", float(yaw_rate))
        case "heading-velocity":
            return Velocity(float(vx), float(vy), float(vz), "heading", float(yaw_rate))
        case "attitude" | "attitude-share":
            tilt = float(roll), float(pitch), float(climb), _optional(thrust), float(yaw_rate)
            return Attitude(*tilt, "share" if kind == "attitude-share" else "si")
        case "hold":
            return Hold()
    return None


def _optional(number: str) -> float | None:
    return float(number) if number else None
