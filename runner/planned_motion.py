"""Where the vehicle is before, during and after a behaviour, by the behaviour's plan."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import dist, isfinite
from typing import Any, Literal, NamedTuple

from behaviors import UNKNOWN, Calls, CodeFailed, MissionFrame, PlannedLeg, PlanStart
from behaviors.params import Face, Waypoint
from behaviors.plan import NotKnown, Unflyable, Unknown
from fsm.chart.graph import Node
from fsm.expressions.compiled import Compiled
from fsm.host import BehaviorInfo
from fsm.values.functions import FAILURES
from hal import FlightModel, Limits
from vencejo.errors import Fault
from vencejo.geometry import Point

MAX_PLACES = 12
"""Places that stand for all those where a behaviour may be interrupted."""
SPACING = 2.0
"""Metres between such places, where so many are enough."""


class PlannedShape(NamedTuple):
    """A point, a route or an area that a state's behaviour is given. Mission frame, metres."""

    node: Node
    parameter: str
    kind: Literal["point", "route", "area"]
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Setting:
    """What plans depend on beside the mission."""

    frame: MissionFrame
    yaw: float
    """The heading at the start, radians counter-clockwise from east."""
    ground_below: Callable[[Point], float]
    """The height of what lies straight below a place, mission frame."""
    ground_work: int = 1
    """The work that asking for it is, in plans asked for."""
    model: FlightModel | None = None
    """How the vehicle flies; None where it is not known."""
    calls: Calls = field(default_factory=Calls)
    """The calls of people's plans."""
    limits: Limits = field(default_factory=Limits)
    """The limits of flight, as far as they are known."""


class Place(NamedTuple):
    """Where the vehicle may be; a tuple, in whose comparison what is unknown equals itself."""

    points: tuple[Point, ...]
    """Mission frame; none where it is not known."""
    yaw: float
    """Radians counter-clockwise from east, or UNKNOWN."""
    flying: bool


@dataclass(frozen=True, slots=True)
class Course:
    """The legs of a plan from one of the places where it may begin."""

    begin: Point | None
    """None where it is not known."""
    legs: tuple[PlannedLeg, ...]

    def flown(self, within: float) -> Iterator[tuple[Point | None, PlannedLeg]]:
        """The begins and legs that are flown within a time, seconds; the last perhaps in part."""
        begin, left = self.begin, within
        for leg in self.legs:
            seconds = _seconds(begin, leg)
            yield begin, leg if seconds <= left else _part(begin, leg, left)
            left -= seconds
            if left <= 0:
                return
            begin = leg.to

    @property
    def seconds(self) -> float:
        """The time that it takes at the least."""
        begins = (self.begin, *(leg.to for leg in self.legs))
        return sum(map(_seconds, begins, self.legs))


@dataclass(frozen=True, slots=True)
class Motion:
    """A behaviour that moves the vehicle, from one place to another."""

    node: Node
    """Its state."""
    begin: Place
    courses: tuple[Course, ...]
    """None where it is not known where it flies."""

    @property
    def behavior(self) -> BehaviorInfo:
        assert self.node.invocation is not None
        return self.node.invocation.behavior

    @property
    def grounded(self) -> bool:
        """Whether the vehicle stays on the ground, since this moves only what is in the air."""
        return self.behavior.needs_flight and not self.begin.flying

    def anywhere(self, within: float) -> Place:
        """Where it may be interrupted, within a time, seconds."""
        behavior, place = self.behavior, self.begin
        flying = place.flying or behavior.takes_off
        corners, between = dict[Point, None](), dict[Point, None]()
        unknown = not self.courses and not self.grounded
        for course in self.courses:
            if course.begin is None:
                unknown = unknown or bool(course.legs)
                continue
            corners[course.begin] = None
            for begin, leg in course.flown(within):
                assert begin is not None
                corners[leg.to] = None
                between.update(dict.fromkeys(_along(begin, leg.to)))
        if unknown:
            return Place((), UNKNOWN, flying)
        turns = any(course.legs for course in self.courses)
        yaw = UNKNOWN if turns and behavior.needs_flight else place.yaw
        points = [*_spread([*corners], MAX_PLACES)]
        points += _spread([*between], MAX_PLACES - len(points))
        return Place(tuple(points), yaw, flying)

    def done(self, within: float) -> tuple[Place, list[Course]] | None:
        """Where it ends in `done`, and by which courses; None if it takes longer than that."""
        behavior, place = self.behavior, self.begin
        courses = [course for course in self.courses if course.seconds <= within]
        if self.courses and not courses:
            return None
        ends = {c.legs[-1].to if c.legs else c.begin: None for c in courses}
        yaws = {c.legs[-1].yaw if c.legs else place.yaw: None for c in courses}
        (yaw,) = yaws if len(yaws) == 1 else (None,)
        flying = not behavior.ends_landed and (behavior.takes_off or place.flying)
        points = tuple(end for end in ends if end is not None)
        return Place(points, UNKNOWN if yaw is None else yaw, flying), courses


