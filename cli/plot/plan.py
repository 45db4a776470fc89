"""The picture of a mission before its flight: where it may fly, over its world from above."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import dist, hypot, log10
from typing import TypeVar

from cli.plot.axes import LABEL, Axes, axes_from_above
from cli.plot.canvas import DARK, RED, WHITE, XY, Box, Canvas, Color, fitted, text_width
from cli.plot.flight import COLORS
from cli.plot.ground import draw_fence, draw_world, mark_start
from cli.vehicle_colors import vehicle_colors
from fsm import Graph
from fsm.chart.graph import Node
from runner.geometry import MissionPlan
from runner.planned_motion import PlannedShape
from runner.planned_paths import PossibleLeg
from vencejo.geometry import Point
from worlds import World
from worlds.fence import surrounds
from worlds.world import Fence

T = TypeVar("T")
_WIDTH = 1280
_MAP = Box(58, 62, 858, 862)
_LEFT, _RIGHT = 890, _WIDTH - 16
"""The column of the legend."""
_ROOM = _RIGHT - _LEFT - 26
"""The width of its texts, beside the swatches."""
_LINE = 17
"""Height of a line of the legend."""
_MANY = 19
"""Entries of the legend that have two lines; of more each has one."""
_ARROW = 36.0
"""Pixels of a leg from which on it has an arrow."""


@dataclass(frozen=True)
class Planned:
    """What is drawn of one vehicle."""

    name: str
    """Empty for a vehicle that flies alone."""
    graph: Graph
    plan: MissionPlan
    hull: Color | None = None
    """Its colour; None where that is not known."""


@dataclass(frozen=True)
class _Entry:
    """One state: what it flies and is given, in one colour. World frame, metres."""

    vehicle: str
    """Empty for one that flies alone."""
    state: str
    behavior: str
    color: Color
    legs: Sequence[PossibleLeg]
    """Those that begin at one place first; mission frame."""
    shapes: Sequence[PlannedShape]
    plan: MissionPlan

    def ends(self, leg: PossibleLeg) -> tuple[XY | None, XY]:
        """Where a leg begins, if it is known, and where it ends, from above."""
        begin = None if leg.begin is None else self.above(leg.begin)
        return begin, self.above(leg.leg.to)

    def above(self, point: Point) -> XY:
        x, y, _ = self.plan.frame.to_world(point)
        return x, y

    def places(self) -> Iterator[XY]:
        for leg in self.legs:
            yield from (place for place in self.ends(leg) if place is not None)
        for shape in self.shapes:
            yield from map(self.above, shape.points)


def draw_plan(title: str, world: World, vehicles: Sequence[Planned]) -> bytes:
    """The picture as PNG: every known leg, point, route and area, and what is not known."""
    entries = list(_entries(vehicles))
    unknown = list(_unknown(vehicles))
    complete = all(each.plan.paths.complete for each in vehicles)
    legend = len(entries) * _row(entries) + (len(unknown) + 6) * _LINE
    canvas = Canvas(_WIDTH, round(max(_MAP.bottom + 44, _MAP.top + legend)))
    starts = [each.plan.frame.to_world(Point(0.0, 0.0, 0.0)) for each in vehicles]
    places = [*((x, y) for x, y, _ in starts), *(p for each in entries for p in each.places())]
    axes = axes_from_above(_MAP, places, 0.12, 8.0)
    axes.grid(canvas, y_spacing=60)
    for entry in entries:
        _draw_areas(canvas, axes, entry)
    draw_world(canvas, axes, world)
    draw_fence(canvas, axes, world)
    for draw in (_draw_doubtful, _draw_legs, _draw_points):
        for entry in entries:
            draw(canvas, axes, entry)
    for x, y, _ in starts:
        mark_start(canvas, axes.place(x, y))
    canvas.erase_outside(_MAP)
    _write_names(canvas, axes, entries)
    axes.frame(canvas, "where it may fly, from above, north up; metres")
    axes.label_x(canvas)
    axes.label_y(canvas, 60)
    _draw_scale(canvas, axes)
    canvas.text((_MAP.left, 22), title, 18)
    _draw_legend(canvas, entries, unknown, complete=complete)
    return canvas.png()


# -- what is drawn ---------------------------------------------------------------------------------


def _entries(vehicles: Sequence[Planned]) -> Iterator[_Entry]:
    """The states that fly somewhere known or are given a place, in the order of the document.

    Colours tell the states of one vehicle apart, or several vehicles.
    """
    number = 0
    hulls = vehicle_colors({each.name: each.hull for each in vehicles}, COLORS)
    for each in vehicles:
        paths = each.plan.paths
        legs = _by_node((leg.node, leg) for leg in paths.legs)
        shapes = _by_node((shape.node, shape) for shape in paths.shapes)
        for node in sorted({*legs, *shapes}, key=lambda node: node.index):
            color = hulls[each.name] if each.name else COLORS[number % len(COLORS)]
            number += 1
            own = sorted(_distinct(legs.get(node, ())), key=lambda leg: not leg.sure)
            assert node.invocation is not None
            yield _Entry(
                each.name,
                _name(node, each.graph),
                node.invocation.behavior.name,
                color,
                own,
                shapes.get(node, ()),
                each.plan,
            )


def _by_node(pairs: Iterable[tuple[Node, T]]) -> dict[Node, list[T]]:
    found: dict[Node, list[T]] = {}
    for node, each in pairs:
        found.setdefault(node, []).append(each)
    return found


def _distinct(legs: Sequence[PossibleLeg]) -> Sequence[PossibleLeg]:
    """Each way between two places once: those that are sure, and of the others what is not."""
    sure = {(leg.begin, leg.leg.to) for leg in legs if leg.sure}
    return [leg for leg in legs if leg.sure or (leg.begin, leg.leg.to) not in sure]


def _name(node: Node, graph: Graph) -> str:
    return node.path or graph.name


def _unknown(vehicles: Sequence[Planned]) -> Iterator[str]:
    """The states that fly where only the flight knows."""
    for each in vehicles:
        drawn = {leg.node for leg in each.plan.paths.legs}
        for node in each.plan.paths.unknown:
            behavior = f" ({node.invocation.behavior.name})" if node.invocation else ""
            vehicle = f"{each.name}: " if each.name else ""
            partly = ", not always as drawn" if node in drawn else ""
            yield f"{vehicle}{_name(node, each.graph)}{behavior}{partly}"


# -- the map ---------------------------------------------------------------------------------------


def _draw_areas(canvas: Canvas, axes: Axes, entry: _Entry) -> None:
    """Areas are filled but for those inside others, which are left out of them."""
    areas = [s for s in entry.shapes if s.kind == "area" and len(s.points) > 2]
    corners = sorted((list(map(entry.above, s.points)) for s in areas), key=_size, reverse=True)
    for number, outline in enumerate(corners):
        inside = any(surrounds(Fence(tuple(large)), *outline[0]) for large in corners[:number])
        fill = WHITE if inside else _pale(entry.color)
        canvas.area(axes.places(outline), fill, entry.color)


def _draw_doubtful(canvas: Canvas, axes: Axes, entry: _Entry) -> None:
    """Legs that begin anywhere along one that was interrupted, or where nobody knows."""
    for leg in entry.legs:
        begin, end = entry.ends(leg)
        if begin is None:
            _ring(canvas, axes.place(*end), entry.color)
        elif not leg.sure:
            canvas.dashes(axes.places((begin, end)), _pale(entry.color, 0.5), 1.2)


def _draw_legs(canvas: Canvas, axes: Axes, entry: _Entry) -> None:
    for leg in entry.legs:
        begin, end = entry.ends(leg)
        if begin is None or not leg.sure:
            continue
        way = axes.places((begin, end))
        at = way[1]
        length = hypot(at[0] - way[0][0], at[1] - way[0][1])
        canvas.line(way, entry.color, 2.2)
        if length < 1.0:
            _ring(canvas, at, entry.color)
        elif length >= _ARROW:
            _arrow(canvas, way, entry.color)


def _draw_points(canvas: Canvas, axes: Axes, entry: _Entry) -> None:
    for shape in entry.shapes:
        if shape.kind == "area":
            continue
        places = list(map(entry.above, shape.points))
        if shape.kind == "route" and not entry.legs:
            canvas.dashes(axes.places(places), entry.color, 1.5)
        for place in places:
            canvas.disc(axes.place(*place), 3.0, entry.color)


def _write_names(canvas: Canvas, axes: Axes, entries: Sequence[_Entry]) -> None:
    """Name each state at the middle of its longest leg, and points, where there is room."""
    taken: list[Box] = []
    for entry in entries:
        for (x, y), name in _names(axes, entry):
            width = text_width(name, 11)
            sides = ((x + 8, x - 8 - width), (y - 9, y + 9, y - 22, y + 22))
            for middle, left in product(*reversed(sides)):
                box = Box(left, middle - 7, left + width, middle + 7)
                inside = _MAP.holds((box.left, box.top)) and _MAP.holds((box.right, box.bottom))
                if inside and not any(_overlap(box, other) for other in taken):
                    taken.append(box)
                    canvas.text((left, middle), name, 11, _dark(entry.color))
                    break


def _names(axes: Axes, entry: _Entry) -> Iterator[tuple[XY, str]]:
    """Names with the pixel that they belong to: of the state, and of points that it is given."""
    sure = [leg for leg in entry.legs if leg.sure and leg.begin is not None]
    ends = [axes.places(end for end in entry.ends(leg) if end is not None) for leg in sure]
    if ends:
        a, b = max(ends, key=lambda each: dist(*each))
        yield ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2), entry.state
    elif entry.legs:
        yield axes.place(*entry.ends(entry.legs[0])[1]), entry.state
    flown = [end for leg in entry.legs for end in entry.ends(leg) if end is not None]
    for shape in entry.shapes:
        at = entry.above(shape.points[0])
        if shape.kind != "point" and not entry.legs:
            yield axes.place(*at), entry.state
        elif shape.kind == "point" and all(dist(at, end) > 0.05 for end in flown):
            yield axes.place(*at), f"{entry.state} {shape.parameter}"


def _draw_scale(canvas: Canvas, axes: Axes) -> None:
    """A bar of a round length, a quarter of the map or less."""
    metre = axes.x.pixel(1.0) - axes.x.pixel(0.0)
    most = _MAP.width / 4 / metre
    power = 10.0 ** (log10(most) // 1)
    length = max(n * power for n in (1, 2, 5) if n * power <= most)
    left, y = _MAP.left + 16, _MAP.bottom - 16
    right = left + length * metre
    canvas.rectangle(Box(left - 6, y - 22, right + 6, y + 7), WHITE)
    canvas.line([(left, y - 5), (left, y), (right, y), (right, y - 5)], DARK, 1.5)
    canvas.text(((left + right) / 2, y - 5), f"{length:g} m", 12, DARK, "mb")


# -- the legend ------------------------------------------------------------------------------------


def _draw_legend(
    canvas: Canvas, entries: Sequence[_Entry], unknown: Sequence[str], *, complete: bool
) -> None:
    top = _MAP.top - 9.0
    canvas.text((_LEFT, top), "heights are above home")
    top += 22
    for entry in entries:
        canvas.line([(_LEFT, top), (_LEFT + 18, top)], entry.color, 3)
        vehicle = f"{entry.vehicle}: " if entry.vehicle else ""
        behavior = "" if entry.state.endswith(entry.behavior) else f"  {entry.behavior}"
        title, told = f"{vehicle}{entry.state}{behavior}", _told(entry)
        if len(entries) > _MANY:
            canvas.text((_LEFT + 26, top), fitted(f"{title}, {told}", _ROOM, 11), 11)
        else:
            canvas.text((_LEFT + 26, top), fitted(title, _ROOM))
            canvas.text((_LEFT + 26, top + _LINE), fitted(told, _ROOM, 11), 11, LABEL)
        top += _row(entries)
    if any(not leg.sure for entry in entries for leg in entry.legs):
        canvas.dashes([(_LEFT, top), (_LEFT + 18, top)], LABEL, 1.2)
        canvas.text(
            (_LEFT + 26, top), "begins where something before it may be interrupted", 11, LABEL
        )
        top += _LINE + 8
    if unknown:
        canvas.text((_LEFT, top), "known in flight only:", 12, DARK)
        for number, name in enumerate(unknown, 1):
            canvas.text((_LEFT + 26, top + number * _LINE), fitted(name, _ROOM, 11), 11, LABEL)
        top += (len(unknown) + 1) * _LINE + 8
    if not complete:
        text = "it has more ways than were followed: legs are missing"
        canvas.text((_LEFT, top), text, 11, RED)


def _row(entries: Sequence[_Entry]) -> int:
    """The height of an entry."""
    return _LINE + 2 if len(entries) > _MANY else 2 * _LINE + 6


def _told(entry: _Entry) -> str:
    """The heights and the length of what a state flies, and the shapes that it is given."""
    told = []
    sure = [leg for leg in entry.legs if leg.sure]
    heights = [p.z for leg in sure or entry.legs for p in (leg.begin, leg.leg.to) if p is not None]
    if heights:
        told.append(_heights(heights))
    length = sum(dist(leg.begin, leg.leg.to) for leg in sure if leg.begin is not None)
    if length >= 0.05:
        told.append(f"{length:.3g} m long")
    given = {
        kind: [s for s in entry.shapes if s.kind == kind] for kind in ("point", "route", "area")
    }
    told += [f"route of {len(s.points)} points" for s in given["route"]]
    told += [f"{s.parameter} of {len(s.points)} corners" for s in given["area"]]
    told += [s.parameter for s in given["point"] if not entry.legs]
    return ", ".join(told)


def _heights(heights: Sequence[float]) -> str:
    """``at 3 m``, ``from 0 to 3 m``, or ``between 1 and 6 m`` where it goes up and down."""
    first, last = heights[0], heights[-1]
    low, high = min(heights), max(heights)
    if high - low < 0.05:
        return f"at {_metres(first)} m"
    if {_metres(first), _metres(last)} == {_metres(low), _metres(high)}:
        return f"from {_metres(first)} to {_metres(last)} m"
    return f"between {_metres(low)} and {_metres(high)} m"


def _metres(value: float) -> str:
    return f"{round(value, 1) + 0.0:g}"


# -- small figures ---------------------------------------------------------------------------------


def _ring(canvas: Canvas, place: XY, color: Color) -> None:
    canvas.disc(place, 6.0, color)
    canvas.disc(place, 4.0, WHITE)


def _arrow(canvas: Canvas, way: Sequence[XY], color: Color) -> None:
    """The head of an arrow in the middle of a straight way."""
    (ax, ay), (bx, by) = way
    length = hypot(bx - ax, by - ay)
    u, v = (bx - ax) / length, (by - ay) / length
    x, y = (ax + bx) / 2, (ay + by) / 2
    back = (x - 5 * u, y - 5 * v)
    sides = [(back[0] - 4 * v, back[1] + 4 * u), (back[0] + 4 * v, back[1] - 4 * u)]
    canvas.area([(x + 5 * u, y + 5 * v), *sides], color)


def _pale(color: Color, share: float = 0.85) -> Color:
    red, green, blue = (round(part + (255 - part) * share) for part in color)
    return red, green, blue


def _dark(color: Color) -> Color:
    red, green, blue = (part * 3 // 4 for part in color)
    return red, green, blue


def _overlap(a: Box, b: Box) -> bool:
    return a.left < b.right and b.left < a.right and a.top < b.bottom and b.top < a.bottom


def _size(corners: Sequence[XY]) -> float:
    """The area of a polygon."""
    following = [*corners[1:], corners[0]]
    return abs(sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(corners, following, strict=True))) / 2
