"""A fleet's file, checked with every mission in it. Fleets do not fly yet."""

from __future__ import annotations

from behaviors import drone_vocabulary
from cli.missions import Found
from cli.prepare import uses, world_word
from fsm import Graph, compile_mission
from fsm.faults import Faults
from fsm.fleet import check_fleet, read_fleet
from vencejo.errors import Fault
from worlds import find_world


def faults_of_fleet(found: Found, world: str | None = None) -> tuple[list[Fault], int]:
    """Every fault of a fleet and of its missions, and how many states these have together.

    Raises UserError when the fleet's own file or its world cannot be read.
    """
    fleet, faults = read_fleet(found.path, found.shown_as)
    place = find_world(*world_word(fleet.world, found.path.parent, world))
    graphs: dict[str, Graph] = {}
    for member in fleet.members:
        with faults.collecting():
            own = uses(member.spec, member.path)
            vocabulary = drone_vocabulary(own, place.places, fleet.names)
            graph = graphs[member.name.text] = compile_mission(member.spec, vocabulary)
            faults.extend(graph.warnings)
    faults.extend(check_fleet(fleet, graphs))
    # Two vehicles may fly one mission: its faults are told once.
    found_faults = Faults(dict.fromkeys(faults))
    return found_faults, sum(len(graph.nodes) - 1 for graph in graphs.values())
