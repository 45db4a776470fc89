"""The specification of a camera on a simulated vehicle, and its settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import isfinite, pi
from typing import Any

from hal.sim.sensors.sampling import FASTEST, SLOWEST
from hal.vehicle import Intrinsics
from vencejo.errors import UserError, nearest
from vencejo.geometry import (
    OPTICAL,
    Point,
    Quaternion,
    about_x,
    about_y,
    product,
    yaw_quaternion,
)

_CENTER = Point(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class CameraSpec:
    """A camera on a vehicle. Metres and radians; body axes are FLU about the centre of mass."""

    at: Point = _CENTER
    pan: float = 0.0
    """To the left of straight ahead."""
    tilt: float = 0.0
    """Below straight ahead: π/2 looks down, with ahead at the top of the image."""
    roll: float = 0.0
    """About the direction it looks in, clockwise as seen from behind."""
    width: int = 320
    """Pixels."""
    height: int = 240
    """Pixels."""
    rate: float = 20.0
    """Images per second."""
    field_of_view: float = pi / 3
    """Horizontal, of the lens without its distortion; in settings it is ``view``."""
    distortion: tuple[float, ...] = ()
    """OpenCV's k1, k2, p1, p2, k3; empty for none."""
    exposure: float = 0.0
    """Seconds that the shutter is open, about the capture time; 0 for no motion blur."""
    noise: float = 0.0
    """Standard deviation of each pixel's noise, grey levels."""

    @cached_property
    def intrinsics(self) -> Intrinsics:
        return Intrinsics.from_field_of_view(
            self.width, self.height, self.field_of_view, self.distortion
        )

    @cached_property
    def attitude(self) -> Quaternion:
        """Optical axes (x right, y down, z out) to body."""
        down = product(about_y(self.tilt), about_x(self.roll))
        return product(product(yaw_quaternion(self.pan), down), OPTICAL)


_SETTINGS = {("view" if f.name == "field_of_view" else f.name): f.name for f in fields(CameraSpec)}
"""Setting of a camera → field of its specification."""
_RANGES = {
    "pan": (-2 * pi, 2 * pi), "tilt": (-2 * pi, 2 * pi), "roll": (-2 * pi, 2 * pi),
    "width": (8, 4096), "height": (8, 4096), "rate": (SLOWEST, FASTEST), "view": (0.05, 2.8),
    "exposure": (0.0, 0.5), "noise": (0.0, 100.0),
}  # fmt: skip


def read_cameras(given: object, model: Mapping[str, CameraSpec]) -> dict[str, CameraSpec]:
    """The cameras of a vehicle: those of its model, changed by the setting ``cameras``.

    That is a map of names. A value is a CameraSpec, a map of the settings that differ from the
    camera's of that name (or from ``front``), or None for no such camera. Raises UserError
    (``bad-setting``).
    """
    found = dict(model)
    new = found.get("front", CameraSpec())
    for name, settings in plain_cameras(given).items():
        if settings is None:
            if name not in found:
                raise _bad(f"there is no camera '{name}' to switch off", nearest(name, found))
            del found[name]
        else:
            found[name] = _checked(name, _changed(found.get(name, new), settings))
    return found


def plain_cameras(given: object) -> dict[str, Mapping[str, Any] | None]:
    """The setting ``cameras`` in plain values: maps of settings that exist, or None.

    Raises UserError (``bad-setting``).
    """
    found: dict[str, Mapping[str, Any] | None] = {}
    if given is None:
        return found
    if not isinstance(given, Mapping):
        raise _bad("'cameras' is a map of names", 'for instance {"front": {"width": 640}}')
    for name, value in given.items():
        if not isinstance(name, str) or not name.isidentifier():
            raise _bad(f"'{name}' is no name of a camera", "letters, digits and _")
        if value is None:
            found[name] = None
        elif isinstance(value, CameraSpec):
            found[name] = _plain(value)
        elif isinstance(value, Mapping):
            for key in value:
                if key not in _SETTINGS:
                    hint = nearest(str(key), _SETTINGS)
                    raise _bad(f"the camera '{name}' has no '{key}'", hint)
            found[name] = dict(value)
        else:
            raise _bad(f"the camera '{name}' is {value!r}; it must be a map of settings")
    return found


def _plain(spec: CameraSpec) -> dict[str, object]:
    values = {setting: getattr(spec, field) for setting, field in _SETTINGS.items()}
    return values | {"at": list(spec.at), "distortion": list(spec.distortion)}


def _changed(spec: CameraSpec, settings: Mapping[str, Any]) -> CameraSpec:
    return replace(spec, **{_SETTINGS[key]: setting for key, setting in settings.items()})


def _checked(name: str, spec: CameraSpec) -> CameraSpec:
    for key, (low, high) in _RANGES.items():
        value = getattr(spec, _SETTINGS[key])
        whole = key not in ("width", "height") or isinstance(value, int)
        if not isinstance(value, (int, float)) or not whole or not low <= value <= high:
            raise _bad(
                f"the camera '{name}' has a {key} of {value!r}", f"it must be {low:g} to {high:g}"
            )
    if not _numbers(spec.at, 3):
        raise _bad(f"the camera '{name}' is at {spec.at!r}", "x, y and z in metres")
    if not _numbers(spec.distortion, 0, 4, 5):
        raise _bad(
            f"the camera '{name}' has a distortion of {spec.distortion!r}",
            "it is a list of OpenCV's k1, k2, p1, p2 and k3",
        )
    return replace(spec, at=Point(*spec.at), distortion=tuple(spec.distortion))


def _numbers(given: Any, *counts: int) -> bool:
    """Whether a value is a list of finite numbers, of one of these lengths."""
    try:
        return len(given) in counts and all(map(isfinite, given))
    except TypeError:
        return False


def _bad(message: str, hint: str | None = None) -> UserError:
    return UserError("bad-setting", message, hint=hint)
