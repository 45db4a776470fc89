"""A vehicle without physics, for the unit tests of what flies it.

It moves exactly as it is told, at once and at limited speed, over flat ground at z = 0. Everything
a test may want to go wrong is an attribute of :class:`FakeVehicle`.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot, inf
from types import MappingProxyType

from hal.orders import Orders
from hal.vehicle import (
    PERIOD,
    Camera,
    Hold,
    Limits,
    Observation,
    Order,
    Position,
    Sensor,
    Setpoint,
    Unavailable,
    VisionPose,
)
from vencejo.geometry import Point, horizontal_distance, rotate_xy, wrap, yaw_quaternion

_STILL = Point(0.0, 0.0, 0.0)
_RETURN_HEIGHT = 5.0
_FALL = 5.0


class FakeVehicle:
    """One vehicle that does as it is told (see :class:`hal.vehicle.Vehicle`)."""

    def __init__(self, name: str = "drone", at: Point = _STILL, yaw: float = 0.0) -> None:
        self.commands: list[Setpoint] = []
        """Every set-point it was given, also those it ignored."""
        self.verbs: list[str] = []
        """Every verb it was given."""
        self.capabilities = frozenset(
            {"position", "velocity", "yaw", "arm", "takeoff", "land", "return_home"}
            | {"emergency_stop", "battery", "limits"}
        )
        self.position = at
        self.yaw = yaw
        self.battery = 1.0
        """0 to 1; it stays as it is set. At 0 the motors stop."""
        self.health: tuple[str, ...] = ()
        """Why it refuses to arm."""
        self.link_age = 0.0
        """Seconds since it was last heard."""
        self.wind = _STILL
        """Carries it along in the air, m/s."""
        self.stuck = False
        """It does not get anywhere, whatever it is told."""
        self.refusal: str | None = None
        """Why the next verb is refused; used up by it."""
        self.limits = {"max_speed": 5.0, "max_climb": 2.0, "max_yaw_rate": 1.75}
        self.limits |= {"max_tilt": 0.35, "max_altitude": inf}
        """By the names they have in :class:`hal.vehicle.Limits`."""
        self._name = name
        self._home = at
        self._time = 0.0
        self._mode = "landed"
        self._armed = False
        self._velocity = _STILL
        self._turning = 0.0
        self._target = _STILL
        self._setpoint: Setpoint = Hold()
        self._orders = Orders()

    @property
    def name(self) -> str:
        return self._name

    def observe(self) -> Observation:
        return Observation(
            time=self._time,
            position=self.position,
            velocity=self._velocity,
            attitude=yaw_quaternion(self.yaw),
            yaw=wrap(self.yaw),
            rates=Point(0.0, 0.0, self._turning),
            battery=self.battery,
            armed=self._armed,
            flying=self.position.z > 0.0,
            mode=self._mode,
            home=self._home,
            health=self.health,
            link_age=self.link_age,
        )

    # Verbs.

    def arm(self) -> Order:
        refused = self._refused("arm")
        if refused:
            return refused
        self._armed = True
        return Order("arm", "done")

    def disarm(self) -> Order:
        refused = self._refused("disarm")
        if refused:
            return refused
        if self._armed and self.position.z > 0:
            return Order("disarm", "refused", "the vehicle is in the air")
        self._stop_motors("the motors were stopped")
        return Order("disarm", "done")

    def takeoff(self, altitude: float) -> Order:
        if order := self._refused("takeoff") or self._orders.get("takeoff"):
            return order
        if self._mode in ("flying", "returning") and self.position.z > 0:
            return Order("takeoff", "done")
        if self._mode == "stopped":
            return Order("takeoff", "refused", "the motors were stopped in the air")
        if not 0 < altitude <= self.limits["max_altitude"]:
            return Order("takeoff", "refused", f"{altitude:g} m is no altitude to rise to")
        self._armed = True
        self._target = self.position._replace(z=altitude)
        return self._begin("takeoff", "taking-off")

    def land(self) -> Order:
        if order := self._refused("land") or self._orders.get("land"):
            return order
        if self._mode == "landed":
            self._armed = False
            return Order("land", "done")
        if self._mode == "stopped":
            return Order("land", "refused", "the motors are stopped")
        return self._begin("land", "landing")

    def return_home(self) -> Order:
        if order := self._refused("return_home") or self._orders.get("return_home"):
            return order
        if self._mode == "landed" and horizontal_distance(self.position, self._home) < 0.5:
            return Order("return_home", "done")
        if self._mode in ("landed", "stopped"):
            return Order("return_home", "refused", "the motors are stopped")
        self._target = self._home._replace(z=max(self.position.z, self._home.z + _RETURN_HEIGHT))
        return self._begin("return_home", "returning")

    def emergency_stop(self) -> Order:
        self.verbs.append("emergency_stop")
        if self._armed:
            self._stop_motors("the motors were stopped")
        return Order("emergency_stop", "done")

    def _refused(self, verb: str) -> Order | None:
        """Note a verb; the refusal it meets, if any."""
        self.verbs.append(verb)
        reason, self.refusal = self.refusal, None
        if reason is None and verb in ("arm", "takeoff") and self._mode in ("landed", "landing"):
            empty = ("the battery is empty",) if self.battery <= 0 else ()
            reason = ", ".join(self.health + empty) or None
        return Order(verb, "refused", reason) if reason else None

    def _begin(self, verb: str, mode: str) -> Order:
        self._mode = mode
        return self._orders.begin(verb)

    def _stop_motors(self, reason: str = "") -> None:
        self._armed = False
        self._orders.end(reason)
        self._mode = "stopped" if self.position.z > 0 else "landed"

    # Commands.

    def command(self, setpoint: Setpoint) -> None:
        self.commands.append(setpoint)
        if self._mode in ("landed", "stopped") or (self.position.z <= 0 and self._mode != "flying"):
            return
        self._orders.end("ended by a command")
        self._mode = "flying"
        self._setpoint = setpoint

    def configure(self, limits: Limits) -> None:
        """Change limits in flight. Raises UserError (``bad-limit``)."""
        self.limits |= limits.given()

    def camera(self, name: str) -> Camera:
        raise Unavailable(f"the vehicle has no camera '{name}'")

    def sensor(self, name: str) -> Sensor:
        raise Unavailable(f"the vehicle has no sensor '{name}'")

    def send_vision_pose(self, pose: VisionPose) -> None:
        raise Unavailable("the vehicle takes no vision poses")

    # Time.

    def advance(self, time: float) -> None:
        """Live through the mission period that ends at a time."""
        self._time = time
        if self.battery <= 0 and self._armed:
            self._stop_motors("the battery is empty")
        before, self._turning = self.position, 0.0
        if self._mode != "landed":
            after = self._moved().plus(_times(self.wind, PERIOD))
            self.position = before if self.stuck else after._replace(z=max(0.0, after.z))
        self._velocity = _times(self.position.minus(before), 1 / PERIOD)
        self._reach()

    def _moved(self) -> Point:
        """Where its own motors, or the lack of them, take it."""
        setpoint = self._setpoint
        if self._mode == "stopped":
            return self.position.plus((0.0, 0.0, -_FALL * PERIOD))
        if self._mode == "landing":
            return self._towards(self.position._replace(z=0.0))
        if self._mode in ("taking-off", "returning"):
            return self._towards(self._target)
        if isinstance(setpoint, Hold):
            return self.position
        if isinstance(setpoint, Position):
            if setpoint.yaw is not None:
                self._turn(wrap(setpoint.yaw - self.yaw) / PERIOD)
            else:
                self._turn(setpoint.yaw_rate or 0.0)
            return self._towards(Point(*setpoint.xyz))
        x, y = setpoint.x, setpoint.y
        if setpoint.frame == "heading":
            x, y = rotate_xy(x, y, self.yaw)
        self._turn(setpoint.yaw_rate)
        return self._towards(self.position.plus(_times(Point(x, y, setpoint.z), PERIOD)))

    def _turn(self, rate: float) -> None:
        most = self.limits["max_yaw_rate"]
        self._turning = max(-most, min(most, rate))
        self.yaw = wrap(self.yaw + self._turning * PERIOD)

    def _towards(self, place: Point) -> Point:
        """The next position on the way to a place, within the limits."""
        limits = self.limits
        x, y, z = place.minus(self.position)
        z = min(z, limits["max_altitude"] - self.position.z)
        far, most = hypot(x, y), limits["max_speed"] * PERIOD
        most_up = limits["max_climb"] * PERIOD
        share = most / far if far > most else 1.0
        return self.position.plus((x * share, y * share, max(-most_up, min(most_up, z))))

    def _reach(self) -> None:
        """Enter the next mode where the present one has got to its end."""
        if self._mode == "taking-off" and abs(self.position.z - self._target.z) < 1e-6:
            self._orders.end()
            self._mode, self._setpoint = "flying", Hold()
        elif self._mode == "returning" and horizontal_distance(self.position, self._home) < 1e-6:
            self._mode = "landing"
        elif self._mode in ("landing", "stopped") and self.position.z <= 0:
            self._stop_motors()


class FakeSession:
    """Fake vehicles, 2 m apart along x, in lockstep (see :class:`hal.vehicle.Session`)."""

    engine = "fake"

    def __init__(
        self, names: tuple[str, ...] = ("drone",), places: Mapping[str, Point] | None = None
    ) -> None:
        self.places = MappingProxyType(dict(places or {}))
        self.vehicles = MappingProxyType(
            {name: FakeVehicle(name, Point(2.0 * k, 0.0, 0.0)) for k, name in enumerate(names)}
        )
        self.geographic: tuple[float, float, float] | None = None
        self._count = 0

    def wait(self) -> None:
        self._count += 1
        for vehicle in self.vehicles.values():
            vehicle.advance(self._count / 40)

    def __enter__(self) -> FakeSession:
        return self

    def __exit__(self, *exc: object) -> None:
        pass


def _times(vector: Point, factor: float) -> Point:
    return Point(vector.x * factor, vector.y * factor, vector.z * factor)
