"""track_object: stay before a thing or above it, wherever it goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, pi, sin
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.chase import Chase, turned_towards
from behaviors.flight import Flight
from behaviors.guidance import MIN_TRAVEL, STILL
from behaviors.params import BehaviorParams, live, param, value
from behaviors.perception.marker_pose import Posture
from behaviors.perception.targets import Target, read_target
from behaviors.plan import Legs, PlanStart, Unflyable, is_known
from behaviors.target_watch import TargetWatch
from fsm.host import Outcome
from vencejo.geometry import Point, bearing, distance, horizontal_distance, rotate_xy, wrap

FOLLOWED = 1.5
"""Seconds for which it goes on after a thing that it does not see; then it waits."""
TURN_RATE = 1.5
"""Largest turn rate, rad/s."""
LOOK_RATE = 0.6
"""Rate of the turn to the side on which a thing has vanished, rad/s."""


@dataclass(frozen=True, slots=True)
class Tracked:
    """The thing, as it is expected to be now; nothing is known of one that was not seen yet."""

    visible: bool = False
    age: float = value("s")
    """Since it was seen."""
    distance: float = value("m")
    """Before it: to it. Above it: over the ground."""
    offset: float = value("m")
    """How far it is to the left of where the nose points."""
    height: float = value("m")
    """Of the vehicle above it."""
    position: Point | None = None
    velocity: Point = STILL
    """m/s."""
    heading: float | None = value("rad", None)
    """The direction in which the top of a marker points if it lies, or in which it faces."""


class TrackObject(Behavior):
    """Stay before a thing at a distance, or above it at a height, wherever it goes.

    With a camera that looks ahead it turns its nose to the thing and keeps the distance on the side
    on which it is, or before the face of a marker (``align``). With one that looks down it stays
    above, and can turn its nose along a marker, or from it to a ``second`` one. A thing that is not
    seen any more is followed for 1.5 s as it moved last; then, and before it is seen at all, the
    vehicle waits and, with a camera that looks ahead, turns round, to the side on which it
    vanished. Ends in ``lost`` after ``patience`` without a sight of it.
    """

    class Params(BehaviorParams):
        target: Any = param(help="{color, size}, or a marker: {id, size, dictionary, inside}")
        camera: str = param(
            "front", choices=("front", "ventral"), names="camera", help="before it, or above it"
        )
        distance: float = live(3.0, unit="m", min=0.3, max=50.0, help="to keep before it")
        height: float | None = live(
            None, unit="m", help="above it; without it, 3 m above, or before it the present height"
        )
        align: float | None = live(
            None,
            unit="rad",
            help="side of a marker to stay on, from its face; above: nose from its top",
        )
        second: Any = param(
            None, help="a second marker, to which the nose is turned above the first"
        )
        speed: float = live(3.0, unit="m/s", min=0.1, max=20.0, help="at the most")
        patience: float = param(5.0, unit="s", min=0.1, help="without a sight, then it is lost")
        roll_pitch_thr: float | None = param(
            None, unit="rad", min=0.0, help="pictures taken at more tilt are ignored"
        )

    outcomes: ClassVar[Mapping[str, type | None]] = {"lost": None}
    publishes = Tracked
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if is_known(params.target) and is_known(params.second):
            _targets(params)
        return None

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, seen = self.params, flight.observation
        target, second = _targets(params)
        tilt = params.roll_pitch_thr
        self.watch = TargetWatch(flight, params.camera, target, most_tilt=tilt)
        self.second = None
        if second is not None:
            self.second = TargetWatch(flight, params.camera, second, most_tilt=tilt)
        self.chase = Chase(seen)
        self.yaw, self.level = seen.yaw, seen.position.z
        self.waited = 0.0
        """Seconds without a sight."""
        self.side = 1.0
        """1 where it vanished to the left of the nose, −1 to the right."""
        if progress:
            self.watch.go_on(progress["watch"])
            self.level, self.waited = progress["level"], progress["waited"]

    def step(self, flight: Flight) -> Outcome | str | None:
        watch, now = self.watch, flight.now
        if watch.look(flight):
            far = distance(flight.observation.position, watch.track.position_at(now))
            watch.show(flight, "track_object", f"{far:.2f} m" if watch.track.is_known else "")
        if self.second is not None:
            self.second.look(flight)
        self.waited = 0.0 if watch.is_visible(now) else self.waited + flight.dt
        if watch.age(now) <= FOLLOWED:
            self._follow(flight)
        else:
            self._wait(flight)
        flight.command(self.chase.setpoint(self.yaw))
        flight.publish(self._tracked(flight))
        return "lost" if self.waited >= self.params.patience else None

    def progress(self) -> dict[str, Any]:
        return {"watch": self.watch.progress(), "level": self.level, "waited": self.waited}

    # Flying.

    def _follow(self, flight: Flight) -> None:
        """Move the reference to its place beside the thing, as fast as that moves."""
        seen, dt, watch = flight.observation, flight.dt, self.watch
        thing = watch.track.position_at(flight.now)
        before = self.params.camera == "front"
        place, yaw = self._before(flight, thing) if before else self._above(flight, thing)
        moves = watch.track.velocity
        if before and self.params.height is None:
            moves = moves._replace(z=0.0)
        self.chase.step(place, moves, self.params.speed, seen, dt)
        left = wrap(yaw - self.yaw)
        if before and left:
            self.side = 1.0 if left > 0 else -1.0
        self.yaw = turned_towards(self.yaw, yaw, TURN_RATE, dt)

    def _wait(self, flight: Flight) -> None:
        """Stop; before a thing, look to the side on which it has vanished."""
        self.chase.stop(flight.observation, flight.dt)
        if self.params.camera == "front":
            self.yaw = wrap(self.yaw + self.side * LOOK_RATE * flight.dt)

    def _before(self, flight: Flight, thing: Point) -> tuple[Point, float]:
        """The place before a thing, and the yaw towards it."""
        params, here, heading = self.params, flight.observation.position, self.watch.heading
        near = horizontal_distance(here, thing) < MIN_TRAVEL
        side = self.yaw + pi if near else bearing(thing, here)
        if params.align is not None and heading is not None:
            side = heading + params.align
        away = params.distance
        height = self.level if params.height is None else thing.z + params.height
        place = Point(thing.x + away * cos(side), thing.y + away * sin(side), height)
        return place, self.yaw if near else bearing(here, thing)

    def _above(self, flight: Flight, thing: Point) -> tuple[Point, float]:
        """The place above a thing, and the yaw that it asks for."""
        params = self.params
        height = 3.0 if params.height is None else params.height
        place = thing._replace(z=thing.z + height)
        other = self.second.position_at(flight.now) if self.second else None
        if other is not None:
            return place, bearing(thing, other) + (params.align or 0.0)
        if params.align is not None and self.watch.heading is not None:
            return place, self.watch.heading + params.align
        return place, self.yaw

    def _tracked(self, flight: Flight) -> Tracked:
        watch, seen = self.watch, flight.observation
        thing = watch.position_at(flight.now)
        if thing is None:
            return Tracked()
        east, north, up = thing.minus(seen.position)
        _, left = rotate_xy(east, north, -seen.yaw)
        before = self.params.camera == "front"
        far = (
            distance(thing, seen.position) if before else horizontal_distance(thing, seen.position)
        )
        return Tracked(
            watch.is_visible(flight.now),
            watch.age(flight.now),
            far,
            left,
            -up,
            thing,
            watch.track.velocity,
            watch.heading,
        )


def _targets(params: Any) -> tuple[Target, Target | None]:
    """The target of the parameters, and the second marker. Raises Unflyable."""
    posture: Posture = "any" if params.camera == "front" else "level"
    name = "target"
    try:
        target = read_target(params.target, posture)
        name = "second"
        second = None if params.second is None else read_target(params.second, posture)
    except ValueError as error:
        raise Unflyable(str(error), name) from None
    return target, second
