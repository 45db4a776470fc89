"""The contract of a vehicle: its observations, set-points, orders and sensors.

Every backend (simulator, MAVLink, a test's fake) offers exactly this; docs/backends.md tells how
to write one. Positions and velocities are ENU metres about the *world* origin (the world file's
origin in the simulator, the autopilot's local origin on a real vehicle); body values are FLU; times
are seconds of the session's clock, one for all its vehicles. Nothing is known before the first
:meth:`Session.wait`, and nothing changes but inside ``wait()``. No other method blocks: verbs
return an :class:`~hal.orders.Order` to poll, and a set-point is valid for a short time only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, tan
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, runtime_checkable

from hal.lights import Lights, Rgb
from hal.limits import Limits
from hal.orders import Order
from vencejo.geometry import Point, Quaternion

if TYPE_CHECKING:
    # Only images need it, and it takes longer to import than all of our packages.
    import numpy as np
    from numpy.typing import NDArray

    from worlds.world import Start

PERIODS_PER_SECOND = 40
PERIOD = 1 / PERIODS_PER_SECOND
"""The mission period, seconds: every backend's session waits from one to the next."""
VALIDITY = 0.2
"""Seconds for which a set-point is flown unless it is given anew; then the backend holds."""

Link = Literal["alive", "old", "lost", "gone"]
"""State of a link: the vehicle is heard; silent for OLD_AFTER; for LOST_AFTER; closed for good."""
OLD_AFTER, LOST_AFTER = 1.0, 3.0
"""Seconds of silence."""
Authority = Literal["operator", "mission", "autopilot", "none"]
"""The commands that a vehicle follows: those of a person (at a remote control or ground station),
of the mission, of the autopilot itself (a failsafe), or none (its motors are stopped for good)."""


def link_of(age: float, gone: bool = False) -> Link:
    """The state of a link that was last heard ``age`` seconds ago, or is ``gone`` for good."""
    if gone:
        return "gone"
    return "lost" if age > LOST_AFTER else "old" if age > OLD_AFTER else "alive"


class VehicleEvent(NamedTuple):
    """An event that a vehicle reports: ``operator.takeover``, ``vehicle.collision``, …"""

    name: str
    fields: Mapping[str, Any] = {}


class Observation(NamedTuple):
    """The state of a vehicle at the end of a mission period; immutable."""

    time: float
    """Seconds of the session's clock, which never goes back and never stands still."""
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
    """The place to which the vehicle returns, world frame."""
    health: tuple[str, ...] = ()
    """Problems that keep it from flying, in plain words; empty for none."""
    link_age: float = 0.0
    """Seconds since the vehicle was last heard; the other fields are as of then."""
    link: Link = "alive"
    authority: Authority = "mission"
    authority_reason: str = ""
    """The reason why the mission has no authority, in the autopilot's words if it gives any."""
    epoch: int = 0
    """Counts the jumps of the world frame's origin (the estimator was reset)."""
    origin_shift: Point = Point(0.0, 0.0, 0.0)
    """The present position of the origin of epoch 0, world frame, metres."""
    events: tuple[VehicleEvent, ...] = ()
    """The events of this period, for instance ``vehicle.collision`` for each thing that it begins
    to touch, except the one that it stands or comes down on."""
    wind: Point | None = None
    """The wind where it is, as the vehicle estimates it: the velocity of the air, world frame, m/s;
    None without the capability ``wind``."""


