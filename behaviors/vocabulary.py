"""The vocabulary of drone missions: host values, events, reactions, behaviours, functions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from behaviors.calls import Calls
from behaviors.detector import OwnDetector
from behaviors.host_functions import HOST_FUNCTIONS
from behaviors.registry import Registry
from fsm.host import BehaviorInfo, Function, Reaction, Vocabulary
from fsm.values.functions import EvaluationError
from fsm.values.types import BOOL, POINT, TEXT, MapOf, Number, Type
from hal.vehicle import Observation
from vencejo.geometry import Point
from vencejo.units import ANGLE, LENGTH, RATIO, SPEED, TIME

URGENT = (
    "operator.*",
    "battery.*",
    "link.*",
    "position.lost",
    "geofence.breach",
    "autopilot.failsafe",
)
MUST_LAND = (
    "operator.abort",
    "battery.critical",
    "link.lost",
    "position.lost",
    "geofence.breach",
)
EVENTS: Mapping[str, Mapping[str, Type]] = MappingProxyType(
    {
        "operator.abort": {},
        "operator.takeover": {},
        "operator.release": {},
        "operator.land": {},
        "battery.low": {"level": Number(RATIO)},
        "battery.critical": {"level": Number(RATIO)},
        "link.lost": {"age": Number(TIME)},
        "link.restored": {"age": Number(TIME)},
        "position.lost": {},
        "position.restored": {},
        "geofence.breach": {},
        "autopilot.failsafe": {"reason": TEXT},
        "vehicle.late": {"step": Number(TIME)},
        "vehicle.collision": {"thing": TEXT},
        "vehicle.unstable": {"thing": TEXT},
        "vehicle.crashed": {"thing": TEXT, "speed": Number(SPEED), "reason": TEXT},
    }
)
REACTIONS: Mapping[str, Reaction] = MappingProxyType(
    {
        "battery.low": "none",
        "link.restored": "none",
        "operator.takeover": "suspend",
        "operator.release": "resume",
    }
)
"""The reaction to an unhandled event; every other urgent or failed event lands the vehicle."""


class VehicleView:
    """The values of ``vehicle`` in expressions: an observation in the mission frame.

    It is made every period and rarely read, so its values are computed when they are read.
    """

    __slots__ = ("_home", "_seen")

    def __init__(self, seen: Observation, home: float = 0.0) -> None:
        """``home``: the height from which its altitude counts, metres: in the mission frame 0."""
        self._seen = seen
        self._home = home

    @property
    def position(self) -> Point:
        return self._seen.position

    @property
    def velocity(self) -> Point:
        return self._seen.velocity

    @property
    def yaw(self) -> float:
        return self._seen.yaw

    @property
    def altitude(self) -> float:
        return self._seen.position.z - self._home

    @property
    def speed(self) -> float:
        return self._seen.velocity.norm()

    @property
    def battery(self) -> float:
        return self._seen.battery

    @property
    def armed(self) -> bool:
        return self._seen.armed

    @property
    def flying(self) -> bool:
        return self._seen.flying

    @property
    def mode(self) -> str:
        return self._seen.mode

    @property
    def authority(self) -> str:
        return self._seen.authority

    @property
    def home(self) -> Point:
        return self._seen.home

    @property
    def wind(self) -> Point:
        """Raises EvaluationError for a vehicle without the capability."""
        wind = self._seen.wind
        if wind is None:
            raise EvaluationError("this vehicle does not estimate the wind")
        return wind


_VELOCITY = MapOf(MappingProxyType(dict.fromkeys("xyz", Number(SPEED))))
VEHICLE: Mapping[str, Type] = MappingProxyType(
    {
        "position": POINT,
        "velocity": _VELOCITY,
        "yaw": Number(ANGLE),
        "altitude": Number(LENGTH),
        "speed": Number(SPEED),
        "battery": Number(RATIO),
        "armed": BOOL,
        "flying": BOOL,
        "mode": TEXT,
        "authority": TEXT,
        "home": POINT,
        "wind": _VELOCITY,
    }
)


def drone_vocabulary(
    own: Mapping[str, BehaviorInfo | Function | OwnDetector] | None = None,
    places: Iterable[str] | None = None,
    peers: Iterable[str] | None = None,
    calls: Calls | None = None,
) -> Vocabulary:
    """The vocabulary of drone missions.

    ``own`` are behaviours, functions and detectors beside the mission; ``places`` the names of the
    world's places, None when the world is not known; ``peers`` the vehicles of the fleet, None
    without one; ``calls`` those that import installed behaviours.
    """
    own = own or {}
    return Vocabulary(
        behaviors=Registry(
            {n: known for n, known in own.items() if isinstance(known, BehaviorInfo)},
            calls,
            {n: known for n, known in own.items() if isinstance(known, OwnDetector)},
        ),
        functions={
            **{name: function for name, (function, _) in HOST_FUNCTIONS.items()},
            **{n: known for n, known in own.items() if isinstance(known, Function)},
        },
        peers=None if peers is None else frozenset(peers),
        names={"vehicle": MapOf(VEHICLE)},
        events=EVENTS,
        urgent=URGENT,
        reactions=dict(REACTIONS),
        must_land=MUST_LAND,
        needs={"vehicle.wind": "wind"},
        places=None if places is None else frozenset(places),
    )
