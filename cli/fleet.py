"""A fleet's file, checked with every mission in it. Fleets do not fly yet."""

from __future__ import annotations

from cli.missions import Found
from cli.prepare import vocabulary_of, world_word
from fsm import Graph, compile_mission, prove
from fsm.faults import Faults
from fsm.fleet import check_fleet, read_fleet
from vencejo.errors import Fault
from worlds import find_world


def check_fleet_file(
    found: Found, world: str | None = None, *, code: bool = True
) -> tuple[list[Fault], list[Graph]]:
    """Every fault of a fleet and of its missions, and the graphs of those that have no error.

    Raises UserError when the fleet's own file or its world cannot be read.
    """
    fleet, faults = read_fleet(found.path, found.shown_as)
    place = find_world(*world_word(fleet.world, found.path.parent, world))
    graphs: dict[str, Graph] = {}
    for member in fleet.members:
        with faults.collecting():
            found_here = Faults()
            vocabulary = vocabulary_of(
                member.spec, member.path, place, found_here, code=code, peers=fleet.names
            )
            graph = compile_mission(member.spec, vocabulary, found_here)
            graphs[member.name.text] = graph
            faults.extend((*graph.warnings, *prove(graph)))
    faults.extend(check_fleet(fleet, graphs))
    # Two vehicles may fly one mission: its faults are told once.
    return list(dict.fromkeys(faults)), list(graphs.values())
