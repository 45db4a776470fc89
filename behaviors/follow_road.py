"""follow_road: fly along a road, by sight, to its end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, hypot, pi, sin
from typing import Any, ClassVar, Literal

from behaviors.behavior import Behavior
from behaviors.find_color import color_of
from behaviors.flight import Flight
from behaviors.guidance import Reference
from behaviors.line_reference import LineReference
from behaviors.manoeuvre import EPSILON
from behaviors.params import BehaviorParams, live, param, value
from behaviors.perception.annotations import GREEN, RED, circle, path
from behaviors.perception.centre_line import Node, Widths
from behaviors.perception.projection import pixels_of
from behaviors.perception.road_mask import shaded
from behaviors.plan import Legs, PlanStart, is_known, require_order
from behaviors.road_sight import Look, RoadSight
from fsm.host import Outcome
from hal.scene.arrays import Pixels
from hal.vehicle import Observation
from vencejo.geometry import Point, wrap

LOOKS = 4
"""Frames that are looked at before a road is looked for."""
ALIGNED = 0.15
"""Angle from the road at which it has turned along it, radians."""
STILL_SPEED = 0.05
"""Speed below which it has stopped, m/s."""
TURN_RATE = 1.5
"""With which the nose follows the road, rad/s."""
SCAN_RATE = 0.8
"""With which it looks round for a road, rad/s."""
ARRIVED = 0.2
"""Metres from the end of the road at which the vehicle is there."""
BARE = 3.0
"""Of the width: what goes on longer without an edge is no road."""
FURTHER = 1.0
"""Metres after which a new search has its time anew."""
PAUSE = 0.8
"""Seconds at the end of what is known before it flies into a gap that it cannot see over."""
UNSURE = 2.0
"""Seconds at the end of what is known after which it searches."""

Phase = Literal["look", "turn", "follow", "search"]


@dataclass(frozen=True, slots=True)
class Followed:
    """Where the road is, and how far it has come."""

    offset: float = value("m")
    """From the vehicle to the centre line; positive where the road lies left."""
    angle: float = value("rad")
    """From the nose to the road's direction; positive where that is left."""
    curvature: float = value()
    """1/m; positive where the road turns left."""
    width: float = value("m")
    progress: float = value("m")
    """Flown along the road."""
    ahead: float = value("m")
    """How much of the road is known ahead."""
    visible: bool = False
    """Whether the road is seen where it was expected."""


