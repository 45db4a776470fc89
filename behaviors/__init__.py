"""Reusable flight behaviours, and the pilot that flies a graph of them on a vehicle."""

from behaviors.action import action
from behaviors.behavior import Behavior, describe
from behaviors.calls import Calls, CodeFailed, TookTooLong
from behaviors.detector import Sighting, detector
from behaviors.exchange import Exchange
from behaviors.flight import Flight, NotInControl
from behaviors.frame import MissionFrame
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
from behaviors.path_file import PathFile
from behaviors.pilot import Pilot
from behaviors.plan import UNKNOWN, Legs, PlannedLeg, PlanStart, Unflyable
from behaviors.registry import Registry, load_all
from behaviors.trust import trusted
from behaviors.vocabulary import drone_vocabulary
from behaviors.watch import Thresholds
from fsm.host import Outcome
from vencejo.geometry import Point

__all__ = [
    "UNKNOWN",
    "Area",
    "Behavior",
    "BehaviorParams",
    "Calls",
    "CodeFailed",
    "Exchange",
    "Face",
    "Flight",
    "Heading",
    "Legs",
    "MissionFrame",
    "NotInControl",
    "Outcome",
    "PathFile",
    "Pilot",
    "PlanStart",
    "PlannedLeg",
    "Point",
    "Registry",
    "Route",
    "Sighting",
    "Thresholds",
    "TookTooLong",
    "Unflyable",
    "Waypoint",
    "action",
    "describe",
    "detector",
    "drone_vocabulary",
    "live",
    "load_all",
    "param",
    "trusted",
    "value",
]
