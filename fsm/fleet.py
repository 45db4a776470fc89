"""Reads and checks fleets: several missions that fly together, by one clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from fsm.chart.graph import Graph
from fsm.checks.messages import undelivered
from fsm.compiler.parameters import constant_value
from fsm.expressions.compiled import Compiled, compile_expression
from fsm.expressions.literals import Context
from fsm.expressions.scope import (
    FIRST_HOST_SLOT,
    RESERVED,
    TIME_SLOT,
    Binding,
    Scope,
    start,
)
from fsm.faults import Faults
from fsm.language.includes import read_mission
from fsm.language.keys import AT, MISSION_NAME, SMALL_NAME, Place
from fsm.language.reader import FLEET
from fsm.language.spec import MissionSpec
from fsm.values.types import ANY, BOOL, MapOf, Number
from vencejo.errors import UserError, Where, nearest
from vencejo.files import file_inside, nearest_file
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Scalar, YamlNode, kind, read_file
from vencejo.units import TIME

_MAPS = ("vehicles", "referee")
"""The keys of a fleet whose values are maps."""


@dataclass(frozen=True)
class Member:
    """One vehicle of a fleet, with its mission and the parameters given to it.

    What the host reads of it (``start``, ``color``) is kept as it is written.
    """

    name: Scalar
    spec: MissionSpec | None
    """None for a vehicle without a mission."""
    path: Path | None
    """The file of its mission."""
    with_: MapNode
    model: Scalar | None = None
    start: YamlNode | None = None
    color: YamlNode | None = None


@dataclass(frozen=True)
class FleetSpec:
    """A fleet's file."""

    name: str
    file: str
    description: str = ""
    members: tuple[Member, ...] = ()
    world: Scalar | None = None
    until: Scalar | None = None
    names: tuple[Scalar, ...] = ()
    """The names of all vehicles, also of those whose missions cannot be read."""
    referee: YamlNode | None = None
    """What the host reads of it, as it is written."""


def read_fleet(path: Path, shown_as: str | None = None) -> tuple[FleetSpec, Faults]:
    """Read a fleet with all its missions, and collect the mistakes of form in all files.

    Raises UserError when the fleet's own file cannot be read at all.
    """
    shown = shown_as or str(path)
    node, faults = read_file(path, shown), Faults()
    _refuse_unknown(node, "fleet", faults)
    texts = {name: _text(node, name, faults) for name in AT["fleet"] if name not in _MAPS}
    vehicles = node.get("vehicles")
    members: list[Member] = []
    entries = vehicles.entries if isinstance(vehicles, MapNode) else []
    hint = "vehicles: {name: {mission: file.yaml}}"
    if vehicles is not None and not isinstance(vehicles, MapNode):
        message = f"`vehicles` is a map of names, not {kind(vehicles)}"
        faults.fail("wrong-type", message, vehicles.where, hint)
    elif not entries:
        where = vehicles.where if vehicles else node.where
        faults.fail("no-vehicles", "a fleet needs `vehicles`", where, hint)
    for name, value in entries:
        with faults.collecting():
            members.append(_member(name, value, path.parent, shown, faults))
    fleet, description = texts["fleet"], texts["description"]
    if fleet is not None and not MISSION_NAME.fullmatch(fleet.text):
        hint = "a letter, then letters, digits, _ and -"
        faults.fail("bad-name", f"'{fleet.text}' is no name for a fleet", fleet.where, hint)
    spec = FleetSpec(
        fleet.text if fleet else path.stem,
        shown,
        description.text if description else "",
        tuple(members),
        texts["world"],
        texts["until"],
        tuple(name for name, _ in entries),
        node.get("referee"),
    )
    return spec, faults


@dataclass(frozen=True)
class Until:
    """The condition that ends a fleet's flight."""

    condition: Compiled

    @property
    def text(self) -> str:
        return self.condition.source

    def holds(self, time: float, vehicles: Sequence[Any]) -> bool:
        """Whether it is true; ``vehicles`` are objects with the host's names as attributes, in the
        order in which they were known when it was compiled.

        Raises one of :data:`fsm.values.functions.FAILURES`.
        """
        slots = [time, *[None] * (FIRST_HOST_SLOT - 1), *vehicles]
        return self.condition(slots) is True


