"""Hierarchical state graphs: the YAML language, its checker and its runtime. Knows no drones."""

from fsm.chart.graph import Edge, Graph, Node
from fsm.checks.safety import prove, warnings_with_proof
from fsm.compiler.mission import compile_mission, parse_parameters
from fsm.engine.instance import Event, Instance
from fsm.host import Activity, BehaviorInfo, Host, Outcome, Parameter, Vocabulary
from fsm.language.includes import read_mission, read_mission_text
from fsm.language.spec import MissionSpec

__all__ = [
    "Activity",
    "BehaviorInfo",
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
    "warnings_with_proof",
]
