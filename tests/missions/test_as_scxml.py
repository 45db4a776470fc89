"""Every shipped mission goes out as SCXML and comes back as the same graph."""

from __future__ import annotations

import pytest

from behaviors import drone_vocabulary, load_all
from fsm import Graph, MissionSpec, compile_mission, read_mission
from fsm.scxml import import_mission, parse_document, write_scxml
from runner.missions import SHIPPED
from tests.missions.shipped import MISSIONS


def compiled(spec: MissionSpec) -> Graph:
    return compile_mission(
        spec, drone_vocabulary(load_all((scalar, SHIPPED) for scalar in spec.uses))
    )


def edges(graph: Graph) -> list[tuple[object, ...]]:
    return [
        (edge.kind, edge.trigger, edge.node.path, edge.dest, edge.reenter, len(edge.actions))
        for node in graph.nodes
        for edge in node.edges()
    ]


@pytest.mark.parametrize("mission", [*MISSIONS, "parts/dancer"])
def test_it_comes_back(mission: str) -> None:
    spec = read_mission(SHIPPED / f"{mission}.yaml")
    back = import_mission(parse_document(write_scxml(spec), "m.scxml"), "m.scxml")
    before, after = compiled(spec), compiled(back)
    assert [node.path for node in after.nodes] == [node.path for node in before.nodes]
    assert edges(after) == edges(before)
    assert after.parameters == before.parameters
    again = import_mission(parse_document(write_scxml(back), "m.scxml"), "m.scxml")
    assert write_scxml(again) == write_scxml(back)