def compile_until(
    text: str, where: Where, graphs: Mapping[str, Graph | None], faults: Faults
) -> Until:
    """The condition in a text, over ``time`` and the host names of vehicles by their names.

    ``graphs``: that of each vehicle; None where it is not known. What is doubtful is added to
    ``faults``. Raises UserError.
    """
    scope = Scope(warnings=faults)
    scope.names["time"] = Binding("time", "host", Number(TIME), TIME_SLOT)
    for slot, (name, graph) in enumerate(graphs.items(), FIRST_HOST_SLOT):
        known = ANY if graph is None else MapOf(graph.vocabulary.names)
        scope.names.setdefault(name, Binding(name, "host", known, slot))
    return Until(compile_expression(text, where, scope, BOOL, condition=True))


def check_fleet(spec: FleetSpec, graphs: Mapping[str, Graph]) -> Faults:
    """The faults of a fleet that its compiled missions show: parameters, names, `until`.

    ``graphs``: those of the vehicles with a mission that has no error.
    """
    faults = Faults()
    for name in spec.names:
        if name.text == "time" or name.text in RESERVED:
            message = f"'{name.text}' is a word of the language"
            faults.fail("name-taken", message, name.where, "choose another name")
    for member in spec.members:
        graph = graphs.get(member.name.text)
        if graph is None:
            continue
        given_parameters(member, graph, faults)
        for receiver, heard in graphs.items():
            faults.extend(undelivered(graph, heard, receiver))
    if spec.until is not None:
        known = {name.text: graphs.get(name.text) for name in spec.names}
        with faults.collecting():
            compile_until(spec.until.text, start(spec.until), known, faults)
    return faults


def given_parameters(member: Member, graph: Graph, faults: Faults) -> dict[str, Any]:
    """The values that a fleet gives to the parameters of a mission; what is wrong with them, and
    required ones without a value, are added to ``faults``.
    """
    context = Context(Scope(warnings=faults), graph.places, graph.vocabulary.places)
    values: dict[str, Any] = {}
    for key, value in member.with_:
        parameter = graph.parameters.get(key.text)
        if parameter is None:
            message = f"{graph.name} has no parameter '{key.text}'"
            hint = nearest(key.text, graph.parameters)
            faults.fail("unknown-parameter", message, key.where, hint)
            continue
        values[key.text] = None
        with faults.collecting():
            values[key.text] = constant_value(value, parameter.type, context).value()
    for parameter in graph.parameters.values():
        if parameter.required and parameter.name not in values:
            message = f"'{graph.name}' needs the parameter '{parameter.name}' ({parameter.type})"
            hint = f"with: {{{parameter.name}: …}}"
            faults.fail("missing-parameter", message, member.name.where, hint)
    return values


def _member(name: Scalar, node: YamlNode, folder: Path, shown: str, faults: Faults) -> Member:
    if not SMALL_NAME.fullmatch(name.text):
        hint = "a small letter, then small letters, digits and _"
        faults.fail("bad-name", f"'{name.text}' is no name for a vehicle", name.where, hint)
    if not isinstance(node, MapNode):
        message, hint = f"a vehicle is a map, not {kind(node)}", "without a mission it stands: {}"
        raise UserError("wrong-type", message, node.where, hint)
    _refuse_unknown(node, "vehicle", faults)
    with_ = node.get("with") or MapNode([], node.where)
    if not isinstance(with_, MapNode):
        raise UserError("wrong-type", f"`with` is a map, not {kind(with_)}", with_.where)
    model, start, color = _text(node, "model", faults), node.get("start"), node.get("color")
    word = _text(node, "mission", faults)
    if word is None:
        if with_.entries:
            message, hint = f"'{name.text}' has no mission to give this to", "mission: file.yaml"
            raise UserError("missing-key", message, with_.where, hint)
        return Member(name, None, None, with_, model, start, color)
    path = file_inside(folder, word, "a fleet's mission")
    if not path.is_file():
        files = [file.relative_to(folder).as_posix() for file in folder.glob("**/*.y*ml")]
        message = f"there is no file '{word.text}'"
        raise UserError("no-such-file", message, word.where, nearest_file(word.text, files))
    if path.suffix == ".scxml":
        message = "a fleet's missions are written in YAML, and this is SCXML"
        raise UserError("not-a-mission", message, word.where)
    try:
        spec = read_mission(path, str(PurePosixPath(shown).parent / word.text))
    except UserError as error:
        if error.code != FLEET:
            raise
        message = f"'{word.text}' is a fleet, and a vehicle flies a mission"
        hint = "name the vehicles of that fleet here, too"
        raise UserError(FLEET, message, word.where, hint) from None
    return Member(name, spec, path, with_, model, start, color)


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
