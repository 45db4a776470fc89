"""Where a mission may fly, held against its world before the flight.

Warned of are legs (see :mod:`runner.planned_paths`) that lead below the ground, into or near
things, above the limits, out of the world's fence, or farther than the battery lasts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import dist, floor
from typing import Any

from behaviors import Calls, MissionFrame, Thresholds
from fsm import Graph
from fsm.chart.executable import Action
from fsm.chart.graph import Node
from fsm.checks.regions import actions_of
from fsm.values.types import AREA, AREAS, POINT, ROUTE
from hal import FlightModel, Limits
from runner.planned_motion import Setting
from runner.planned_paths import PossibleLeg, PossiblePaths, possible_paths
from vencejo.errors import Fault, Where
from vencejo.geometry import Point
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Scalar
from worlds import Start, World
from worlds.fence import leaves
from worlds.obstacles import Near, Obstacles
from worlds.terrain import height_at

CLEARANCE = 0.5
"""Least distance from things that is asked for by default, metres."""
ABOVE = 0.2
"""Metres above a thing at which a leg may begin or end over it, to land on it."""
MAX_COMPARED = 600_000
"""Legs times parts of things that are compared, as a bound on the time."""
MOST_ALIKE = 5
"""Warnings of one code in one state that are told."""
_SAME = 1e-6
_TOUCHING = 1e-3
_HOME = Point(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Terms:
    """What the legs of a mission are held against, beside its world."""

    model: FlightModel | None = None
    """How the vehicle flies; None where it is not known: then the battery is not looked at."""
    limits: Limits = field(default_factory=Limits)
    """Limits of flight, altitudes above home."""
    clearance: float = CLEARANCE
    """Least distance from things, metres."""


@dataclass(frozen=True)
class Findings:
    """What was found of the places where a mission may fly."""

    faults: tuple[Fault, ...]
    """Warnings."""
    unknown: tuple[str, ...]
    """States that fly where only the flight knows; what follows them up to the next known place is
    unknown, too."""
    moving: tuple[str, ...]
    """Things that move and may come near: where they are then is not known."""
    complete: bool
    """False where the mission has more ways than were looked at."""


def check_geometry(
    graph: Graph,
    world: World,
    terms: Terms,
    parameters: Mapping[str, Any] | None = None,
    calls: Calls | None = None,
    start: Start | None = None,
) -> Findings:
    """Look at where a mission may fly, from a start; without one from the first of the world.

    ``parameters`` are those that differ from their defaults; ``calls`` run the plans of a person's
    behaviours. The work is bounded, whatever the mission and its world.
    """
    obstacles = Obstacles(world)
    setting = _setting(graph, world, obstacles, terms, start, calls)
    paths = possible_paths(graph, parameters or {}, setting)
    view = _View(world, obstacles, setting.frame, terms, _may_refill(graph, world))
    most = MAX_COMPARED // (1 + len(obstacles))
    for leg in paths.legs[:most]:
        view.look_at(leg)
    return Findings(
        (*paths.faults, *view.faults()),
        tuple(node.path or graph.name for node in paths.unknown),
        tuple(view.moving),
        paths.complete and len(paths.legs) <= most,
    )


@dataclass(frozen=True)
class MissionPlan:
    """Where a mission may fly, as far as it is known before the flight."""

    frame: MissionFrame
    """Of the legs and shapes of ``paths``."""
    paths: PossiblePaths


def plan_of(
    graph: Graph,
    world: World,
    terms: Terms,
    parameters: Mapping[str, Any] | None = None,
    calls: Calls | None = None,
    start: Start | None = None,
) -> MissionPlan:
    """Where a mission may fly from a start; the parameters are those of :func:`check_geometry`."""
    setting = _setting(graph, world, Obstacles(world), terms, start, calls)
    return MissionPlan(setting.frame, possible_paths(graph, parameters or {}, setting))


def _setting(
    graph: Graph,
    world: World,
    obstacles: Obstacles,
    terms: Terms,
    start: Start | None,
    calls: Calls | None,
) -> Setting:
    """What the plans of a mission depend on, from a start; without one from the world's first."""
    start = start or world.starts[0]
    origin = world.origin
    geographic = (origin.lat, origin.lon, origin.alt) if origin else None
    ground = partial(height_at, world.ground.terrain)
    frame = MissionFrame(
        start.at, world.places, geographic, ground_height=ground, files=graph.files
    )

    def ground_below(place: Point) -> float:
        return obstacles.below(frame.to_world(place)).height - start.at.z

    return Setting(
        frame,
        start.heading,
        ground_below,
        1 + len(obstacles) // 50,
        terms.model,
        calls or Calls(),
        terms.limits.over(terms.model.limits) if terms.model else terms.limits,
    )


