"""The contract of a vehicle: what it reports and what it can be told.

Every backend (simulator, MAVLink, a test's fake) offers exactly this. Positions and velocities are
ENU metres about the *world* origin (the world file's origin in the simulator, the autopilot's local
origin on a real vehicle); body values are FLU; times are seconds of the vehicle's own clock.
No method blocks: verbs return an :class:`Order` to poll, commands hold until the next one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, tan
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol, runtime_checkable

from vencejo.errors import UserError
from vencejo.geometry import Point, Quaternion

if TYPE_CHECKING:
    # Only pictures need it, and it takes longer to import than all of ours.
    import numpy as np
    from numpy.typing import NDArray

PERIOD = 0.025
"""The mission period, seconds: every backend's session waits from one to the next (40 Hz)."""


class Observation(NamedTuple):
    """What is known of a vehicle at one moment; never changes once given."""

    time: float
    """Seconds of the vehicle's clock."""
    position: Point
    """World frame, metres."""
    velocity: Point
    """World frame, m/s."""
    attitude: Quaternion
    """Body FLU to world ENU, (x, y, z, w)."""
    yaw: float
    """Heading, counter-clockwise from east, radians in (−π, π]."""
    rates: Point
    """Turn rates about the body axes, rad/s."""
    battery: float
    """Charge left, 0 to 1."""
    armed: bool
    flying: bool
    """Off the ground, by altitude and contact."""
    mode: str
    """``landed``, ``taking-off``, ``flying``, ``landing``, ``returning``, ``stopped``, or the
    autopilot's own word."""
    home: Point
    """Where the vehicle returns to, world frame."""
    health: tuple[str, ...] = ()
    """What keeps it from flying, in plain words; empty when all is well."""
    link_age: float = 0.0
    """Seconds since the vehicle was last heard."""
    touched: tuple[str, ...] = ()
    """Names of the things and vehicles it has begun to touch in this period, beside what carries
    it; a vehicle that cannot feel says nothing."""


class Velocity(NamedTuple):
    """Fly at a velocity, m/s: (east, north, up), or (forward, left, up) in the heading frame."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    frame: Literal["world", "heading"] = "world"
    yaw_rate: float = 0.0
    """rad/s, counter-clockwise."""


class Position(NamedTuple):
    """Be at a place (world frame), moving at ``velocity`` when there (feed-forward).

    One that moves is sent anew every period; one that is left standing needs no velocity.
    ``yaw`` asks for a heading, else ``yaw_rate`` turns; with neither the heading stays.
    """

    xyz: Point
    velocity: Point | None = None
    yaw: float | None = None
    yaw_rate: float | None = None


@dataclass(frozen=True, slots=True)
class Hold:
    """Stop, and stay where that happens."""


Setpoint = Velocity | Position | Hold


@dataclass(slots=True)
class Order:
    """What became of a verb. ``sent`` → ``accepted`` → ``done``, or ``refused`` with a reason.

    An order that another one or a set-point ended is refused too; the reason says by what.
    """

    verb: str
    state: Literal["sent", "accepted", "refused", "done"] = "sent"
    reason: str = ""
    """Why it was refused, in the autopilot's words."""

    @property
    def ended(self) -> bool:
        return self.state in ("refused", "done")


@dataclass(frozen=True, slots=True)
class Limits:
    """Settings that can be changed in flight; None leaves a limit as it is."""

    max_speed: float | None = None
    """Over the ground, m/s."""
    max_climb: float | None = None
    """Up or down, m/s."""
    max_tilt: float | None = None
    """Radians from upright."""
    max_yaw_rate: float | None = None
    """rad/s."""
    max_altitude: float | None = None
    """World frame, metres."""

    def given(self) -> dict[str, float]:
        """Those to change, by name. Raises UserError (``bad-limit``)."""
        found = {name: getattr(self, name) for name in self.__slots__}
        found = {name: value for name, value in found.items() if value is not None}
        for name, value in found.items():
            if not (isfinite(value) and value > 0):
                raise UserError("bad-limit", f"'{name}' must be a number above 0, not {value:g}")
        return found


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole camera, pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()
    """OpenCV's k1, k2, p1, p2, k3; empty for none."""

    @classmethod
    def of_view(
        cls, width: int, height: int, field_of_view: float, distortion: tuple[float, ...] = ()
    ) -> Intrinsics:
        """Of a horizontal field of view, radians.

        Pixels are square, and the optical axis meets the middle of the picture.
        """
        focal = width / 2 / tan(field_of_view / 2)
        return cls(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2, distortion)