class Planner:
    """Asks behaviours for their plans."""

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self.asked = 0
        """The number of plans asked for."""
        self.faults: list[Fault] = []
        """Plans that could not be had."""
        self.unknown: dict[Node, None] = {}
        """States that fly where only the flight knows, though it is known where they begin, or
        wherever they begin."""
        self.shapes: dict[PlannedShape, None] = {}
        """What behaviours are given that is known before the flight."""
        self._grounds: dict[Point, float] = {}
        self._looked_at: set[tuple[Node, str]] = set()

    def look_at(self, node: Node, value: Callable[[Compiled], Any]) -> None:
        """Ask for the plan of a behaviour that moves nothing, for what it refuses in its
        parameters; ``value`` as in :meth:`motion`.
        """
        given = self._given(node, value)
        if (node, repr(given)) not in self._looked_at:
            self._looked_at.add((node, repr(given)))
            self._legs(node, None, Place((), UNKNOWN, False), given)
            self.unknown.pop(node, None)  # it flies nowhere

    def motion(self, node: Node, begin: Place, value: Callable[[Compiled], Any]) -> Motion:
        """The motion of a state's behaviour; ``value`` gives that of an expression, None for none
        that is known.
        """
        invocation = node.invocation
        assert invocation is not None
        if invocation.behavior.needs_flight and not begin.flying:
            return Motion(node, begin, tuple(Course(point, ()) for point in begin.points))
        given = self._given(node, value)
        courses: dict[Course, None] = {}
        for point in begin.points or (None,):
            legs = self._legs(node, point, begin, given)
            if legs is None:
                return Motion(node, begin, ())
            courses[Course(point, legs)] = None
        return Motion(node, begin, tuple(courses))

    def _given(self, node: Node, value: Callable[[Compiled], Any]) -> dict[str, Any]:
        """The values that a state gives its behaviour, by parameter."""
        invocation = node.invocation
        assert invocation is not None
        given = {}
        for name in invocation.behavior.parameters:
            source = invocation.live.get(name) or invocation.with_.get(name)
            if source is not None:
                known = value(source)
                given[name] = UNKNOWN if known is None else known
        return given

    def _legs(
        self, node: Node, point: Point | None, begin: Place, given: dict[str, Any]
    ) -> tuple[PlannedLeg, ...] | None:
        """The legs of a behaviour from a place; None where they are not known."""
        assert node.invocation is not None
        self.asked += 1
        behavior, model = node.invocation.behavior, self.setting.model
        if behavior.implementation is None:
            self.unknown[node] = None
            return None
        start = PlanStart(
            UNKNOWN if point is None else point,
            begin.yaw,
            UNKNOWN if point is None else begin.flying,
            UNKNOWN if point is None else self._ground_below(point),
            UNKNOWN if model is None else model.return_height,
            self.setting.limits,
        )
        parameters = self._resolved(behavior, given, start)
        for name, value in parameters.items():
            self.shapes.update(dict.fromkeys(_shapes_of(node, name, value)))
        class_ = behavior.implementation
        try:
            legs = self.setting.calls.run(lambda: class_.plan(class_.Params(**parameters), start))
        except CodeFailed as error:
            if not isinstance(error.cause, NotKnown) or point is not None:
                self.unknown[node] = None
            if isinstance(error.cause, Unflyable):
                self._tell(_fault_of(node, error.cause))
            elif not isinstance(error.cause, NotKnown):
                at = f" ({error.where.file}:{error.where.line})" if error.where else ""
                self._mistake(node, f"failed: {error.message}{at}")
            return None
        checked = None if legs is None else self._checked(node, legs)
        if checked is None and (legs is None or point is not None):
            self.unknown[node] = None
        return checked

    def _checked(self, node: Node, legs: Any) -> tuple[PlannedLeg, ...] | None:
        """What a plan has given; None where it is wrong, or leads to what is not known."""
        if not isinstance(legs, (list, tuple)) or not all(isinstance(x, PlannedLeg) for x in legs):
            self._mistake(node, f"gave {legs!r:.60}, not a list of PlannedLeg")
            return None
        if any(map(_is_open, legs)):
            return None
        wrong = next((leg for leg in legs if not _is_right(leg)), None)
        if wrong is not None:
            self._mistake(node, f"has a leg that is none: {wrong!r:.90}")
            return None
        # A heading from the start may be UNKNOWN, which is no value to compare.
        return tuple(replace(x, yaw=None) if isinstance(x.yaw, Unknown) else x for x in legs)

    def _mistake(self, node: Node, what: str) -> None:
        assert node.invocation is not None
        message = f"the plan of '{node.invocation.behavior.name}' {what}"
        hint = "`plan` returns a list of PlannedLeg in the mission frame, or None"
        self._tell(Fault("broken-plan", message, node.where, hint, "warning"))

    def _tell(self, fault: Fault) -> None:
        if fault not in self.faults:
            self.faults.append(fault)

    def _resolved(
        self, behavior: BehaviorInfo, given: dict[str, Any], start: PlanStart
    ) -> dict[str, Any]:
        """The parameters of a behaviour in the form that it uses."""
        found: dict[str, Any] = {}
        for name, parameter in behavior.parameters.items():
            try:
                value = given.get(name, parameter.default)
                found[name] = self.setting.frame.resolve(parameter.type, value, start)
            except FAILURES:
                found[name] = UNKNOWN
        return found

    def _ground_below(self, point: Point) -> float:
        if point not in self._grounds:
            self.asked += self.setting.ground_work
            self._grounds[point] = self.setting.ground_below(point)
        return self._grounds[point]

    def charge(self, legs: Iterable[tuple[Point | None, PlannedLeg]]) -> float:
        """The share of a full battery that legs take at the least, each with its begin."""
        model = self.setting.model
        if model is None:
            return 0.0
        return sum(
            model.leg_charge(begin, leg.to, leg.speed, leg.dwell)
            for begin, leg in legs
            if begin is not None
        )


