"""Reusable flight behaviours, and the pilot that flies a graph of them on a vehicle."""

from behaviors.action import action
from behaviors.behavior import Behavior, describe
from behaviors.catalog import Catalog, load_all
from behaviors.flight import Flight, MissionFrame
from behaviors.params import (
    Area,
    BehaviorParams,
    Face,
    Heading,
    Route,
    Waypoint,
    live,
    param,
    value,
)
from behaviors.pilot import Pilot
from behaviors.trust import trusted
from behaviors.vocabulary import drone_vocabulary
from behaviors.watch import Thresholds
from fsm.host import Outcome
from vencejo.geometry import Point

__all__ = [
    "Area",
    "Behavior",
    "BehaviorParams",
    "Catalog",
    "Face",
    "Flight",
    "Heading",
    "MissionFrame",
    "Outcome",
    "Pilot",
    "Point",
    "Route",
    "Thresholds",
    "Waypoint",
    "action",
    "describe",
    "drone_vocabulary",
    "live",
    "load_all",
    "param",
    "trusted",
    "value",
]
