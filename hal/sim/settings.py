"""The simulator's own settings (see :class:`hal.vehicle.Options`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import isfinite

from hal.engines import check_engine
from hal.renderers import check_renderer
from hal.sim.effects import Effects, plain_effects, read_effects
from hal.sim.sensors.camera_spec import plain_cameras
from hal.sim.sensors.rangefinder import RangefinderSpec, read_rangefinders
from vencejo.errors import UserError, nearest
from worlds.wind import read_wind

_KNOWN = ("engine", "noise", "physics", "wind", "cameras", "sensors", "renderer", "shadows")


@dataclass(frozen=True)
class Settings:
    """The simulator's settings, checked."""

    engine: str
    """The name of the physics engine."""
    noise: float
    """Factor of the command noise, 0 for none."""
    physics: Effects
    """The effects that are computed."""
    wind: str | None
    """A wind as it is written (see :mod:`worlds.wind`); None for the world's."""
    cameras: Mapping[str, object]
    """Name → what differs from the model's camera of that name, the same for every vehicle (see
    :func:`hal.sim.sensors.camera_spec.read_cameras`)."""
    sensors: Mapping[str, RangefinderSpec]
    """Name → rangefinder, the same for every vehicle."""
    renderer: str
    shadows: bool
    """True to render the shadows of things on the ground."""


def read_settings(given: Mapping[str, object]) -> Settings:
    """Check the given settings and complete them by defaults.

    Raises UserError (``unknown-setting``, ``bad-setting``, ``unknown-engine``,
    ``unknown-renderer``).
    """
    for name in given:
        if name not in _KNOWN:
            raise UserError(
                "unknown-setting",
                f"the simulator has no setting '{name}'",
                hint=nearest(name, _KNOWN),
            )
    noise = given.get("noise", 0.0)
    if not isinstance(noise, (int, float)) or not isfinite(noise) or noise < 0:
        raise UserError(
            "bad-setting",
            f"'noise' must be true, false or a factor of 0 or more, not {noise!r}",
            hint="1 is the command noise of Gazebo's AR.Drone, 0 is none",
        )
    shadows = given.get("shadows", False)
    if not isinstance(shadows, bool):
        raise UserError("bad-setting", f"'shadows' must be true or false, not {shadows!r}")
    physics = given.get("physics", "real")
    if not isinstance(physics, str):
        raise UserError("bad-setting", f"'physics' is a text such as 'real', not {physics!r}")
    return Settings(
        check_engine(given.get("engine")),
        float(noise),
        read_effects(physics),
        _checked_wind(given.get("wind")),
        plain_cameras(given.get("cameras")),
        read_rangefinders(given.get("sensors")),
        check_renderer(given.get("renderer", "raster")),
        shadows,
    )


def _checked_wind(wind: object) -> str | None:
    if wind is None:
        return None
    if not isinstance(wind, str):
        message = f"'wind' is a text such as '5 m/s@270 deg', not {wind!r}"
        raise UserError("bad-setting", message)
    read_wind(wind, "wind")
    return wind


def plain_settings(settings: Settings) -> dict[str, object]:
    """The settings as plain values, complete: :func:`read_settings` reads the same from them."""
    return {
        "engine": settings.engine,
        "noise": settings.noise,
        "physics": plain_effects(settings.physics),
        "wind": settings.wind,
        "cameras": dict(settings.cameras),
        "sensors": {name: asdict(spec) for name, spec in settings.sensors.items()},
        "renderer": settings.renderer,
        "shadows": settings.shadows,
    }