def _shapes_of(node: Node, name: str, value: Any) -> Iterator[PlannedShape]:
    """The shapes that a resolved parameter has, without those that are not known."""
    if isinstance(value, Point):
        yield from _known(PlannedShape(node, name, "point", (value,)))
    elif isinstance(value, Face):
        yield from _known(PlannedShape(node, name, "point", (value.point,)))
    elif isinstance(value, (list, tuple)) and value:
        if all(isinstance(each, Waypoint) for each in value):
            yield from _known(PlannedShape(node, name, "route", tuple(each.at for each in value)))
        elif all(isinstance(each, Point) for each in value):
            yield from _known(PlannedShape(node, name, "area", tuple(value)))
        elif all(isinstance(each, (list, tuple)) for each in value):
            for each in value:
                yield from _shapes_of(node, name, each)


def _known(shape: PlannedShape) -> Iterator[PlannedShape]:
    if not any(isinstance(part, Unknown) for point in shape.points for part in point):
        yield shape


def _fault_of(node: Node, unflyable: Unflyable) -> Fault:
    """The fault for parameters that make no flight, at the one that is to be changed."""
    invocation = node.invocation
    assert invocation is not None
    name = unflyable.parameter
    given = invocation.live.get(name) or invocation.with_.get(name)
    message = f"'{invocation.behavior.name}' cannot fly this: {unflyable}"
    where = given.where if given else node.where
    return Fault("unflyable", message, where, unflyable.hint or None, "error")


def _is_open(leg: PlannedLeg) -> bool:
    """Whether a leg leads to a place that is not known before the flight."""
    parts: Any = leg.to if isinstance(leg.to, tuple) else (leg.to,)
    return any(isinstance(part, Unknown) for part in parts)


def _is_right(leg: PlannedLeg) -> bool:
    """Whether a leg has a place, and a speed and a stay that can be: a person's code made it."""
    place: Any = leg.to
    numbers: list[Any] = [leg.dwell, 0.0 if leg.speed is None else leg.speed]
    known = isinstance(place, Point) and all(
        isinstance(v, (int, float)) and isfinite(v) for v in (*place, *numbers)
    )
    return known and min(numbers) >= 0


def _seconds(begin: Point | None, leg: PlannedLeg) -> float:
    """The time that a leg takes at the least."""
    return (dist(begin, leg.to) / leg.speed if begin and leg.speed else 0.0) + leg.dwell


def _part(begin: Point | None, leg: PlannedLeg, seconds: float) -> PlannedLeg:
    """The part of a leg that is flown within a time."""
    if begin is None or not leg.speed:
        return leg
    length, way = dist(begin, leg.to), leg.to.minus(begin)
    share = min(1.0, max(0.0, seconds) * leg.speed / length) if length else 1.0
    to = begin.plus((way.x * share, way.y * share, way.z * share))
    return replace(leg, to=to, dwell=0.0)


def _along(a: Point, b: Point) -> Iterator[Point]:
    """Places between two, SPACING apart, or as many as are looked at."""
    parts = min(MAX_PLACES, int(dist(a, b) / SPACING) + 1)
    way = b.minus(a)
    for k in range(1, parts):
        share = k / parts
        yield a.plus((way.x * share, way.y * share, way.z * share))


def _spread(points: Sequence[Point], most: int) -> Sequence[Point]:
    """So many of some points at the most, spread evenly over them."""
    if len(points) <= most or most <= 0:
        return points[: max(0, most)]
    return [points[k * len(points) // most] for k in range(most)]
