"""The simulated rangefinder: the distance to what lies below a vehicle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from hal.sim.physics import Physics
from hal.sim.pose_history import PoseHistory
from hal.sim.sensors.sampling import FASTEST, SLOWEST, newest_capture
from hal.vehicle import Reading
from vencejo.errors import UserError, nearest
from vencejo.geometry import turned


@dataclass(frozen=True)
class RangefinderSpec:
    """A rangefinder that looks down."""

    max_range: float = 6.0
    """Largest distance that is measured, metres."""
    rate: float = 25.0
    """Readings per second."""


_NAMES = ("down",)
"""The places on the vehicle where a rangefinder can be."""
_RANGES = {"max_range": (0.1, 1000.0), "rate": (SLOWEST, FASTEST)}


def read_rangefinders(given: object) -> dict[str, RangefinderSpec]:
    """The rangefinders of a vehicle, from the setting ``sensors``: a map of names.

    The one name is ``down``; a value is a RangefinderSpec, a map of what differs from its
    defaults, or None for no such sensor. Raises UserError (``bad-setting``).
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise _bad("'sensors' is a map of names", 'for instance {"down": {"max_range": 8}}')
    found = {}
    for name, value in given.items():
        if name not in _NAMES:
            raise _bad(f"the simulator has no sensor '{name}'", nearest(str(name), _NAMES))
        if value is not None:
            found[name] = _read_spec(name, value)
    return found


def _read_spec(name: str, value: object) -> RangefinderSpec:
    if isinstance(value, RangefinderSpec):
        settings: Mapping[str, object] = {key: getattr(value, key) for key in _RANGES}
    elif isinstance(value, Mapping):
        settings = value
    else:
        raise _bad(f"the sensor '{name}' is {value!r}; it must be a map of settings")
    known = [field.name for field in fields(RangefinderSpec)]
    numbers = {}
    for key, setting in settings.items():
        if key not in known:
            raise _bad(f"the sensor '{name}' has no '{key}'", nearest(str(key), known))
        low, high = _RANGES[key]
        if not isinstance(setting, (int, float)) or not low <= setting <= high:
            raise _bad(
                f"the sensor '{name}' has a {key} of {setting!r}",
                f"it must be {low:g} to {high:g}",
            )
        numbers[key] = float(setting)
    return RangefinderSpec(**numbers)


def _bad(message: str, hint: str | None = None) -> UserError:
    return UserError("bad-setting", message, hint=hint)


class SimRangefinder:
    """A rangefinder of a simulated vehicle (see :class:`hal.vehicle.Sensor`).

    Its ray goes from the centre of mass along the body's −z. It hits the ground and solid things,
    and passes through vehicles.
    """

    def __init__(self, spec: RangefinderSpec, physics: Physics, history: PoseHistory) -> None:
        self._spec = spec
        self._physics = physics
        self._history = history
        self._last: Reading | None = None
        self._steps = 0
        """Physics steps that have been made."""
        self._sample()

    def sense(self) -> None:
        """Take a reading if one is due after a physics step; called after each of them.

        It is taken at once, read or not: later, what moves would be somewhere else.
        """
        self._steps += 1
        self._sample()

    def _sample(self) -> None:
        capture = newest_capture(self._spec.rate, self._steps)
        if capture.step != self._steps:
            return
        at, attitude = self._history.pose(0)
        end = at.plus(turned((0.0, 0.0, -self._spec.max_range), attitude))
        (distance,) = self._physics.rays([at], [end]).distances
        self._last = Reading(capture.time, {"distance": distance})

    def latest(self) -> Reading | None:
        """The newest reading: ``distance`` in metres, infinite for nothing within the range.

        Infinity as in ROS (REP 117, *Informational Distance Measurements*).
        """
        return self._last
