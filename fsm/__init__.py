"""Hierarchical state graphs: the YAML language, its checker and its runtime. Knows no drones."""

from fsm.compiler import compile_mission, parse_parameters
from fsm.graph import Edge, Graph, Node
from fsm.includes import read_mission, read_mission_text
from fsm.machine import Event, Instance
from fsm.safety import prove
from fsm.spec import MissionSpec
from fsm.vocabulary import Activity, Behavior, Host, Outcome, Parameter, Vocabulary

__all__ = [
    "Activity",
    "Behavior",
    "Edge",
    "Event",
    "Graph",
    "Host",
    "Instance",
    "MissionSpec",
    "Node",
    "Outcome",
    "Parameter",
    "Vocabulary",
    "compile_mission",
    "parse_parameters",
    "prove",
    "read_mission",
    "read_mission_text",
]
