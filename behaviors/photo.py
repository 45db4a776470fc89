"""photo: stop, and take a picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.channel import PICTURE_NAME
from behaviors.flight import Flight
from behaviors.guidance import STILL, Reference, yaw_towards
from behaviors.manoeuvre import EPSILON
from behaviors.params import BehaviorParams, Heading, param
from behaviors.plan import Legs, PlanStart, Unflyable
from fsm.host import Outcome
from hal.vehicle import Observation
from vencejo.geometry import Point, wrap

STEADY_SPEED, STEADY_RATE = 0.05, 0.05
"""Speed, m/s, and turn rate, rad/s, below which the vehicle is steady."""
YAW_TOLERANCE = 0.05
"""Error of the heading, radians."""


@dataclass(frozen=True, slots=True)
class Taken:
    """A picture that was taken."""

    name: str = ""
    camera: str = ""
    sequence: int = 0
    """Number of the camera's frame."""
    position: Point = STILL
    """Where the camera was, mission frame."""


class Photo(Behavior):
    """Stop, wait until the vehicle is steady, take a picture, and keep it under a name.

    It is kept in the folder ``photos`` of the run folder, whether other frames are or not. Ends in
    ``failed`` when there is no such camera, or no steady picture within ``timeout``.
    """

    name = "photo"

    class Params(BehaviorParams):
        camera: str = param(help="the name of a camera of the vehicle", names="camera")
        name: str = param("photo", help="of the picture: letters, digits, _ and -")
        heading: Heading = param("keep", help="an angle, keep or {face: point}")
        steady: float = param(0.5, unit="s", min=0.0, help="time without motion before it")
        timeout: float = param(20.0, unit="s", min=0.1, help="then it has failed")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": Taken}
    requires = ("position",)
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        _check(params)
        return []

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, seen = self.params, flight.observation
        _check(params)
        self.camera = flight.camera(params.camera)
        self.reference = Reference(seen.position, seen.velocity)
        self.start_yaw = self.yaw = seen.yaw
        self.elapsed = 0.0
        self.steady_since: float | None = None
        if progress:
            self.start_yaw, self.elapsed = progress["start_yaw"], progress["elapsed"]

    def step(self, flight: Flight) -> Outcome | str | None:
        params, seen = self.params, flight.observation
        self.elapsed += flight.dt
        reference = self.reference
        reference.stop(seen, flight.dt)
        here = seen.position
        self.yaw = yaw_towards(params.heading, here, here, self.start_yaw, self.yaw)
        flight.command(reference.setpoint(self.yaw))
        if not self._is_steady(seen):
            self.steady_since = None
        elif self.steady_since is None:
            self.steady_since = seen.time
        since = self.steady_since
        if since is not None and seen.time - since >= params.steady - EPSILON:
            frame = self.camera.latest()
            # One that was exposed before may be blurred.
            if frame is not None and frame.time >= since - EPSILON:
                flight.keep_photo(params.name, params.camera, frame)
                taken = (params.name, params.camera, frame.sequence, frame.position)
                names = ("name", "camera", "sequence", "position")
                return Outcome("done", dict(zip(names, taken, strict=True)))
        if self.elapsed >= params.timeout:
            reason = "no picture came" if since is not None else "the vehicle is not steady"
            return Outcome("failed", {"reason": f"{reason} within {params.timeout:g} s"})
        return None

    def _is_steady(self, seen: Observation) -> bool:
        return (
            seen.velocity.norm() <= STEADY_SPEED
            and seen.rates.norm() <= STEADY_RATE
            and abs(wrap(self.yaw - seen.yaw)) <= YAW_TOLERANCE
        )

    def progress(self) -> dict[str, Any]:
        return {"start_yaw": self.start_yaw, "elapsed": self.elapsed}


def _check(params: Any) -> None:
    """Raises Unflyable for a name that no file gets, and a heading that means nothing here."""
    if isinstance(params.name, str) and not PICTURE_NAME.fullmatch(params.name):
        message = f"'{params.name:.70}' is no name of a picture"
        raise Unflyable(message, "name", "up to 64 letters, digits, _ and -")
    if isinstance(params.heading, str) and params.heading == "travel":
        hint = "write an angle, keep or {face: point}"
        raise Unflyable("it does not travel while it takes a picture", "heading", hint)