def _may_refill(graph: Graph, world: World) -> bool:
    """Whether the battery may be swapped or charged on the way: how full it is then is unknown."""
    called = (_called(action) for node in graph.nodes for action in actions_of(node))
    return any(thing.charges for thing in world.things) or "swap_battery" in called


def _called(action: Action) -> str:
    """The function that an action calls; empty for none."""
    if action.kind != "call":
        return ""
    named = action.node.entries[0][0] if isinstance(action.node, MapNode) else action.node
    return named.text if isinstance(named, Scalar) else ""


@dataclass(frozen=True)
class _Finding:
    """A fault with what decides which of several like it is told."""

    distance: float
    fault: Fault


class _View:
    """The legs of a mission in its world, one after the other."""

    def __init__(
        self,
        world: World,
        obstacles: Obstacles,
        frame: MissionFrame,
        terms: Terms,
        refills: bool,
    ) -> None:
        """``refills``: the battery may be swapped or charged on the way."""
        self.world = world
        self.obstacles = obstacles
        self.frame = frame
        self.terms = terms
        self.refills = refills
        self.moving: dict[str, None] = {}
        self.found: dict[tuple[str, Node, str], _Finding] = {}

    def faults(self) -> Iterator[Fault]:
        """The warnings, of each code and state the first MOST_ALIKE."""
        alike: dict[tuple[str, Node], list[Fault]] = {}
        for (code, node, _), finding in self.found.items():
            alike.setdefault((code, node), []).append(finding.fault)
        for faults in alike.values():
            yield from faults[: MOST_ALIKE - 1]
            more = len(faults) - MOST_ALIKE
            for last in faults[MOST_ALIKE - 1 : MOST_ALIKE]:
                also = f"; {more} more things are as near" if more else ""
                yield replace(last, hint=f"{last.hint}{also}")

    def warn(
        self, code: str, leg: PossibleLeg, message: str, hint: str, of: str = "", near: float = 0.0
    ) -> None:
        """Keep a warning of a leg, for each code, state and thing that of the nearest."""
        key = code, leg.node, of
        if key not in self.found or near < self.found[key].distance - 0.01:
            text = f"{message}: {leg.way}"
            fault = Fault(code, text, _place_of(leg.node), hint, "warning")
            self.found[key] = _Finding(near, fault)

    def look_at(self, leg: PossibleLeg) -> None:
        end = leg.leg.to
        begin = leg.begin or end
        a, b = self.frame.to_world(begin), self.frame.to_world(end)
        known = leg.begin is not None
        if known and self.obstacles.height_above_ground(a, a)[0] < -_SAME:
            return  # it never gets there
        if self.below_ground(leg, a, b):
            return
        self.near_things(leg, a, b)
        self.beyond_limits(leg)
        self.slower_than_asked(leg)
        self.outside_fence(leg, a, b)
        self.beyond_battery(leg)

    def below_ground(self, leg: PossibleLeg, a: Point, b: Point) -> bool:
        height, place = self.obstacles.height_above_ground(a, b)
        if height >= -_SAME * 1e3:
            return False
        at_end = self.obstacles.height_above_ground(b, b)[0]
        if at_end < 0:
            told = f"{_line(leg)} ends {-at_end:.3g} m below the ground"
            hint = "z is counted upwards from home"
        else:
            near = _shown(self.frame.from_world(place))
            told = f"{_line(leg)} leads through the ground near {near}"
            hint = "fly higher, or around the hill"
        self.warn("below-ground", leg, told, hint)
        return True

    def near_things(self, leg: PossibleLeg, a: Point, b: Point) -> None:
        behavior, clearance = leg.behavior, self.terms.clearance
        upright = (behavior.takes_off or behavior.ends_landed) and a[:2] == b[:2]
        if upright and not leg.sure:
            return  # an emergency may end anywhere
        near = self.obstacles.near(a, b, clearance)
        under = [self.obstacles.below(end).thing for end in (a, b)] if near else []
        # What it begins in was told of the leg that leads there.
        known = leg.begin is not None
        begun = self.obstacles.near(a, a, _TOUCHING) if near and known else ()
        inside = [each.thing for each in begun]
        for each in near:
            if each.thing in inside:
                continue
            stood_on = each.thing in under
            if stood_on and ((upright and _is_level_with(each, a, b)) or each.distance >= ABOVE):
                continue
            self.warn_of_thing(leg, each, b)
        self.moving.update((t.name, None) for t in self.obstacles.moving_near(a, b, clearance))

    def warn_of_thing(self, leg: PossibleLeg, near: Near, end: Point) -> None:
        thing, place = near.thing, _shown(self.frame.from_world(near.place))
        what, name = f"the {thing.kind} '{thing.name}'", thing.name
        if near.distance < _TOUCHING:
            inside = any(each.thing is thing for each in self.obstacles.near(end, end, _TOUCHING))
            into = "into" if inside else "through"
            told = f"{_line(leg)} leads {into} {what} near {place}"
            self.warn("hits-thing", leg, told, "fly over it or around it", name)
        elif ("hits-thing", leg.node, name) not in self.found:
            told = (
                f"{_line(leg)} passes {_rounded_down(near.distance)} m from {what}, near {place}; "
                f"{self.terms.clearance:g} m are asked for"
            )
            hint = "keep away from it, or ask for less: --clearance"
            self.warn("near-thing", leg, told, hint, name, near.distance)

    def beyond_limits(self, leg: PossibleLeg) -> None:
        low, high = self.terms.limits.min_altitude, self.terms.limits.max_altitude
        end, begin = leg.leg.to.z, leg.begin.z if leg.begin else None
        told = f"'{leg.behavior.name}' leads to {_shown(leg.leg.to)}"
        if _comes_above(begin, end, high):
            limit = f"{told}, above the limit of {high:g} m"
            self.warn("beyond-limits", leg, limit, "fly lower, or raise max_altitude")
        if low is not None and end < low - _SAME and leg.behavior.needs_flight:
            limit = f"{told}, below the limit of {low:g} m"
            self.warn("beyond-limits", leg, limit, "fly higher, or lower min_altitude")

    def slower_than_asked(self, leg: PossibleLeg) -> None:
        slower = leg.leg.slower
        if slower is not None:
            told = (
                f"'{leg.behavior.name}' flies its path at {slower.speed:.2g} m/s, not at "
                f"{slower.asked:.3g} m/s: its bends need more tilt, or it is beyond another limit"
            )
            hint = "ask for less speed or give more time, make its bends wider, or raise max_tilt"
            self.warn("slower-than-asked", leg, told, hint)

    def outside_fence(self, leg: PossibleLeg, a: Point, b: Point) -> None:
        fence = self.world.fence
        if fence is None:
            return
        told = f"{_line(leg)} leads"
        if leaves(fence, a, b):
            told = f"{told} out of the fence of the world '{self.world.name}'"
            self.warn("outside-fence", leg, told, "stay inside, or draw the fence wider", "sides")
        if _comes_above(a.z if leg.begin else None, b.z, fence.ceiling):
            told = f"{told} above the ceiling of the fence, {fence.ceiling:g} m in the world"
            self.warn("outside-fence", leg, told, "fly lower, or raise the ceiling", "ceiling")
        if b.z < fence.floor - _SAME and leg.behavior.needs_flight:
            told = f"{told} below the floor of the fence, {fence.floor:g} m in the world"
            self.warn("outside-fence", leg, told, "fly higher, or lower the floor", "floor")

    # -- the battery ----------------------------------------------------------------------------

    def beyond_battery(self, leg: PossibleLeg) -> None:
        model, begin, planned = self.terms.model, leg.begin, leg.leg
        if model is None or begin is None:
            return
        # How full it is after a refill is unknown: full at the most.
        full = 1.0 if self.refills else self.world.battery - leg.charge
        left = full - Thresholds().battery_critical
        if left < 0:
            return  # an earlier leg has told it
        taken = model.leg_charge(begin, planned.to, planned.speed, planned.dwell)
        if taken > left:
            share = left / taken
            told = (
                f"{_line(leg)} is farther than the battery lasts: it is critical after "
                f"{share * dist(begin, planned.to):.0f} m of {dist(begin, planned.to):.0f} m"
            )
            self.warn("beyond-battery", leg, told, self._how_far(leg, left))
        elif self.refills or leg.behavior.ends_landed:
            return  # no way home is needed
        elif left - taken < self._home_from(planned.to):
            told = f"{_line(leg)} leads farther than the battery brings it back"
            self.warn("no-return", leg, told, self._how_far(leg, left))

    def _home_from(self, place: Point) -> float:
        """The share of a full battery that the straight way home takes, the descent included."""
        assert self.terms.model is not None
        over = _HOME._replace(z=place.z)
        charge = self.terms.model.leg_charge
        return charge(place, over, None, 0.0) + charge(over, _HOME, None, 0.0)

    def _how_far(self, leg: PossibleLeg, left: float) -> str:
        """The point of no return on a leg, which begins with so much of the battery to spare."""
        model, begin = self.terms.model, leg.begin
        assert model is not None and begin is not None
        way = leg.leg.to.minus(begin)

        def spare(share: float) -> float:
            to = begin.plus((way.x * share, way.y * share, way.z * share))
            return left - model.leg_charge(begin, to, leg.leg.speed, 0.0) - self._home_from(to)

        if spare(0.0) < 0:
            return "it brings it home no longer from where this leg begins"
        low, high = 0.0, 1.0
        while high - low > 1e-4:
            middle = (low + high) / 2
            low, high = (middle, high) if spare(middle) >= 0 else (low, middle)
        to = begin.plus((way.x * low, way.y * low, way.z * low))
        return f"the point of no return is {_shown(to)}, {low * way.norm():.0f} m on this leg"


