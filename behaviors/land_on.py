"""land_on: land on a marked pad, still or moving."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, hypot, pi, sin
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.chase import Chase, turned_towards
from behaviors.flight import Flight
from behaviors.guidance import STILL
from behaviors.params import BehaviorParams, param, value
from behaviors.perception.targets import MarkerTarget, read_marker
from behaviors.plan import Legs, PlanStart, Unflyable, is_known
from behaviors.target_watch import TargetWatch
from fsm.host import Outcome
from hal.orders import Order
from vencejo.geometry import Point, horizontal_distance

COMMIT = 0.3
"""Height above the pad from which it comes down whatever it sees, metres."""
IN_VIEW = 1.6
"""Part of the picture, over the size of the smallest marker, below which that is lost from view."""
CENTRED, CALM = 0.05, 0.15
"""Distance from over the middle, metres, and speed over the pad, m/s, at which it comes down."""
FUNNEL, SLOPE = 0.06, 0.15
"""Distance from over the middle inside which it descends: at the pad, metres, and what is added for
each metre of height."""
FRESH, BLIND = 0.3, 2.2
"""Seconds without a sight after which it does not descend, and after which it climbs to look."""
PAD_ACCELERATION = 2.0
"""Standard deviation of a pad's acceleration, m/s²: enough for one that goes round a bend."""
UNSURE = 0.5
"""Standard deviation of a pad's speed above which it is not waited for but looked for, m/s."""
FOLLOWED = 4.0
"""Seconds for which it goes on with a pad that it does not see."""
CLIMB = 2.0
"""Speed at which it climbs while it looks, for a wider view, m/s."""
LEAST_SEEN = 14.0
"""Side of the marker in the picture up to which it climbs, pixels."""
ROUND = 0.6
"""Radius by which it goes round the place in a wider circle each time, metres."""
CLOSING = 2.0
"""Gain from distance to speed over the pad when it comes down, 1/s."""
MOST_CLOSING = 0.5
"""Largest such speed, m/s."""
TURNING = 1.0
"""Seconds for which a pad is expected to go on to turn, or to slow down, as it did."""
TURN_RATE = 1.0
"""Turn rate when it is aligned with the pad, rad/s."""
NEARLY = 0.3
"""Height below that of the beginning at which it has come back up, and least way down, metres."""
ON_PAD = 0.2
"""Largest difference in height to the pad of a vehicle that stands on it, metres."""


@dataclass(frozen=True, slots=True)
class Approaching:
    """How far it is; nothing is known of a pad that was not seen yet."""

    phase: str = "looking"
    """``looking``, ``approaching``, ``descending`` or ``landing``."""
    visible: bool = False
    distance: float = value("m")
    """Over the ground, from over the middle of the pad."""
    height: float = value("m")
    """Above the pad."""
    position: Point | None = None
    """Of the pad's middle."""
    velocity: Point = STILL
    """Of the pad, m/s."""
    tries: int = 0
    """How often it has lost the pad."""


@dataclass(frozen=True, slots=True)
class Landed:
    """How well it stands."""

    distance: float = value("m")
    """From the middle of the pad, as it was seen last."""
    tries: int = 0


