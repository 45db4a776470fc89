"""Cameras of the simulated vehicle: what they are like, when they take pictures and from where.

A picture shows the world at the capture time that the camera's own rate gives, but it is rendered
only when somebody reads it: reading changes nothing else.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import ceil, floor, isfinite, pi
from typing import TYPE_CHECKING, Any

from hal.renderers import Pose, Renderer, open_renderer
from hal.sim.physics import STEP, State
from hal.vehicle import Frame, Intrinsics
from vencejo.errors import UserError, nearest
from vencejo.geometry import (
    OPTICAL,
    Point,
    Quaternion,
    about_x,
    about_y,
    product,
    turned,
    yaw_quaternion,
)
from worlds.model import World
from worlds.things import Thing

if TYPE_CHECKING:
    from hal.sim.sensors.lens import Optics

_SLOWEST, _FASTEST = 1.0, 240.0
"""Pictures per second: a picture needs a physics step of its own."""
_STEPS_PER_SECOND = round(1 / STEP)
TRACK = ceil(_STEPS_PER_SECOND / _SLOWEST) + 8
"""Physics steps whose states are kept: enough for the slowest camera's last picture."""
_SUB_PICTURES = 5
"""Pictures that are averaged for one with motion blur."""


_MIDDLE = Point(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class CameraSpec:
    """A camera on a vehicle. Metres and radians; body axes are FLU about the centre of mass."""

    at: Point = _MIDDLE
    pan: float = 0.0
    """To the left of straight ahead."""
    tilt: float = 0.0
    """Below straight ahead: π/2 looks down, with ahead at the top of the picture."""
    roll: float = 0.0
    """About the direction it looks in, clockwise as seen from behind."""
    width: int = 320
    height: int = 240
    rate: float = 20.0
    """Pictures per second."""
    view: float = pi / 3
    """Horizontal field of view of the lens without its distortion."""
    distortion: tuple[float, ...] = ()
    """OpenCV's k1, k2, p1, p2, k3; empty for none."""
    exposure: float = 0.0
    """Seconds that the shutter is open, about the capture time; 0 for no motion blur."""
    noise: float = 0.0
    """Standard deviation of each pixel's noise, grey levels."""

    @cached_property
    def intrinsics(self) -> Intrinsics:
        return Intrinsics.of_view(self.width, self.height, self.view, self.distortion)

    @cached_property
    def attitude(self) -> Quaternion:
        """Optical axes in the body's."""
        down = product(about_y(self.tilt), about_x(self.roll))
        return product(product(yaw_quaternion(self.pan), down), OPTICAL)


FRONT = CameraSpec(at=Point(0.2, 0.0, 0.02))
VENTRAL = CameraSpec(at=Point(0.0, 0.0, -0.04), tilt=pi / 2)
DEFAULT_CAMERAS: Mapping[str, CameraSpec] = {"front": FRONT, "ventral": VENTRAL}


def read_cameras(given: object) -> dict[str, CameraSpec]:
    """The cameras of a vehicle, from the setting ``cameras``: a map of names.

    A value is a CameraSpec, a map of its fields that differ from the camera's of that name (or
    from ``front``), or None for no such camera. Raises UserError (``bad-setting``).
    """
    found = dict(DEFAULT_CAMERAS)
    if given is None:
        return found
    if not isinstance(given, Mapping):
        raise _bad("'cameras' is a map of names", 'for instance {"front": {"width": 640}}')
    for name, value in given.items():
        if not isinstance(name, str) or not name.isidentifier():
            raise _bad(f"'{name}' is no name of a camera", "letters, digits and _")
        if value is None:
            found.pop(name, None)
        elif isinstance(value, CameraSpec):
            found[name] = _checked(name, value)
        elif isinstance(value, Mapping):
            known = [each.name for each in fields(CameraSpec)]
            for key in value:
                if key not in known:
                    raise _bad(f"the camera '{name}' has no '{key}'", nearest(str(key), known))
            found[name] = _checked(name, replace(found.get(name, FRONT), **value))
        else:
            raise _bad(f"the camera '{name}' is {value!r}; it must be a map of settings")
    return found


_RANGES = {
    "pan": (-2 * pi, 2 * pi), "tilt": (-2 * pi, 2 * pi), "roll": (-2 * pi, 2 * pi),
    "width": (8, 4096), "height": (8, 4096), "rate": (_SLOWEST, _FASTEST), "view": (0.05, 2.8),
    "exposure": (0.0, 0.5), "noise": (0.0, 100.0),
}  # fmt: skip


def _checked(name: str, spec: CameraSpec) -> CameraSpec:
    for key, (low, high) in _RANGES.items():
        value = getattr(spec, key)
        whole = key not in ("width", "height") or isinstance(value, int)
        if not isinstance(value, (int, float)) or not whole or not low <= value <= high:
            raise _bad(
                f"the camera '{name}' has a {key} of {value!r}", f"it must be {low:g} to {high:g}"
            )
    if not _numbers(spec.at, 3):
        raise _bad(f"the camera '{name}' is at {spec.at!r}", "x, y and z in metres")
    if not _numbers(spec.distortion, 0, 4, 5):
        raise _bad(
            f"the camera '{name}' has a distortion of {spec.distortion!r}",
            "it is a list of OpenCV's k1, k2, p1, p2 and k3",
        )
    return replace(spec, at=Point(*spec.at), distortion=tuple(spec.distortion))


def _numbers(given: Any, *counts: int) -> bool:
    """Whether something is a list of so many finite numbers."""
    try:
        return len(given) in counts and all(map(isfinite, given))
    except TypeError:
        return False


def _bad(message: str, hint: str | None = None) -> UserError:
    return UserError("bad-setting", message, hint=hint)


@dataclass
class Track:
    """Where one vehicle's body was at the last physics steps."""

    states: deque[State] = field(default_factory=lambda: deque(maxlen=TRACK))

    def pose(self, ago: int, offset: float) -> Pose:
        """The body's pose some steps ago, and a moment (s) before or after that."""
        at, attitude, velocity, turning = self.states[-1 - ago]
        if offset:
            at = Point(*at).plus((velocity[0] * offset, velocity[1] * offset, velocity[2] * offset))
            x, y, z = (rate * offset / 2 for rate in turning)
            # A small turn: its quaternion's length differs from 1 by less than a thousandth.
            attitude = product((x, y, z, 1.0), attitude)
            length = sum(part * part for part in attitude) ** 0.5
            qx, qy, qz, qw = attitude
            attitude = qx / length, qy / length, qz / length, qw / length
        return Point(*at), attitude


class Studio:
    """Everything that the pictures of one session have in common; opened with the first one."""

    def __init__(self, world: World, renderer: str, shadows: bool, seed: int) -> None:
        self._world = world
        self._name = renderer
        self._shadows = shadows
        self.seed = seed
        self.tracks: dict[str, Track] = {}
        """Of all vehicles, by name."""
        self.looks: dict[str, Thing] = {}
        self._renderer: Renderer | None = None

    @property
    def renderer(self) -> Renderer:
        """Raises UserError when it cannot be opened."""
        if self._renderer is None:
            self._renderer = open_renderer(
                self._name, self._world, self.looks, shadows=self._shadows
            )
        return self._renderer

    def close(self) -> None:
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


class SimCamera:
    """A camera of a simulated vehicle (see :class:`hal.vehicle.Camera`)."""

    def __init__(
        self, vehicle: str, name: str, spec: CameraSpec, studio: Studio, steps: Callable[[], int]
    ) -> None:
        """``steps``: how many physics steps have been made."""
        self._vehicle = vehicle
        self._name = name
        self._spec = spec
        self._studio = studio
        self._steps = steps
        self._last: Frame | None = None
        self._optics: Optics | None = None

    def latest(self) -> Frame:
        """The newest picture, not to be written to. Raises UserError when nothing can draw it."""
        now, every = self._steps(), _STEPS_PER_SECOND / self._spec.rate
        # A picture is taken at the first physics step at or after its time.
        sequence = floor(now / every + 1e-9)
        step = ceil(sequence * every - 1e-9)
        if self._last is None or self._last.sequence != sequence:
            self._last = self._take(sequence, step, now - step)
        return self._last

    def _take(self, sequence: int, step: int, ago: int) -> Frame:
        if self._optics is None:
            from hal.sim.sensors.lens import Optics

            names = self._vehicle, f"camera.{self._name}"
            self._optics = Optics(self._spec, self._studio.seed, names)
        spec, optics = self._spec, self._optics
        time = step / _STEPS_PER_SECOND
        moments = [0.0]
        if spec.exposure:
            moments = [
                spec.exposure * (k / (_SUB_PICTURES - 1) - 0.5) for k in range(_SUB_PICTURES)
            ]
        pictures = []
        for moment in moments:
            poses = {name: track.pose(ago, moment) for name, track in self._studio.tracks.items()}
            eye = self._eye(poses.pop(self._vehicle))
            pictures.append(self._studio.renderer.render(eye, optics.pinhole, time + moment, poses))
        position, attitude = self._eye(self._studio.tracks[self._vehicle].pose(ago, 0.0))
        image = optics.develop(pictures, sequence)
        return Frame(image, sequence, time, spec.intrinsics, position, attitude)

    def _eye(self, body: Pose) -> Pose:
        at, attitude = body
        return at.plus(turned(self._spec.at, attitude)), product(attitude, self._spec.attitude)
