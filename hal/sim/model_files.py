"""Models of vehicles in YAML files: those in ``models`` by name, others by path."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from math import pi
from pathlib import Path
from typing import Any

from hal.camera_settings import CAMERA
from hal.limits import DIMENSIONS, Limits
from hal.sim.model import BatteryPack, Drag, Model, Rotors
from hal.sim.plausibility import impossibilities
from hal.sim.sensors.camera_spec import CameraSpec, read_cameras
from vencejo import nodes
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.files import is_file_word
from vencejo.nodes import YamlNode, read_file
from vencejo.units import (
    ANGLE,
    ENERGY,
    FORCE,
    INERTIA,
    LENGTH,
    MASS,
    POWER,
    RATIO,
    RESISTANCE,
    SPEED,
    TIME,
    TURN_RATE,
    VOLTAGE,
)
from worlds.values import (
    COLOR,
    FLAG,
    TEXT,
    Field,
    Misfit,
    NamedEntries,
    Value,
    above_zero,
    array,
    names,
    quantity,
    read_fields,
    record,
)

DEFAULT = "ardrone2"
"""The model of vehicles for which none is named."""
_FOLDER = Path(__file__).parent / "models"
_METRES = above_zero(LENGTH, 100.0)
_SHARE = above_zero(RATIO, 1.0)
_SPEED, _TILT = above_zero(SPEED, 100.0), above_zero(ANGLE, pi / 2)


def _limits(**given: float) -> Limits:
    limits = Limits(**given)
    try:
        limits.given()
    except UserError as error:
        raise Misfit(error.code, error.faults[0].message, "max_altitude") from None
    return limits


_ROTORS = record(
    "the rotors",
    {
        "arm": Field(_METRES),
        "radius": Field(_METRES),
        "max_thrust": Field(above_zero(FORCE, 1e4)),
        "idle": Field(quantity(RATIO, 0.0, 0.5)),
        "drag_ratio": Field(above_zero(LENGTH, 1.0)),
        "time_constant": Field(above_zero(TIME, 1.0)),
        "efficiency": Field(_SHARE),
    },
    lambda idle, **keys: Rotors(idle_thrust=idle, **keys),
)
_DRAG = record(
    "the drag",
    {"area": Field(quantity(RATIO, 0.0, 100.0)), "rotors": Field(quantity(RATIO, 0.0, 1000.0))},
    Drag,
)
_BATTERY = record(
    "the battery",
    {
        "energy": Field(above_zero(ENERGY, 1e9)),
        "full": Field(above_zero(VOLTAGE, 1000.0)),
        "empty": Field(above_zero(VOLTAGE, 1000.0)),
        "resistance": Field(quantity(RESISTANCE, 0.0, 100.0)),
        "standby": Field(quantity(POWER, 0.0, 1e6)),
    },
    BatteryPack,
)
_LIMITS: Value[dict[str, float]] = record(
    "the limits",
    {
        "max_speed": Field(_SPEED),
        "max_climb": Field(_SPEED),
        "max_tilt": Field(_TILT),
        "max_yaw_rate": Field(above_zero(TURN_RATE, 100.0)),
    },
    dict,
)
_PROFILE = record(
    "a profile",
    {name: Field(quantity(dimension), None) for name, dimension in DIMENSIONS.items()},
    _limits,
)
FIELDS = {
    "model": Field(TEXT),
    "description": Field(TEXT, ""),
    "mass": Field(above_zero(MASS, 1000.0)),
    "inertia": Field(
        array("an inertia is [about x, y, z] in kg m²", above_zero(INERTIA, 1e6), 3, 3)
    ),
    "size": Field(array("a size is [x, y, z] in metres", _METRES, 3, 3)),
    "rotors": Field(_ROTORS),
    "drag": Field(_DRAG),
    "battery": Field(_BATTERY),
    "limits": Field(_LIMITS),
    "profiles": Field(names("profiles", _PROFILE), NamedEntries()),
    "steepest_ground": Field(_TILT),
    "withstands": Field(_SPEED),
    "cameras": Field(names("cameras", CAMERA), NamedEntries()),
    "one_active_camera": Field(FLAG, False),
    "estimates_wind": Field(FLAG, False),
    "color": Field(COLOR, None),
}
"""The keys of a model's file."""


def model_names() -> list[str]:
    """The names of the shipped models."""
    return sorted(path.stem for path in _FOLDER.glob("*.yaml"))


def load_model(word: str = DEFAULT, where: Where | None = None) -> Model:
    """A model: a shipped one by its name, or any by the path of its file.

    ``where`` is the place that names it. Raises UserError (``unknown-model``, every fault of the
    file, and ``impossible-model`` for what no vehicle can be).
    """
    if is_file_word(word):
        return _read(Path(word))
    if word not in model_names():
        hint = nearest(word, model_names(), "a file is named by its path: models/mine.yaml")
        raise UserError("unknown-model", f"no model is called '{word}'", where, hint)
    return _shipped(word)


@cache
def _shipped(name: str) -> Model:
    return _read(_FOLDER / f"{name}.yaml")


def _read(path: Path) -> Model:
    root = read_file(path)
    keys, faults = read_fields(root, "a model", FIELDS)
    profiles: NamedEntries[Limits] = keys.pop("profiles", NamedEntries())
    cameras, faults_of_cameras = _cameras(keys.pop("cameras", NamedEntries()))
    faults += [*profiles.faults, *faults_of_cameras]
    if not faults:
        model = Model(
            name=keys.pop("model"),
            **keys.pop("limits"),
            profiles={name.text: limits for name, limits in profiles.entries},
            cameras=cameras,
            **keys,
        )
        faults += _impossibilities(model, root)
    if faults:
        raise UserError.of(sorted(faults, key=lambda fault: fault.where or root.where))
    return model


def _cameras(
    given: NamedEntries[dict[str, Any]],
) -> tuple[dict[str, CameraSpec], list[Fault]]:
    """The cameras of a model by name, and what is wrong with them."""
    found, faults = dict[str, CameraSpec](), list(given.faults)
    for name, settings in given.entries:
        try:
            found |= read_cameras({name.text: settings}, {})
        except UserError as error:
            faults += [replace(fault, where=name.where) for fault in error.faults]
    return found, faults


def _impossibilities(model: Model, root: nodes.Mapping) -> Iterator[Fault]:
    for path, message, hint in impossibilities(model):
        yield Fault("impossible-model", message, _place(root, path), hint)


def _place(node: YamlNode, path: tuple[str, ...]) -> Where:
    """The place of a value in nested maps, or of the last map on the way that there is."""
    for key in path:
        found = node.get(key) if isinstance(node, nodes.Mapping) else None
        if found is None:
            break
        node = found
    return node.where