def _is_level_with(near: Near, a: Point, b: Point) -> bool:
    """Whether a thing is no nearer than at the lower end of a take-off or landing."""
    return abs(near.place.z - min(a.z, b.z)) < ABOVE


def _comes_above(begin: float | None, end: float, limit: float | None) -> bool:
    """Whether a leg is the one that comes above a limit; None for no limit, and no known begin."""
    if limit is None or end <= limit + _SAME:
        return False
    return begin is None or begin <= limit + _SAME


def _line(leg: PossibleLeg) -> str:
    """``the leg from [0, 0, 2] to [0, 14, 2]``."""
    begin = f"from {_shown(leg.begin)} " if leg.begin is not None else ""
    return f"the leg {begin}to {_shown(leg.leg.to)}"


def _rounded_down(distance: float) -> str:
    """A distance in full centimetres, so that one too small is not shown as what is asked for."""
    return f"{floor(distance * 100 + 1e-6) / 100:.2f}"


def _shown(place: Point) -> str:
    numbers = (round(v, 2) + 0.0 for v in place)
    return f"[{', '.join(f'{v:g}' for v in numbers)}]"


def _place_of(node: Node) -> Where:
    """The place in the file that says where a state flies."""
    invocation = node.invocation
    assert invocation is not None
    for name, parameter in invocation.behavior.parameters.items():
        given = invocation.live.get(name) or invocation.with_.get(name)
        if given is not None and parameter.type in (POINT, ROUTE, AREA, AREAS):
            return given.where
    return node.where