class Velocity(NamedTuple):
    """Fly at a velocity, m/s: (east, north, up), or (forward, left, up) in the heading frame."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    frame: Literal["world", "heading"] = "world"
    yaw_rate: float = 0.0
    """rad/s, counter-clockwise."""


class Position(NamedTuple):
    """Fly to a place (world frame), and be there at ``velocity``, m/s (feed-forward).

    A moving position is where the vehicle is to be when it is sent, with the mean velocity and
    ``acceleration`` (m/s², feed-forward) until the next one, and it is sent anew every period; a
    fixed one needs neither. ``yaw`` (radians) asks for a heading, otherwise ``yaw_rate`` (rad/s)
    turns; with neither the heading stays.
    """

    xyz: Point
    velocity: Point | None = None
    yaw: float | None = None
    yaw_rate: float | None = None
    acceleration: Point | None = None
    """Without it, as far as a vehicle asks, the change of the velocity since the last one."""


class Attitude(NamedTuple):
    """Fly by tilt, for a vehicle with the capability ``attitude``.

    With ``unit="share"`` roll, pitch, climb and yaw rate are shares (−1 to 1) of the configured
    limits, as an AR.Drone is flown; with ``"si"`` they are radians, m/s and rad/s. The tilt and the
    yaw rate are bound by the limits, a climb by those of climb and altitude.
    """

    roll: float = 0.0
    """Right side down; flies to the right."""
    pitch: float = 0.0
    """Nose down; flies forward."""
    climb: float = 0.0
    thrust: float | None = None
    """Share (0 to 1) of the largest thrust, instead of ``climb``; the limits of altitude do not
    apply then."""
    yaw_rate: float = 0.0
    """Counter-clockwise."""
    unit: Literal["si", "share"] = "si"


@dataclass(frozen=True, slots=True)
class Hold:
    """Stop, and hold the position where the vehicle comes to rest."""


Setpoint = Velocity | Position | Attitude | Hold


def is_finite(setpoint: Setpoint) -> bool:
    """Whether every number of a set-point is finite."""
    # One sum tests all of them: it is finite only when every part is.
    if isinstance(setpoint, Position):
        x, y, z = setpoint.xyz
        total = x + y + z + (setpoint.yaw or 0.0) + (setpoint.yaw_rate or 0.0)
        if setpoint.velocity is not None:
            x, y, z = setpoint.velocity
            total += x + y + z
        if setpoint.acceleration is not None:
            x, y, z = setpoint.acceleration
            total += x + y + z
    elif isinstance(setpoint, Velocity):
        total = setpoint.x + setpoint.y + setpoint.z + setpoint.yaw_rate
    elif isinstance(setpoint, Attitude):
        roll, pitch, climb, thrust, yaw_rate, _ = setpoint
        total = roll + pitch + climb + (thrust or 0.0) + yaw_rate
    else:
        return True
    return isfinite(total)


@dataclass(frozen=True, slots=True)
class Answer:
    """The immediate answer to a set-point or to limits: accepted, or refused with a reason."""

    accepted: bool = True
    reason: str = ""


ACCEPTED = Answer()


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
    def from_field_of_view(
        cls, width: int, height: int, field_of_view: float, distortion: tuple[float, ...] = ()
    ) -> Intrinsics:
        """The camera with a horizontal ``field_of_view``, radians.

        Pixels are square, and the optical axis meets the image in its centre.
        """
        focal = width / 2 / tan(field_of_view / 2)
        return cls(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2, distortion)


@dataclass(frozen=True, slots=True)
class Frame:
    """One camera image, with the time, intrinsics and pose that measuring in it needs."""

    image: NDArray[np.uint8]
    """BGR, (height, width, 3)."""
    sequence: int
    time: float
    """Capture time, seconds of the vehicle's clock."""
    intrinsics: Intrinsics
    position: Point
    """Position of the camera, world frame, metres."""
    attitude: Quaternion
    """Camera optical frame (x right, y down, z out) to world."""


@runtime_checkable
class Camera(Protocol):
    """A source of camera images."""

    def latest(self) -> Frame | None:
        """The newest frame; None before the first."""


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
    """A pose measured in images, world frame, for the autopilot's estimator."""

    position: Point
    attitude: Quaternion
    covariance: Sequence[float]
    """Upper triangle of the 6 × 6 matrix (x y z roll pitch yaw), row by row: 21 numbers."""
    captured_at: float
    """Capture time of the image, seconds of the vehicle's clock."""


class Unavailable(LookupError):
    """The vehicle has no such camera, sensor or service."""