class FollowRoad(Behavior):
    """Find the road below, turn along it and follow it to its end, at one height.

    It keeps to the road on which it is where another leaves it, crosses gaps, and slows down before
    bends and where it does not see far. Ends in ``done`` where the road does; in ``lost`` when
    there is no road, or it is seen no more, also after ``patience`` spent looking round for it.
    """

    name = "follow_road"

    class Params(BehaviorParams):
        camera: str = param("ventral", help="that looks down", names="camera")
        color: Any = param("asphalt", help="of the road: a name, {hsv: [low, high]} or {rgb: …}")
        shade: float = param(50.0, unit="%", min=0, max=90, help="of the light shadows may take")
        speed: float = live(1.0, unit="m/s", min=0.05, max=10.0, help="where the road is straight")
        height: float | None = param(None, unit="m", help="above home; without it, as it is")
        ground: float = param(0.0, unit="m", help="height of the road above home")
        direction: float | None = param(
            None, unit="rad", help="the way to begin with is the nearest to it, or to the nose"
        )
        min_width: float = param(0.3, unit="m", min=0.05, max=50.0, help="of the road")
        max_width: float = param(6.0, unit="m", min=0.05, max=50.0, help="of the road")
        gap: float = param(1.5, unit="m", min=0.0, max=20.0, help="the longest that is crossed")
        patience: float = param(10.0, unit="s", min=0.0, help="to look for a lost road")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None, "lost": None}
    publishes = Followed
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if is_known(params.color):
            color_of(params.color)
        require_order(params, "min_width", "max_width")
        return None  # where the road leads is known in flight

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, seen, progress = self.params, flight.observation, progress or {}
        color = shaded(color_of(params.color), params.shade)
        require_order(params, "min_width", "max_width")
        widths = Widths(params.min_width, params.max_width)
        self.height = seen.position.z if params.height is None else params.height
        self.height = progress.get("height", self.height)
        look = Look(color, widths, params.gap)
        self.sight = RoadSight(flight.camera(params.camera), look, self.height, params.ground)
        self.phase: Phase = "look"
        self.reference = Reference(seen.position, seen.velocity)
        self.line: LineReference | None = None
        self.ending = "open"
        self.station = seen.position
        self.yaw = seen.yaw
        self.direction: float = seen.yaw if params.direction is None else params.direction
        self.turned = self.waited = self.since_end = self.searched_at = self.edged_at = 0.0
        self.flown: float = progress.get("flown", 0.0)
        self.road: Node | None = None
        """The last place of the road where it was."""
        if progress.get("road"):
            self.road = Node(*progress["road"])
            self.direction = self.road.heading
            self.sight.width = progress["width"]

    def step(self, flight: Flight) -> Outcome | str | None:
        seen = flight.observation
        is_new = self.sight.update()
        do = self._follow if self.phase == "follow" else self._hover
        outcome = do(flight, is_new)
        flight.publish(self._published(seen))
        if is_new:
            flight.picture("road", self._drawn)
        return outcome

    # Where it stands: it looks, turns, or searches.

    def _hover(self, flight: Flight, is_new: bool) -> str | None:
        seen, dt = flight.observation, flight.dt
        reference = self.reference
        reference.step(self._station(), min(1.0, self.params.speed), seen, dt)
        still = (
            reference.velocity.norm() < STILL_SPEED
            and abs(reference.position.z - self.height) < 0.05
        )
        if self.phase == "turn":
            self._turn_to(self.direction, TURN_RATE, dt)
            flight.command(reference.setpoint(self.yaw))
            if still and abs(wrap(self.direction - seen.yaw)) < ALIGNED:
                self._begin_line(reference.position)
            return None
        self.waited += dt
        found = False
        if is_new and self.sight.looks >= LOOKS and still:
            found = self._find_road(reference.position)
        if still and not found and self.waited > 0.5:
            self._scan(dt)
        flight.command(reference.setpoint(self.yaw))
        is_over = self.turned >= 2 * pi and self.waited >= self.params.patience - EPSILON
        return "lost" if is_over else None

    def _station(self) -> Point:
        """Where it stands to look."""
        if self.phase == "search" and self.road is not None:
            return Point(self.road.x, self.road.y, self.height)
        x, y, _ = self.station
        return Point(x, y, self.height)

    def _scan(self, dt: float) -> None:
        """Look round."""
        turn = SCAN_RATE * dt
        self.turned += turn
        self.yaw = wrap(self.yaw + turn)

    def _turn_to(self, heading: float, rate: float, dt: float) -> None:
        error, most = wrap(heading - self.yaw), rate * dt
        self.yaw = wrap(self.yaw + max(-most, min(most, error)))

    def _find_road(self, place: Point) -> bool:
        """Look for a road about a place, to turn along it; False when there is none."""
        begin = self.sight.find((place.x, place.y))
        if begin is None:
            return False
        way = min(begin.ways, key=lambda node: abs(wrap(node.heading - self.direction)))
        if self.phase == "search" and abs(wrap(way.heading - self.direction)) > 2.0:
            return False  # that leads back
        self.begin, self.direction = way, way.heading
        self.phase = "turn"
        return True

    # Where it follows the line.

    def _begin_line(self, place: Point) -> None:
        """Follow the road that was found, from a place beside it."""
        line = self.sight.trace([self.begin])
        nearest = min(line.nodes, key=lambda node: hypot(node.x - place.x, node.y - place.y))
        joined = line.nodes[line.nodes.index(nearest) + 1 :] or line.nodes[-1:]
        reference = LineReference(place)
        heading = joined[0].heading
        is_end = line.ending == "end"
        reference.go_on([Node(place.x, place.y, heading, 0.0, False), *joined], is_end)
        self.line, self.ending, self.phase = reference, line.ending, "follow"
        self.since_end = self.edged_at = 0.0

    def _follow(self, flight: Flight, is_new: bool) -> str | None:
        seen, dt = flight.observation, flight.dt
        line = self.line
        assert line is not None
        if is_new:
            self._trace_on(line, seen)
        way = line.way
        line.step(seen, self.params.speed, dt)
        self.flown += line.way - way
        self._turn_to(line.heading(), TURN_RATE, dt)
        flight.command(line.setpoint(self.yaw))
        if not line.has_ended:
            self.since_end = 0.0
            return None
        self.since_end += dt
        x, y, _ = line.position
        near = hypot(x - seen.position.x, y - seen.position.y) < ARRIVED
        if self.ending == "end" and near and self.sight.sees_before(line.nodes[-1]):
            return "done"
        if self.since_end > UNSURE:
            self._search(line)
        return None

    def _trace_on(self, line: LineReference, seen: Observation) -> None:
        traced = self.sight.trace(line.settled, into_gap=self.since_end > PAUSE)
        if traced.has_edges or traced.ending == "end" or not traced.nodes[0].is_road:
            self.edged_at = line.way
        is_bare = line.way > self.edged_at + BARE * self.sight.width
        self.ending = "none" if is_bare else traced.ending
        if self.ending != "none":
            line.go_on(traced.nodes, traced.ending == "end")
            self.road = line.nearest(seen.position.x, seen.position.y)

    def _search(self, line: LineReference) -> None:
        """Stop following, and look round from where the road was last seen."""
        self.reference = Reference(line.position, line.velocity)
        self.phase, self.line = "search", None
        if self.flown > self.searched_at + FURTHER:
            self.waited = self.turned = 0.0
        self.searched_at = self.flown
        if self.road is not None:
            self.direction = self.road.heading

    def _published(self, seen: Observation) -> Followed:
        line = self.line
        if line is None:
            return Followed(width=self.sight.width, progress=self.flown)
        node = line.nearest(seen.position.x, seen.position.y)
        dx, dy = node.x - seen.position.x, node.y - seen.position.y
        return Followed(
            offset=dy * cos(node.heading) - dx * sin(node.heading),
            angle=wrap(node.heading - seen.yaw),
            curvature=node.curvature,
            width=self.sight.width,
            progress=self.flown,
            ahead=max(0.0, line.left),
            visible=self.ending != "none",
        )

    def _drawn(self) -> Pixels:
        """The picture with the centre line as it is known, and the place that is flown at."""
        frame = self.sight.frame
        assert frame is not None
        line, ground = self.line, self.params.ground
        if line is None:
            return frame.image
        drawn = path(frame.image, frame, [(node.x, node.y, ground) for node in line.nodes], GREEN)
        target = pixels_of(frame, [(*line.place(line.way), ground)])[0]
        return circle(drawn, target, 4, RED)

    def progress(self) -> dict[str, Any]:
        return {
            "height": self.height,
            "flown": self.flown,
            "road": list(self.road) if self.road else None,
            "width": self.sight.width,
        }
