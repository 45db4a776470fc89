"""The mission frame, and how the points and places of a mission are resolved in it.

Its origin is home, where the vehicle was when the mission began; its axes are the world's (east,
north, up). When the origin of the world frame jumps, the mission frame stays where it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from behaviors.params import Face, Heading, Waypoint
from fsm.values.conversion import ABOVE_GROUND
from fsm.values.functions import EvaluationError, shown
from fsm.values.types import AREA, AREAS, HEADING, POINT, ROUTE, Text, Type
from hal.vehicle import Observation
from vencejo.geometry import Point, distance, enu_of, rotate_xy

STANDS_ON_HOME = 0.05
"""A vehicle on the ground that is nearer to home than this stands on it, metres."""
_ZERO = Point(0.0, 0.0, 0.0)
GroundHeight = Callable[[float, float], float]
"""The height of the ground at a place (x, y): metres."""


class Pose(Protocol):
    """What relative points count from, mission frame: an observation has it."""

    @property
    def position(self) -> Point: ...

    @property
    def yaw(self) -> float: ...


class MissionFrame:
    """The frame of one mission, with the places it can name."""

    def __init__(
        self,
        origin: Point,
        places: Mapping[str, Point] | None = None,
        geographic: tuple[float, float, float] | None = None,
        origin_shift: Point = _ZERO,
        ground_height: GroundHeight | None = None,
        files: Mapping[str, Any] | None = None,
    ) -> None:
        """``origin`` is in the present world frame, where what stood at the zero of the first one
        is at ``origin_shift`` now; ``places`` and ``geographic`` are those of the first one;
        ``files`` are those of the graph (see :attr:`fsm.Graph.files`).
        """
        self.origin = origin
        """The mission frame's origin, world frame, metres."""
        self.is_world = origin == _ZERO
        """Whether the two frames are one, and nothing needs to be moved."""
        self.origin_shift = origin_shift
        """Where what stood at the first zero of the world frame is now, world frame."""
        self.places = {name: place.plus(origin_shift) for name, place in (places or {}).items()}
        """Places of the world, world frame."""
        self.geographic = geographic
        """Latitude and longitude (degrees) and altitude of the world frame's first zero."""
        self.ground_height = ground_height
        """The height of the ground at a place of the world frame before any jump; None where it
        is not known."""
        self.files = files or {}
        """What the files hold that the mission names."""

    @classmethod
    def at_start(
        cls,
        seen: Observation,
        places: Mapping[str, Point] | None = None,
        geographic: tuple[float, float, float] | None = None,
        ground_height: GroundHeight | None = None,
        files: Mapping[str, Any] | None = None,
    ) -> MissionFrame:
        """The frame of a mission that begins with this observation (world frame).

        Its origin is home while the vehicle stands there, since an autopilot measures home and
        position with different errors; otherwise it is the vehicle's position.
        """
        at_home = not seen.flying and distance(seen.position, seen.home) < STANDS_ON_HOME
        origin = seen.home if at_home else seen.position
        return cls(origin, places, geographic, seen.origin_shift, ground_height, files)

    def follow(self, origin_shift: Point) -> Point:
        """Follow a jump of the world frame, to where its first zero is now; by how much all that
        stands still is further there.
        """
        offset = origin_shift.minus(self.origin_shift)
        self.origin_shift = origin_shift
        self.origin = self.origin.plus(offset)
        self.is_world = self.origin == _ZERO
        self.places = {name: place.plus(offset) for name, place in self.places.items()}
        return offset

    def from_world(self, point: Point) -> Point:
        return point.minus(self.origin)

    def to_world(self, point: Point) -> Point:
        return point.plus(self.origin)

    def point(self, given: Any, start: Pose) -> Point:
        """The mission-frame point of a value as missions write it.

        ``start`` is the pose when the behaviour began: a coordinate that is not given stays as it
        was then. Raises EvaluationError for an unknown place, a value that is no point, a
        geographic point where the vehicle has no geographic position, or a height above ground
        where that is not known.
        """
        here = start.position
        if isinstance(given, Point):
            return given
        if isinstance(given, str):
            return self._place(given, here)
        if not isinstance(given, Mapping):
            raise EvaluationError(f"{shown(given)} is not a point")
        if ABOVE_GROUND in given:
            level = {key: value for key, value in given.items() if key != ABOVE_GROUND}
            return self._above_ground(self._of_form(level, start), given[ABOVE_GROUND])
        return self._of_form(given, start)

    def _of_form(self, given: Mapping[str, Any], start: Pose) -> Point:
        """The point of a map, by its keys."""
        here = start.position
        if given.keys() & {"forward", "left", "up"}:
            east, north = rotate_xy(given.get("forward", 0.0), given.get("left", 0.0), start.yaw)
            return here.plus((east, north, given.get("up", 0.0)))
        if "lat" in given:
            return self._geographic_place(given, here)
        if given.get("frame") == "world":
            there = self.to_world(here).minus(self.origin_shift)
            return self._from_first_world(_completed(given, there))
        return _completed(given, here)

    def _above_ground(self, place: Point, height: float) -> Point:
        """The point straight above or below a place, at a height above the ground there."""
        if self.ground_height is None:
            raise EvaluationError("the height of the ground is not known here")
        x, y, _ = self.to_world(place).minus(self.origin_shift)
        ground = self._from_first_world(Point(x, y, self.ground_height(x, y)))
        return place._replace(z=ground.z + height)

    def _place(self, name: str, here: Point) -> Point:
        """The point of a place, in the mission frame; home is meant at the present height."""
        if name == "home":
            return Point(0.0, 0.0, here.z)
        if name in self.places:
            return self.from_world(self.places[name])
        known = ", ".join(["home", *sorted(self.places)])
        raise EvaluationError(f"there is no place '{name}' here (known: {known})")

    def _geographic_place(self, given: Mapping[str, Any], here: Point) -> Point:
        """The mission-frame point of ``{lat, lon, above_home}``; without a height, at this one."""
        if self.geographic is None:
            raise EvaluationError("the vehicle has no geographic position here")
        east, north = enu_of(given["lat"], given["lon"], *self.geographic[:2])
        world = self._from_first_world(Point(east, north, 0.0))
        return world._replace(z=given.get("above_home", here.z))

    def _from_first_world(self, point: Point) -> Point:
        """A point of the world frame before any jump, which is what people write down."""
        return self.from_world(point.plus(self.origin_shift))

    def located(self, type_: Type, given: Any) -> Any:
        """The value of a parameter; the point of a place of the world if it names one."""
        named = type_ == POINT and isinstance(given, str) and given in self.places
        return self.from_world(self.places[given]) if named else given

    def heading(self, given: Any, start: Pose) -> Heading:
        """The heading of a value as missions write it. Raises as :meth:`point` does."""
        if isinstance(given, Mapping):
            return Face(self.point(given["face"], start))
        return given if isinstance(given, str) else float(given)

    def resolve(self, type_: Type, given: Any, start: Pose) -> Any:
        """A checked value in the form that behaviours use: Point, Heading, Route, Area, Areas,
        and what a file holds for its name.

        Values of other types are returned as they are. Raises as :meth:`point` does.
        """
        if given is None:
            return None
        if type_ == POINT:
            return self.point(given, start)
        if type_ == HEADING:
            return self.heading(given, start)
        if type_ in (ROUTE, AREA, AREAS):
            element = {ROUTE: self._waypoint, AREA: self.point, AREAS: self._area}[type_]
            return [element(each, start) for each in given]
        if isinstance(type_, Text) and type_.file:
            return self._content(given)
        return given

    def _content(self, file: str) -> Any:
        if file not in self.files:
            raise EvaluationError(f"the file '{file}' has not been read")
        return self.files[file]

    def _area(self, given: Any, start: Pose) -> list[Point]:
        return [self.point(corner, start) for corner in given]

    def _waypoint(self, given: Any, start: Pose) -> Waypoint:
        if isinstance(given, Mapping) and "at" in given:
            heading = given.get("heading")
            return Waypoint(
                self.point(given["at"], start),
                None if heading is None else self.heading(heading, start),
                given.get("speed"),
                given.get("dwell"),
            )
        return Waypoint(self.point(given, start))


def _completed(given: Mapping[str, Any], here: Point) -> Point:
    """The point of ``{x, y, z}``; a coordinate that is not given stays as it is ``here``."""
    return Point(*(given.get(axis, here[i]) for i, axis in enumerate("xyz")))
