"""Preparation of fleets: from a file to checked missions, all in one world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from behaviors import Calls, drone_vocabulary
from fsm import Graph, compile_mission, read_mission_text
from fsm.compiler.parameters import parse_given
from fsm.expressions.scope import start as first_letter
from fsm.faults import Faults
from fsm.fleet import (
    FleetSpec,
    Member,
    Until,
    check_fleet,
    compile_until,
    given_parameters,
    read_fleet,
)
from fsm.language.reader import FLEET
from hal.lights import Rgb
from runner.by_vehicle import ALONE, are_alone
from runner.geometry import Findings, MissionPlan, Terms, check_geometry, plan_of
from runner.missions import Found
from runner.plan import Assignment, Fleet, starts_of
from runner.preparation import Prepared, prepare, prepare_member, world_word
from runner.referee import REFEREE, Contest
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.files import named_from
from worlds import Start, World, find_world
from worlds.environment import START
from worlds.starts import PlannedStart, bad_starts, overlapping, starts_outside
from worlds.terrain import place_of
from worlds.values import COLOR

_STANDING = """\
mission: standing
states:
  standing: {on: {operator.abort: over}}
  over: {type: final, outcome: aborted}
"""
"""What a vehicle without a mission flies."""


@dataclass(frozen=True)
class PreparedFleet:
    """A fleet with its missions, and everything that is wrong with them."""

    spec: FleetSpec
    assignments: Mapping[str, Assignment]
    """Those of the vehicles whose missions have no error."""
    fleet: Fleet
    faults: tuple[Fault, ...]
    """Errors and warnings, also of its missions."""

    @property
    def files(self) -> list[Path]:
        """The fleet's own file, then those of its missions, with resolved paths."""
        own = [self.fleet.file] if self.fleet.file else []
        paths = [
            *own,
            *(path for each in self.assignments.values() for path in each.prepared.files),
        ]
        return list(dict.fromkeys(path.resolve() for path in paths))

    @property
    def may_fly(self) -> bool:
        """Whether nothing is wrong that is an error."""
        return all(fault.severity != "error" for fault in self.faults)

    def require(self) -> None:
        """Raises UserError with every fault unless it may fly."""
        if not self.may_fly:
            raise UserError.of(self.faults)


def standing(world: World, word: str) -> Prepared:
    """What a vehicle without a mission flies, in a world and the word for it."""
    spec = read_mission_text(_STANDING)
    graph = compile_mission(spec, drone_vocabulary())
    return Prepared(Found(Path(spec.file), spec.file), spec, graph, world, word, ())


def prepare_any(
    found: Found, world: str | None = None, *, code: bool = True, calls: Calls | None = None
) -> Prepared | PreparedFleet:
    """A mission (see :func:`runner.preparation.prepare`), or a fleet where the file is one (see
    :func:`prepare_fleet`). Raises UserError.
    """
    try:
        return prepare(found, world, code=code, calls=calls)
    except UserError as error:
        where = error.faults[0].where
        # A mission may include a fleet by mistake.
        if error.code != FLEET or where is None or where.file != found.shown_as:
            raise
    return prepare_fleet(found, world, code=code, calls=calls)


def prepare_fleet(
    found: Found, world: str | None = None, *, code: bool = True, calls: Calls | None = None
) -> PreparedFleet:
    """Read and check a fleet with its missions; runs the Python files that they use, unless
    ``code`` is False, as ``calls``.

    Raises UserError when the fleet's own file or its world cannot be read.
    """
    spec, faults = read_fleet(found.path, found.shown_as)
    word, where = world_word(spec.world, found.path.parent, world)
    place = find_world(word, where), word
    peers = [name.text for name in spec.names]
    assignments: dict[str, Assignment] = {}
    known: dict[Path | None, Prepared] = {}
    """By file: of many vehicles that fly one mission it is checked once."""
    for member in spec.members:
        start, color = _start(member, place[0], faults), _color(member, faults)
        with faults.collecting():
            if member.path not in known:
                found_here = _prepared(member, place, peers, code=code, calls=calls)
                known[member.path] = found_here
                faults.extend(found_here.graph.warnings if member.spec else ())
            prepared = known[member.path]
            assignments[member.name.text] = Assignment(
                prepared,
                given_parameters(member, prepared.graph, Faults()),  # `check_fleet` tells of them
                stands=member.spec is None,
                model=named_from(found.path.parent, member.model.text) if member.model else None,
                model_where=member.model.where if member.model else None,
                start=start,
                color=color,
            )
    graphs = {name: each.prepared.graph for name, each in assignments.items()}
    faults.extend(check_fleet(spec, graphs))
    unflown = all(member.spec is None for member in spec.members) and spec.until is None
    if unflown and not faults.errors:
        message = "no vehicle of this fleet has a mission, and nothing says when it ends"
        hint = "give one a mission, or the fleet an `until`"
        faults.fail("no-mission", message, spec.names[0].where, hint)
    faults.extend(_faults_of_starts(spec, assignments, place[0]))
    until = _until(spec, graphs) if not faults.errors else None
    fleet = Fleet(spec.name, until, found.path, _contest(spec, faults))
    # Two vehicles may fly one mission: its faults are told once.
    return PreparedFleet(spec, assignments, fleet, tuple(dict.fromkeys(faults)))