class LandOn(Behavior):
    """Land in the middle of a pad that has a marker on it, still or moving.

    It flies over the pad, moves with it, and descends while it is over the middle; the last 30 cm
    it comes down whatever it sees, with the pad's velocity. When it loses the pad it follows for a
    moment, then climbs and looks round where the pad should be, and ends in ``lost`` after the
    tries: in the air, for it never lands anywhere else.
    """

    class Params(BehaviorParams):
        marker: Any = param(
            help="on the pad: {id, size, dictionary, inside: {id, size, dictionary}}"
        )
        camera: str = param("ventral", names="camera", help="a camera that looks down")
        height: float = param(2.5, unit="m", min=0.5, max=20.0, help="to begin from, above the pad")
        highest: float = param(8.0, unit="m", min=0.5, max=50.0, help="to look from, above the pad")
        speed: float = param(2.0, unit="m/s", min=0.1, max=10.0, help="with which it nears the pad")
        descent: float = param(0.5, unit="m/s", min=0.1, max=2.0, help="speed down")
        align: float | None = param(None, unit="rad", help="nose, from where its top points")
        patience: float = param(4.0, unit="s", min=0.5, help="for which it looks each time")
        tries: int = param(3, min=0, help="how often it looks again")
        roll_pitch_thr: float | None = param(
            None, unit="rad", min=0.0, help="pictures taken at more tilt are ignored"
        )

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": Landed, "lost": None}
    publishes = Approaching
    requires = ("position", "velocity", "land", "land.moving")
    ends_landed = True
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if is_known(params.marker):
            _marker(params)
        return None

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, seen = self.params, flight.observation
        marker = _marker(params)
        self.largest, self.smallest = marker.largest, marker.smallest
        self.watch = TargetWatch(
            flight,
            params.camera,
            marker,
            acceleration=PAD_ACCELERATION,
            most_tilt=params.roll_pitch_thr,
        )
        self.chase = Chase(seen)
        self.begin, self.yaw = seen.position, seen.yaw
        self.since = seen.time
        self.tries = 0
        self.phase = "looking"
        self.climbed = 0.0
        """Height gained while it looks, metres."""
        self.above = params.height
        """Height above the pad that is flown now, metres."""
        self.order: Order | None = None
        if progress:
            self.watch.go_on(progress["watch"])
            self.begin, self.tries = Point(*progress["begin"]), progress["tries"]

    def step(self, flight: Flight) -> Outcome | str | None:
        if self.watch.look(flight):
            self.watch.show(flight, "land_on", f"{self.phase} {self._height(flight):.2f} m")
        if self.phase == "landing":
            ended = self._come_down(flight)
        elif self.phase == "looking":
            ended = self._look(flight)
        else:
            ended = self._descend(flight)
        flight.publish(self._approach(flight))
        return ended

    def progress(self) -> dict[str, Any]:
        return {
            "watch": self.watch.progress(),
            "begin": list(self.begin),
            "tries": self.tries,
        }

    # Looking for the pad.

    def _look(self, flight: Flight) -> Outcome | str | None:
        """Wait over where the pad should be until it is seen."""
        params, now = self.params, flight.now
        given_up = self.tries > params.tries
        if self.watch.is_visible(now) and not given_up:
            self.phase = "approaching"
            self.above = min(self._most(), max(self._height(flight), self._least()))
            return self._descend(flight)
        safe = given_up and self._height(flight) > self._most() - NEARLY
        if safe or now - self.since >= params.patience:
            if self.tries >= params.tries:
                return "lost"
            self.tries, self.since = self.tries + 1, now
        place = self._pad(now)
        turn, radius = 2 * pi * (now - self.since) / params.patience, ROUND * self.tries
        self.climbed += CLIMB * flight.dt
        place = self.begin if place is None else place._replace(z=place.z + self._most())
        aside = radius * cos(turn), radius * sin(turn), self.climbed
        self._follow(flight, self._below_top(place.plus(aside)), self._velocity(now))
        return None

    def _below_top(self, place: Point) -> Point:
        """The place, no higher than it may look from, or than it can see the pad from."""
        frame, top = self.watch.frame, self.params.highest
        if frame is not None:
            top = min(top, self.largest * frame.intrinsics.fx / LEAST_SEEN)
        pad = self._pad(self._seen_at())
        highest = max(top, self.begin.z) if pad is None else pad.z + max(top, self._most())
        return place._replace(z=min(place.z, highest))

    def _lose(self, flight: Flight) -> Outcome | str | None:
        """Climb, and look again; or only climb, when that has been often enough."""
        self.tries, self.since = self.tries + 1, flight.now
        self.phase, self.climbed = "looking", 0.0
        return self._look(flight)

    # Over the pad.

    def _descend(self, flight: Flight) -> Outcome | str | None:
        """Fly over the middle, and lower while it is there."""
        watch, now, dt = self.watch, flight.now, flight.dt
        if watch.age(now) > (FRESH if self._is_unsure() else BLIND):
            return self._lose(flight)
        pad, moves = self._pad(now), self._velocity(now)
        assert pad is not None
        least, off = self._least(), self._off(flight)
        funnel = FUNNEL + SLOPE * self.above
        sinks = off < funnel and watch.age(now) < FRESH and self.above > least
        if sinks:
            self.above = max(least, self.above - self.params.descent * dt)
        elif off > 2 * funnel:
            self.above = min(self._most(), self.above + self.params.descent * dt)
        self.phase = "descending" if off < funnel else "approaching"
        down = -self.params.descent if sinks else 0.0
        self._follow(flight, pad._replace(z=pad.z + self.above), moves._replace(z=down))
        if self.above > least or self._height(flight) > least + CENTRED:
            self.since = now
        elif off < CENTRED and self._drift(flight) < CALM and watch.age(now) < FRESH:
            self.phase = "landing"
            self.order = None
        elif now - self.since >= self.params.patience:
            return self._lose(flight)
        return None

    def _follow(self, flight: Flight, target: Point, moves: Point) -> None:
        seen, heading, align = flight.observation, self.watch.heading, self.params.align
        speed = self.params.speed + hypot(moves.x, moves.y)
        self.chase.step(target, moves, speed, seen, flight.dt)
        if align is not None and heading is not None:
            self.yaw = turned_towards(self.yaw, heading + align, TURN_RATE, flight.dt)
        flight.command(self.chase.setpoint(self.yaw))

    # The last of the way.

    def _come_down(self, flight: Flight) -> Outcome | str | None:
        """Land with the velocity of the pad, until it stands."""
        seen, order = flight.observation, self.order
        if order is not None and order.state == "done":
            return self._landed(flight)
        if order is not None and order.ended:
            self.chase = Chase(seen)
            return self._lose(flight)
        pad, moves = self._pad(flight.now), self._velocity(flight.now)
        assert pad is not None
        # Near the pad it is seen so well that it can be told how it turns, for the moment in which
        # it is not seen any more.
        unseen = min(TURNING, self.watch.age(flight.now))
        east, north, _ = self.watch.acceleration
        x = CLOSING * (pad.x + east * unseen**2 / 2 - seen.position.x)
        y = CLOSING * (pad.y + north * unseen**2 / 2 - seen.position.y)
        share = min(1.0, MOST_CLOSING / hypot(x, y)) if x or y else 0.0
        x, y = moves.x + east * unseen + x * share, moves.y + north * unseen + y * share
        self.order = flight.land(Point(x, y, 0.0))
        return None

    def _landed(self, flight: Flight) -> Outcome:
        off, height = self._off(flight), self._height(flight)
        if abs(height) > ON_PAD:
            return Outcome("failed", {"reason": f"it stands {height:+.2f} m beside the pad"})
        return Outcome("done", {"distance": off, "tries": self.tries})

    # What it knows of the pad.

    def _least(self) -> float:
        """The height down to which the smallest marker is in view, at least COMMIT, metres."""
        frame = self.watch.frame
        if frame is None:
            return COMMIT
        lens = frame.intrinsics
        view = min(lens.width / lens.fx, lens.height / lens.fy)
        return max(COMMIT, IN_VIEW * self.smallest / view)

    def _most(self) -> float:
        """The height from which it comes down, metres."""
        height: float = self.params.height
        return max(height, self._least() + NEARLY)

    def _pad(self, now: float) -> Point | None:
        """The place of its middle, as far as it is followed; its height is that seen last."""
        track, seen = self.watch.track, self._seen_at()
        if not track.is_known:
            return None
        ahead = track.position_at(min(now, seen + FOLLOWED))
        return ahead._replace(z=track.position_at(seen).z)

    def _seen_at(self) -> float:
        return self.watch.track.time or 0.0

    def _velocity(self, now: float) -> Point:
        """That of the pad over the ground; none once it is not followed any more."""
        follows = self.watch.age(now) < FOLLOWED
        return self.watch.track.velocity._replace(z=0.0) if follows else STILL

    def _is_unsure(self) -> bool:
        """Whether it has been seen for too short a time to tell how fast it is."""
        return self.watch.track.speed_deviation > UNSURE

    def _off(self, flight: Flight) -> float:
        """The distance from over its middle."""
        pad = self._pad(flight.now)
        return horizontal_distance(flight.observation.position, pad) if pad else 0.0

    def _height(self, flight: Flight) -> float:
        """The height above it."""
        pad = self._pad(flight.now)
        return flight.observation.position.z - pad.z if pad else 0.0

    def _drift(self, flight: Flight) -> float:
        """The speed over the ground relative to it."""
        return horizontal_distance(flight.observation.velocity, self._velocity(flight.now))

    def _approach(self, flight: Flight) -> Approaching:
        now = flight.now
        pad = self._pad(now)
        if pad is None:
            return Approaching(tries=self.tries)
        return Approaching(
            self.phase,
            self.watch.is_visible(now),
            self._off(flight),
            self._height(flight),
            pad,
            self._velocity(now),
            self.tries,
        )


def _marker(params: Any) -> MarkerTarget:
    """The marker of the parameters. Raises Unflyable."""
    try:
        return read_marker(params.marker, "level")
    except ValueError as error:
        raise Unflyable(str(error), "marker") from None