@dataclass(frozen=True, slots=True)
class Frame:
    """One picture and what is needed to measure in it."""

    image: NDArray[np.uint8]
    """BGR, (height, width, 3)."""
    sequence: int
    time: float
    """When it was taken, seconds of the vehicle's clock."""
    intrinsics: Intrinsics
    position: Point
    """Of the camera, world frame."""
    attitude: Quaternion
    """Camera optical frame (x right, y down, z out) to world."""


@runtime_checkable
class Camera(Protocol):
    """A source of pictures."""

    def latest(self) -> Frame | None:
        """The newest picture; None before the first."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One value of a sensor."""

    time: float
    values: Mapping[str, float]


@runtime_checkable
class Sensor(Protocol):
    """A source of readings."""

    def latest(self) -> Reading | None:
        """The newest reading; None before the first."""


@dataclass(frozen=True, slots=True)
class VisionPose:
    """A pose measured from pictures, world frame, for the autopilot's estimator."""

    position: Point
    attitude: Quaternion
    covariance: Sequence[float]
    """Upper triangle of the 6 × 6 matrix (x y z roll pitch yaw), row by row: 21 numbers."""
    captured_at: float
    """When the picture was taken, seconds of the vehicle's clock."""


class Unavailable(LookupError):
    """The vehicle has no such camera, sensor or service."""


@runtime_checkable
class Vehicle(Protocol):
    """One vehicle. All verbs are idempotent: what is already so is ``done`` at once."""

    @property
    def name(self) -> str: ...

    @property
    def capabilities(self) -> frozenset[str]:
        """Words such as ``position``, ``velocity``, ``arm``, ``takeoff``, ``camera.front``."""

    def observe(self) -> Observation:
        """The state at the present mission period."""

    def arm(self) -> Order:
        """Start the motors. Refused while ``health`` says why not."""

    def disarm(self) -> Order:
        """Stop the motors. Refused in the air."""

    def takeoff(self, altitude: float) -> Order:
        """Rise to ``altitude`` metres above the ground here (arms when needed) and hold.

        Done when the altitude is reached. Refused while landing is forced or the battery is empty.
        """

    def land(self) -> Order:
        """Descend here and disarm; done on the ground with the motors off."""

    def return_home(self) -> Order:
        """Fly home by the vehicle's own means and land there."""

    def emergency_stop(self) -> Order:
        """Stop the motors at once, wherever it is."""

    def command(self, setpoint: Setpoint) -> None:
        """Fly this set-point until the next. Ends a take-off, a landing or a return under way.

        Ignored on the ground.
        """

    def camera(self, name: str) -> Camera:
        """A camera by name. Raises Unavailable."""

    def sensor(self, name: str) -> Sensor:
        """A sensor by name. Raises Unavailable."""

    def send_vision_pose(self, pose: VisionPose) -> None:
        """Hand a measured pose to the estimator. Raises Unavailable."""

    def configure(self, limits: Limits) -> None:
        """Change limits in flight."""


class Session(Protocol):
    """An open backend: its vehicles, in lockstep."""

    @property
    def vehicles(self) -> Mapping[str, Vehicle]: ...

    @property
    def engine(self) -> str:
        """What moves the vehicles, with its version: ``pybullet 3.2.7``."""

    @property
    def places(self) -> Mapping[str, Point]:
        """Named places of the world, world frame."""

    @property
    def geographic(self) -> tuple[float, float, float] | None:
        """Latitude, longitude (degrees) and altitude (m) of the world frame's zero, if known."""

    def wait(self) -> None:
        """Advance to the next mission period: physics is stepped, a real link waits.

        Raises VehicleError when the link or the simulator is gone.
        """

    def __enter__(self) -> Session: ...

    def __exit__(self, *exc: object) -> None: ...


@dataclass(frozen=True, slots=True)
class Options:
    """What a backend is opened with."""

    vehicles: tuple[str, ...] = ("drone",)
    world: str | None = None
    """Name or path of a world file; None for the backend's default."""
    seed: int = 0
    address: str | None = None
    """Where a real vehicle is reached; the simulator has none."""
    settings: Mapping[str, object] = field(default_factory=dict)
    """What only one backend knows, for instance the simulator's ``noise``."""