def _prepared(
    member: Member,
    place: tuple[World, str],
    peers: list[str],
    *,
    code: bool,
    calls: Calls | None,
) -> Prepared:
    if member.spec is None or member.path is None:
        return standing(*place)
    found = Found(member.path, member.spec.file)
    return prepare_member(member.spec, found, place, peers, code=code, calls=calls)


def _start(member: Member, world: World, faults: Faults) -> Start | None:
    """The start that a fleet gives to a vehicle; what is wrong with it goes to ``faults``."""
    if member.start is not None:
        with faults.collecting():
            spot, heading = START.read(member.start)
            return Start(place_of(world.ground.terrain, spot), heading)
    return None


def _color(member: Member, faults: Faults) -> Rgb | None:
    """The colour that a fleet gives to a vehicle; what is wrong with it goes to ``faults``."""
    if member.color is not None:
        with faults.collecting():
            return COLOR.read(member.color)
    return None


def _contest(spec: FleetSpec, faults: Faults) -> Contest | None:
    """What the referee of a fleet looks at; what is wrong with it goes to ``faults``."""
    if spec.referee is not None:
        with faults.collecting():
            between, near = REFEREE.read(spec.referee)
            known = [name.text for name in spec.names]
            for name in between:
                if name.text not in known:
                    message = f"the fleet has no vehicle '{name.text}'"
                    hint = nearest(name.text, known)
                    raise UserError("unknown-vehicle", message, name.where, hint)
            return Contest((between[0].text, between[1].text), near)
    return None


def _faults_of_starts(
    spec: FleetSpec, assignments: Mapping[str, Assignment], world: World
) -> list[Fault]:
    """The faults of the starts of a fleet's vehicles, each by itself and together."""
    places = {
        member.name.text: member.start.where if member.start else member.name.where
        for member in spec.members
    }
    planned = [
        PlannedStart(start, places[name], f"'{name}'")
        for name, start in starts_of(assignments).items()
    ]
    return [
        *bad_starts(planned, world.things, world.ground.terrain),
        *starts_outside(planned, world.fence),
        *overlapping(planned, severity="warning"),
    ]


def _until(spec: FleetSpec, graphs: Mapping[str, Graph]) -> Until | None:
    if spec.until is None:
        return None
    return compile_until(spec.until.text, first_letter(spec.until), graphs, Faults())


def check_ways(
    assignments: Mapping[str, Assignment], terms: Mapping[str, Terms], calls: Calls | None = None
) -> Findings:
    """Look at where each vehicle of a run may fly (see :func:`runner.geometry.check_geometry`), on
    its own ``terms``; of several, what is found says of which.
    """
    found = {}
    for name, start in starts_of(assignments).items():
        flown = assignments[name]
        graph, world = flown.prepared.graph, flown.prepared.world
        found[name] = check_geometry(graph, world, terms[name], flown.parameters, calls, start)
    if are_alone(found):
        return found[ALONE]
    return Findings(
        tuple(
            replace(fault, message=f"{name}: {fault.message}")
            for name, each in found.items()
            for fault in each.faults
        ),
        tuple(f"{name}: {state}" for name, each in found.items() for state in each.unknown),
        tuple(dict.fromkeys(thing for each in found.values() for thing in each.moving)),
        all(each.complete for each in found.values()),
    )


def plans_of(
    assignments: Mapping[str, Assignment], terms: Mapping[str, Terms], calls: Calls | None = None
) -> dict[str, MissionPlan]:
    """Where each vehicle of a run may fly, as far as it is known, on its own ``terms``."""
    found = {}
    for name, start in starts_of(assignments).items():
        flown = assignments[name]
        graph, world = flown.prepared.graph, flown.prepared.world
        found[name] = plan_of(graph, world, terms[name], flown.parameters, calls, start)
    return found


def with_parameters(
    assignments: Mapping[str, Assignment],
    given: Mapping[str, str],
    warnings: list[Fault] | None = None,
) -> dict[str, Assignment]:
    """The assignments of a fleet with parameters from texts, ``{"cat.speed": "3 m/s"}``.

    What is doubtful in them is added to ``warnings``. Raises UserError for those of no vehicle or
    no parameter, and values that do not fit.
    """
    faults = Faults()
    hint: str | None
    texts: dict[str, dict[str, str]] = {name: {} for name in assignments}
    for key, text in given.items():
        vehicle, dot, name = key.partition(".")
        if not dot:
            message = f"this does not say which vehicle's parameter '{key}' is"
            hint = f"-p {_owner(assignments, key)}.{key}={text}"
            faults.fail("no-vehicle", message, Where(f"-p {key}"), hint)
        elif vehicle not in texts:
            hint = nearest(vehicle, assignments)
            message = f"the fleet has no vehicle '{vehicle}'"
            faults.fail("unknown-vehicle", message, Where(f"-p {key}"), hint)
        else:
            texts[vehicle][name] = text
    found = dict(assignments)
    for vehicle, own in texts.items():
        with faults.collecting():
            flown = assignments[vehicle]
            values = parse_given(flown.prepared.graph, own, warnings, vehicle=vehicle)
            parameters: Mapping[str, Any] = {**flown.parameters, **values}
            found[vehicle] = replace(flown, parameters=parameters)
    faults.raise_any()
    return found


def _owner(assignments: Mapping[str, Assignment], name: str) -> str:
    """The first vehicle whose mission has a parameter of this name, or else the first one."""
    owners = (v for v, each in assignments.items() if name in each.prepared.graph.parameters)
    return next(owners, next(iter(assignments)))
