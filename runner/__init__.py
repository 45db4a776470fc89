"""Flying prepared missions, without a command line.

>>> prepared = prepare(missions.find("first_flight"))
>>> flown = fly(Plan.alone(prepared, parse_parameters(prepared.graph, {"side": "8 m"})))

Public names are imported when they are used: every pytest of the environment imports this package
for its plugin, and must not wait for it.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from runner.call_limit import CallLimit
    from runner.fleets import PreparedFleet, prepare_fleet
    from runner.loop import Stops, Watcher, fly
    from runner.pace import Pace
    from runner.plan import Assignment, Fleet, Plan
    from runner.preparation import Prepared, prepare
    from runner.recorder import Recorder, new_folder
    from runner.run_folder import Flown, Header, Run, Summary, read_run
    from runner.telemetry import Sample
    from runner.testing import FleetFlight, MissionFlight, fly_fleet, fly_mission, graph_of

__all__ = [
    "Assignment",
    "CallLimit",
    "Fleet",
    "FleetFlight",
    "Flown",
    "Header",
    "MissionFlight",
    "Pace",
    "Plan",
    "Prepared",
    "PreparedFleet",
    "Recorder",
    "Run",
    "Sample",
    "Stops",
    "Summary",
    "Watcher",
    "fly",
    "fly_fleet",
    "fly_mission",
    "graph_of",
    "new_folder",
    "prepare",
    "prepare_fleet",
    "read_run",
]
_MODULES = {
    "call_limit": ("CallLimit",),
    "fleets": ("PreparedFleet", "prepare_fleet"),
    "loop": ("Stops", "Watcher", "fly"),
    "pace": ("Pace",),
    "plan": ("Assignment", "Fleet", "Plan"),
    "preparation": ("Prepared", "prepare"),
    "recorder": ("Recorder", "new_folder"),
    "run_folder": ("Flown", "Header", "Run", "Summary", "read_run"),
    "telemetry": ("Sample",),
    "testing": ("FleetFlight", "MissionFlight", "fly_fleet", "fly_mission", "graph_of"),
}

if not TYPE_CHECKING:  # a type checker would take every misspelt name for one of these

    def __getattr__(name: str) -> object:
        for module, names in _MODULES.items():
            if name in names:
                return getattr(import_module(f"runner.{module}"), name)
        raise AttributeError(f"module 'runner' has no attribute '{name}'")