@runtime_checkable
class Vehicle(Protocol):
    """One vehicle.

    Verbs are idempotent: a verb under way gives the same order again, and one that changes nothing
    is ``done`` after the next ``wait()``. A verb that the vehicle does not have raises Unavailable.
    """

    @property
    def name(self) -> str: ...

    @property
    def model(self) -> str:
        """The name of its model; empty where it is not known."""

    @property
    def color(self) -> Rgb | None:
        """The colour of its hull; None where it is not known."""

    @property
    def capabilities(self) -> frozenset[str]:
        """Words such as ``position``, ``velocity``, ``arm``, ``takeoff``, ``camera.front``."""

    @property
    def profiles(self) -> Mapping[str, Limits]:
        """Named limits of the vehicle's model (``indoor``, ``outdoor``), altitudes above home."""

    @property
    def limits(self) -> Limits:
        """The limits as they hold now, altitudes in the world frame; None where it is not known,
        or there is none.
        """

    def observe(self) -> Observation:
        """The state at the present mission period.

        Raises RuntimeError before the first ``wait()``, when nothing is known.
        """

    def arm(self) -> Order:
        """Start the motors. Refused while ``health`` names a problem."""

    def disarm(self) -> Order:
        """Stop the motors. Refused in the air."""

    def takeoff(self, altitude: float) -> Order:
        """Rise to ``altitude`` metres above the ground here (arms when needed) and hold.

        Done when the altitude is reached. Refused while landing is forced or the battery is empty.
        """

    def land(self, moving: Point | None = None) -> Order:
        """Descend here and disarm; done when it stands with the motors off.

        ``moving`` is the velocity over the ground, world frame, m/s, to come down with, until it is
        asked for anew with another one or none: that of a thing that moves, so that the vehicle
        does not slide there. Needs the capability ``land.moving``, and raises Unavailable without.

        A vehicle that finds that it does not stand where it came down flies again and holds. The
        order is then refused, and ``vehicle.unstable`` is among the events of that period.
        """

    def return_home(self) -> Order:
        """Fly home in the vehicle's own return mode and land there, as :meth:`land` does."""

    def emergency_stop(self) -> Order:
        """Stop the motors at once, wherever it is."""

    def reset(self) -> Order:
        """Leave the emergency state on the ground, so that it can take off again."""

    def trim(self) -> Order:
        """Take the present attitude as level, on the ground with the motors off."""

    def lights(self, lights: Lights) -> Order:
        """Show a pattern on the vehicle's lamps."""

    def swap_battery(self) -> Order:
        """Take a full battery. Done on the ground with the motors off, and refused otherwise.

        Needs the capability ``battery.swap``.
        """

    def command(self, setpoint: Setpoint, valid_for: float = VALIDITY) -> Answer:
        """Fly a set-point from the next period on; the last one of a period counts.

        It ends a take-off, a landing or a return under way. After ``valid_for`` seconds without a
        new one the vehicle holds, whoever hangs: counted by the session's clock in a simulator, by
        the wall clock on a link. Refused on the ground, while somebody else has authority, and for
        a kind that its capabilities lack. Raises ValueError for numbers that are not finite, and a
        validity that is not above 0.
        """

    @property
    def active_camera(self) -> str | None:
        """The only camera that delivers images now; None where all do.

        Reading another one raises Unavailable.
        """

    def camera(self, name: str) -> Camera:
        """A camera by name. Raises Unavailable."""

    def use_camera(self, name: str | None = None) -> None:
        """Make a camera the active one at once, or the next one. Where all are, nothing happens.

        Raises Unavailable for a camera that the vehicle does not have.
        """

    def sensor(self, name: str) -> Sensor:
        """A sensor by name. Raises Unavailable."""

    def send_vision_pose(self, pose: VisionPose) -> None:
        """Give a measured pose to the estimator. Raises Unavailable."""

    def configure(self, limits: Limits) -> Answer:
        """Change limits, also in flight: all of those given or, when refused, none.

        Raises UserError (``bad-limit``) for impossible limits.
        """


class Session(Protocol):
    """An open backend: its vehicles, in lockstep, with one clock."""

    @property
    def vehicles(self) -> Mapping[str, Vehicle]: ...

    @property
    def engine(self) -> str:
        """The name and version of the physics engine or autopilot link: ``pybullet 3.2.7``."""

    @property
    def settings(self) -> Mapping[str, object]:
        """Its own settings as they hold, defaults included: plain values (as JSON has them) that
        ``Options.settings`` takes.
        """

    @property
    def places(self) -> Mapping[str, Point]:
        """Named places of the world, world frame."""

    @property
    def geographic(self) -> tuple[float, float, float] | None:
        """Latitude, longitude (degrees) and altitude (m) of the world frame's origin, if known."""

    @property
    def ground_height(self) -> Callable[[float, float], float] | None:
        """The height of the ground (terrain, not things) at a place (x, y), world frame, metres;
        None where that is not known. Vehicles of a session that has it have the capability
        ``terrain``.
        """

    def wait(self) -> float:
        """Advance to the next mission period, and return the step made, seconds.

        A simulator steps its physics and always makes one PERIOD; a real link waits, and where
        nothing is heard its clock goes on by the wall clock. The first call waits for the vehicles
        to be heard, and makes one PERIOD however long that takes. Raises VehicleError when one is
        not heard within ``Options.connect_timeout``, and when the simulator is gone; a link that is
        lost later is told by observations.
        """

    def __enter__(self) -> Session: ...

    def __exit__(self, *exc: object) -> None:
        """Close the links, once what the vehicles were told last has been sent."""


@dataclass(frozen=True, slots=True)
class VehicleSpec:
    """One vehicle of a session, as it is asked for; a real vehicle has all but its name already."""

    name: str
    model: str | None = None
    """The name of its model, or the path of its file; None for the world's or the default."""
    start: Start | None = None
    """Its place and heading when the run begins, world frame; None for a start of the world."""
    color: Rgb | None = None
    """The colour of its hull; None for its start's, its model's, or one that its name decides."""


@dataclass(frozen=True, slots=True)
class Options:
    """The options with which a backend is opened."""

    vehicles: tuple[VehicleSpec, ...] = (VehicleSpec("drone"),)
    world: str | None = None
    """Name or path of a world file; None for the backend's default."""
    seed: int = 0
    address: str | None = None
    """The address of a real vehicle; None for the simulator."""
    connect_timeout: float = 10.0
    """Seconds within which every vehicle must have been heard."""
    settings: Mapping[str, object] = field(default_factory=dict)
    """Settings of one backend only, for instance the simulator's ``noise``."""
