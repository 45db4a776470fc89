"""Reads and checks fleets: several missions that fly together, by one clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from fsm.chart.graph import Graph
from fsm.checks.messages import undelivered
from fsm.compiler.parameters import constant_value
from fsm.expressions.compiled import compile_expression
from fsm.expressions.literals import Context
from fsm.expressions.scope import TIME_SLOT, Binding, Scope, start
from fsm.faults import Faults
from fsm.language.includes import read_mission
from fsm.language.keys import AT, SMALL_NAME, Place
from fsm.language.spec import MissionSpec
from fsm.values.types import ANY, BOOL, MapOf, Number
from vencejo.errors import UserError, Where, nearest
from vencejo.files import file_inside, nearest_file
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Scalar, YamlNode, kind, read_file
from vencejo.units import TIME


@dataclass(frozen=True)
class Member:
    """One vehicle of a fleet, with its mission and the parameters given to it."""

    name: Scalar
    spec: MissionSpec
    path: Path
    with_: MapNode


@dataclass(frozen=True)
class FleetSpec:
    """A fleet's file."""

    name: str
    file: str
    description: str = ""
    members: tuple[Member, ...] = ()
    world: Scalar | None = None
    until: Scalar | None = None
    names: frozenset[str] = frozenset()
    """The names of all vehicles, also of those whose missions cannot be read."""


def read_fleet(path: Path, shown_as: str | None = None) -> tuple[FleetSpec, Faults]:
    """Read a fleet with all its missions, and collect the mistakes of form in all files.

    Raises UserError when the fleet's own file cannot be read at all.
    """
    shown = shown_as or str(path)
    node, faults = read_file(path, shown), Faults()
    _refuse_unknown(node, "fleet", faults)
    texts = {name: _text(node, name, faults) for name in AT["fleet"] if name != "vehicles"}
    vehicles = node.get("vehicles")
    members: list[Member] = []
    entries = vehicles.entries if isinstance(vehicles, MapNode) else []
    if not entries:
        hint = "vehicles: {name: {mission: file.yaml}}"
        faults.fail("no-vehicles", "a fleet needs `vehicles`", node.where, hint)
    for name, value in entries:
        with faults.collecting():
            members.append(_member(name, value, path.parent, shown, faults))
    fleet, description = texts["fleet"], texts["description"]
    spec = FleetSpec(
        fleet.text if fleet else path.stem,
        shown,
        description.text if description else "",
        tuple(members),
        texts["world"],
        texts["until"],
        frozenset(name.text for name, _ in entries),
    )
    return spec, faults


def check_fleet(spec: FleetSpec, graphs: Mapping[str, Graph]) -> Faults:
    """The faults of a fleet that its compiled missions show: parameters, names, `until`."""
    faults = Faults()
    scope = Scope(warnings=faults)
    for name in spec.names - {member.name.text for member in spec.members}:
        # Its mission cannot be read, which is a fault already.
        scope.names[name] = Binding(name, "host", ANY)
    scope.names["time"] = Binding("time", "host", Number(TIME), TIME_SLOT)
    for member in spec.members:
        graph = graphs.get(member.name.text)
        if graph is not None:
            _parameters(member, graph, faults)
        host = MapOf(graph.vocabulary.names) if graph else MapOf()
        with faults.collecting():
            name, where = member.name.text, member.name.where
            scope.declare(Binding(name, "host", host, where=where), where)
        if graph is not None:
            for name, receiver in graphs.items():
                faults.extend(undelivered(graph, receiver, name))
    if spec.until is not None:
        with faults.collecting():
            compile_expression(spec.until.text, start(spec.until), scope, BOOL, condition=True)
    return faults


def _parameters(member: Member, graph: Graph, faults: Faults) -> None:
    given = set()
    for key, value in member.with_:
        given.add(key.text)
        parameter = graph.parameters.get(key.text)
        if parameter is None:
            message = f"{graph.name} has no parameter '{key.text}'"
            hint = nearest(key.text, graph.parameters)
            faults.fail("unknown-parameter", message, key.where, hint)
            continue
        with faults.collecting():
            constant_value(value, parameter.type, Context())
    for parameter in graph.parameters.values():
        if parameter.required and parameter.name not in given:
            message = f"'{graph.name}' needs the parameter '{parameter.name}' ({parameter.type})"
            hint = f"with: {{{parameter.name}: …}}"
            faults.fail("missing-parameter", message, member.name.where, hint)


def _member(name: Scalar, node: YamlNode, folder: Path, shown: str, faults: Faults) -> Member:
    if not SMALL_NAME.fullmatch(name.text):
        hint = "a small letter, then small letters, digits and _"
        faults.fail("bad-name", f"'{name.text}' is no name for a vehicle", name.where, hint)
    if not isinstance(node, MapNode):
        raise UserError("wrong-type", f"a vehicle is a map, not {kind(node)}", node.where)
    _refuse_unknown(node, "vehicle", faults)
    word = _text(node, "mission", faults)
    if word is None:
        message, hint = f"'{name.text}' has no mission", "mission: file.yaml"
        raise UserError("missing-key", message, name.where, hint)
    path = file_inside(folder, word, "a fleet's mission")
    if not path.is_file():
        files = [file.relative_to(folder).as_posix() for file in folder.glob("**/*.y*ml")]
        message = f"there is no file '{word.text}'"
        raise UserError("no-such-file", message, word.where, nearest_file(word.text, files))
    with_ = node.get("with") or MapNode([], node.where)
    if not isinstance(with_, MapNode):
        raise UserError("wrong-type", f"`with` is a map, not {kind(with_)}", with_.where)
    spec = read_mission(path, str(PurePosixPath(shown).parent / word.text))
    return Member(name, spec, path, with_)


def _refuse_unknown(node: MapNode, place: Place, faults: Faults) -> None:
    for key, _ in node:
        if key.text not in AT[place]:
            hint = nearest(key.text, AT[place])
            faults.fail("unknown-key", f"a {place} has no key '{key.text}'", key.where, hint)


def _text(node: MapNode, key: str, faults: Faults) -> Scalar | None:
    value = node.get(key)
    if value is None or (isinstance(value, Scalar) and not value.null):
        return value if isinstance(value, Scalar) else None
    where: Where = value.where
    faults.fail("wrong-type", f"`{key}` is a text, not {kind(value)}", where)
    return None
