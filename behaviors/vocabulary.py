"""What missions of drones may say: host names, events, reactions, behaviours."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from behaviors.catalog import Catalog
from fsm.types import BOOL, POINT, TEXT, MapOf, Number, Type
from fsm.vocabulary import Behavior, Reaction, Vocabulary
from hal.vehicle import Observation
from vencejo.geometry import Point
from vencejo.units import ANGLE, LENGTH, RATIO, SPEED, TIME

URGENT = ("operator.*", "battery.*", "link.*", "position.lost", "geofence.breach")
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
    }
)
REACTIONS: Mapping[str, Reaction] = MappingProxyType(
    {
        "battery.low": "none",
        "link.restored": "none",
        "operator.takeover": "none",
        "operator.release": "none",
    }
)
"""Everything else that is urgent or failed, and that nobody handles, lands the vehicle."""


@dataclass(frozen=True, slots=True)
class VehicleView:
    """The values of ``vehicle`` in expressions; positions in the mission frame."""

    position: Point
    velocity: Point
    yaw: float
    altitude: float
    speed: float
    battery: float
    armed: bool
    flying: bool
    mode: str
    home: Point


VEHICLE: Mapping[str, Type] = MappingProxyType(
    {
        "position": POINT,
        "velocity": POINT,
        "yaw": Number(ANGLE),
        "altitude": Number(LENGTH),
        "speed": Number(SPEED),
        "battery": Number(RATIO),
        "armed": BOOL,
        "flying": BOOL,
        "mode": TEXT,
        "home": POINT,
    }
)


def view(seen: Observation) -> VehicleView:
    """An observation (mission frame) as expressions see it."""
    return VehicleView(
        seen.position,
        seen.velocity,
        seen.yaw,
        seen.position.z,
        seen.velocity.norm(),
        seen.battery,
        seen.armed,
        seen.flying,
        seen.mode,
        seen.home,
    )


def drone_vocabulary(
    own: Mapping[str, Behavior] | None = None, places: Iterable[str] | None = None
) -> Vocabulary:
    """The vocabulary of drone missions.

    ``own`` are behaviours beside the mission; ``places`` the world's, None when it is not known.
    """
    return Vocabulary(
        behaviors=Catalog(own),
        names={"vehicle": MapOf(VEHICLE)},
        events=EVENTS,
        urgent=URGENT,
        reactions=dict(REACTIONS),
        places=None if places is None else frozenset(places),
    )
