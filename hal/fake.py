"""A vehicle without physics, for the unit tests of what flies it.

It moves exactly as it is told, at once and at limited speed, over flat ground, at z = 0 until the
origin jumps. Everything a test may want to go wrong is an attribute of :class:`FakeVehicle` or
:class:`FakeSession`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import hypot, inf, tan
from types import MappingProxyType
from typing import Any

from hal.backends import not_heard
from hal.base import BaseSession, BaseVehicle, not_to_be_swapped
from hal.lights import Lights
from hal.limits import Limits
from hal.orders import DONE, UNDER_WAY, Decision, Order, refused
from hal.vehicle import (
    ACCEPTED,
    PERIOD,
    PERIODS_PER_SECOND,
    VALIDITY,
    Answer,
    Attitude,
    Authority,
    Camera,
    Hold,
    Observation,
    Options,
    Position,
    Setpoint,
    VehicleEvent,
    Velocity,
    link_of,
)
from vencejo.geometry import Point, horizontal_distance, rotate_xy, wrap, yaw_quaternion

_STILL = Point(0.0, 0.0, 0.0)
_RETURN_HEIGHT = 5.0
_FALL = 5.0
_GRAVITY = 9.81


class FakeVehicle(BaseVehicle):
    """One vehicle that follows its commands exactly (see :class:`hal.vehicle.Vehicle`)."""

    profiles = MappingProxyType(
        {"indoor": Limits(max_speed=1.0, max_altitude=2.5), "outdoor": Limits(max_altitude=100.0)}
    )

    def __init__(self, name: str = "drone", at: Point = _STILL, yaw: float = 0.0) -> None:
        super().__init__(
            name,
            {
                "arm": self._decide_arm,
                "disarm": self._decide_disarm,
                "takeoff": self._decide_takeoff,
                "land": self._decide_land,
                "return_home": self._decide_return_home,
                "emergency_stop": self._decide_emergency_stop,
                "reset": self._decide_reset,
                "trim": self._decide_trim,
                "lights": self._decide_lights,
                "swap_battery": self._decide_swap_battery,
            },
        )
        self.commands: list[Setpoint] = []
        """All set-points that it was given, refused ones included."""
        self.verbs: list[str] = []
        """All verbs that it was given."""
        self.shown: list[Lights] = []
        """All patterns that its lamps were ordered to show."""
        self.capabilities = frozenset(
            {"position", "velocity", "attitude", "yaw", "arm", "disarm", "takeoff", "land"}
            | {"land.moving", "return_home", "emergency_stop", "reset", "trim", "lights", "limits"}
            | {"battery", "battery.swap"}
        )
        self.position = at
        self.yaw = yaw
        self.battery = 1.0
        """Charge, 0 to 1; it does not drain. At 0 the motors stop."""
        self.health: tuple[str, ...] = ()
        """Reasons for which it refuses to arm."""
        self.silent = False
        """True to cut the link in both directions."""
        self.gone = False
        """True to close the link for good."""
        self.link_age = 0.0
        """Seconds since it was last heard; grows while it is silent."""
        self.authority: Authority = "mission"
        """The authority over it; it refuses set-points unless that is the mission."""
        self.authority_reason = ""
        self.wind = _STILL
        """Velocity that the wind adds to the vehicle's, world frame, m/s."""
        self.estimated_wind: Point | None = None
        """The wind that it observes, world frame, m/s; None where it cannot."""
        self.stuck = False
        """True to let it stay in its place whatever it is commanded."""
        self.unstable_on: list[str] = []
        """Names of the things on which it comes down and does not stand, landing by landing."""
        self.cameras: dict[str, Camera] = {}
        """The cameras that it has, by name; name ``camera.<name>`` among the capabilities too."""
        self.refuse_next: str | None = None
        """Reason for which the next verb, and only that one, is refused."""
        self._limits: dict[str, float] = {
            "max_speed": 5.0,
            "max_climb": 2.0,
            "max_yaw_rate": 1.75,
            "max_tilt": 0.35,
            "max_altitude": inf,
            "min_altitude": -inf,
        }
        """By the names they have in :class:`hal.limits.Limits`."""
        self._ground = 0.0
        """Its height, world frame, metres."""
        self._home = at
        self._epoch = 0
        self._shift = _STILL
        self._events: list[VehicleEvent] = []
        self._time = 0.0
        self._mode = "landed"
        self._armed = False
        self._velocity = _STILL
        self._turning = 0.0
        self._target = _STILL
        self._setpoint: Setpoint = Hold()

    # Events for a test to cause.

    def tell(self, name: str, **fields: Any) -> None:
        """Post an event of the vehicle with its next observation."""
        self._events.append(VehicleEvent(name, fields))

    def jump(self, shift: Point) -> None:
        """Let the origin of its world frame jump, as an estimator's reset does.

        All its coordinates change by ``shift`` metres, though nothing has moved.
        """
        self._epoch += 1
        self._shift = self._shift.plus(shift)
        self.position = self.position.plus(shift)
        self._home = self._home.plus(shift)
        self._target = self._target.plus(shift)
        self._ground += shift.z
        for name in ("min_altitude", "max_altitude"):
            self._limits[name] += shift.z

    def _is_aloft(self) -> bool:
        return self.position.z > self._ground

    # The decision on each verb, made at the beginning of the next period.

    def send(self, verb: str, *arguments: Any) -> Order:
        self.verbs.append(verb)
        return super().send(verb, *arguments)

    def decide(self, order: Order) -> Decision:
        """See BaseVehicle; the next verb is refused where a test asks for that."""
        if self.refuse_next is None:
            return super().decide(order)
        reason, self.refuse_next = self.refuse_next, None
        return refused(reason)

    def _decide_arm(self) -> Decision:
        empty = ("the battery is empty",) if self.battery <= 0 else ()
        if not self._armed and self.health + empty:
            return refused(", ".join(self.health + empty))
        self._armed = True
        return DONE

    def _decide_disarm(self) -> Decision:
        if self._armed and self._is_aloft():
            return refused("the vehicle is in the air")
        self._stop_motors("the motors were stopped")
        return DONE

    def _decide_takeoff(self, altitude: float) -> Decision:
        if self._mode in ("flying", "returning") and self._is_aloft():
            return DONE
        if self._mode == "stopped":
            return refused("the motors were stopped in the air")
        if not 0 < altitude <= self._limits["max_altitude"] - self._ground:
            return refused(f"{altitude:g} m is no altitude to rise to")
        armed = self._decide_arm()
        if armed is not DONE:
            return armed
        self._target = self.position._replace(z=self._ground + altitude)
        self._mode = "taking-off"
        return UNDER_WAY

    def _decide_land(self, *_moving: Point) -> Decision:
        if self._mode == "landed":
            self._armed = False
            return DONE
        if self._mode == "stopped":
            return refused("the motors are stopped")
        self._mode = "landing"
        return UNDER_WAY

    def _decide_return_home(self) -> Decision:
        if self._mode == "landed" and horizontal_distance(self.position, self._home) < 0.5:
            return DONE
        if self._mode in ("landed", "stopped"):
            return refused("the motors are stopped")
        self._target = self._home._replace(z=max(self.position.z, self._home.z + _RETURN_HEIGHT))
        self._mode = "returning"
        return UNDER_WAY

    def _decide_emergency_stop(self) -> Decision:
        if self._armed:
            self._stop_motors("the motors were stopped")
        return DONE

    def _decide_reset(self) -> Decision:
        return DONE if self._mode == "landed" else refused("the vehicle is in the air")

    def _decide_trim(self) -> Decision:
        idle = self._mode == "landed" and not self._armed
        return DONE if idle else refused("the motors are running")

    def _decide_swap_battery(self) -> Decision:
        reason = not_to_be_swapped(aloft=self._is_aloft(), armed=self._armed)
        if reason:
            return refused(reason)
        self.battery = 1.0
        return DONE

    def _decide_lights(self, lights: Lights) -> Decision:
        self.shown.append(lights)
        return DONE

    def _stop_motors(self, reason: str = "") -> None:
        self._armed = False
        self.orders.end(reason)
        self._mode = "stopped" if self._is_aloft() else "landed"

    # Set-points.

    def command(self, setpoint: Setpoint, valid_for: float = VALIDITY) -> Answer:
        answer = super().command(setpoint, valid_for)
        self.commands.append(setpoint)
        return answer

    def refusal(self) -> str:
        """See BaseVehicle."""
        if self.authority != "mission":
            return self.authority_reason or f"the {self.authority} has authority"
        if self._mode == "stopped":
            return "the motors are stopped"
        grounded = not self._is_aloft() and self._mode != "flying"
        return "the vehicle is on the ground" if grounded or self._mode == "landed" else ""

    def fly(self, setpoint: Setpoint) -> None:
        """See BaseVehicle."""
        self._setpoint, self._mode = setpoint, "flying"

    @property
    def limits(self) -> Limits:
        known = {name: value for name, value in self._limits.items() if abs(value) < inf}
        return Limits(**known)

    def configure(self, limits: Limits) -> Answer:
        """See the contract. Raises UserError (``bad-limit``)."""
        wanted = self._limits | limits.given()
        if wanted["min_altitude"] >= wanted["max_altitude"]:
            return Answer(False, "the lowest altitude is above the highest")
        self._limits = wanted
        return ACCEPTED

    def camera(self, name: str) -> Camera:
        return self.cameras[name] if name in self.cameras else super().camera(name)

    # Time.

    def advance(self, now: float, step: float = PERIOD) -> None:
        """Simulate the mission period of ``step`` seconds that ends at ``now``."""
        deaf = self.silent or self.gone
        self.begin_period(heard=not deaf)
        self._time = now
        if self.battery <= 0 and self._armed:
            self._stop_motors("the battery is empty")
        before, self._turning = self.position, 0.0
        if self._mode != "landed":
            # It holds once its set-point has run out, also within a period that comes late.
            flown = min(step, self.remaining_validity())
            after = self._moved(flown).plus(self.wind.times(step))
            self.position = before if self.stuck else after._replace(z=max(self._ground, after.z))
        self._velocity = self.position.minus(before).times(1 / step)
        self._reach()
        self.link_age = self.link_age + step if deaf else self.link_age
        self.end_period(self._observed(deaf))

    def _observed(self, deaf: bool) -> Observation:
        link = link_of(self.link_age, self.gone)
        if deaf:
            last = self.observe()
            return last._replace(time=self._time, link_age=self.link_age, link=link, events=())
        events, self._events = tuple(self._events), []
        return Observation(
            time=self._time,
            position=self.position,
            velocity=self._velocity,
            attitude=yaw_quaternion(self.yaw),
            yaw=wrap(self.yaw),
            rates=Point(0.0, 0.0, self._turning),
            battery=self.battery,
            armed=self._armed,
            flying=self._is_aloft(),
            mode=self._mode,
            home=self._home,
            health=self.health,
            link_age=self.link_age,
            link=link,
            authority=self.authority,
            authority_reason=self.authority_reason,
            epoch=self._epoch,
            origin_shift=self._shift,
            events=events,
            wind=self.estimated_wind,
        )

    def _moved(self, step: float) -> Point:
        """The position after ``step`` seconds without wind; with its motors stopped it falls."""
        match self._mode:
            case "stopped":
                return self.position.plus((0.0, 0.0, -_FALL * step))
            case "landing":
                x, y, _ = self.landing_with or _STILL
                below = self._towards(self.position._replace(z=self._ground), step)
                return below.plus((x * step, y * step, 0.0))
            case "taking-off" | "returning":
                return self._towards(self._target, step)
        return self._flown(step)

    def _flown(self, step: float) -> Point:
        """The position after ``step`` seconds by the set-point."""
        match self._setpoint:
            case Position() as place:
                if place.yaw is not None:
                    self._turn(wrap(place.yaw - self.yaw) / step, step)
                else:
                    self._turn(place.yaw_rate or 0.0, step)
                moved = Point(*(place.velocity or _STILL)).times(step)
                return self._towards(Point(*place.xyz).plus(moved), step)
            case Velocity(x, y, z, frame, yaw_rate):
                if frame == "heading":
                    x, y = rotate_xy(x, y, self.yaw)
                self._turn(yaw_rate, step)
                return self._towards(self.position.plus(Point(x, y, z).times(step)), step)
            case Attitude() as tilt:
                return self._tilted(tilt, step)
        return self.position

    def _tilted(self, setpoint: Attitude, step: float) -> Point:
        """The position after ``step`` seconds by tilt: g·tan(tilt) accelerates it, without drag."""
        limits, share = self._limits, setpoint.unit == "share"
        most = limits["max_tilt"]
        roll, pitch = (
            max(-most, min(most, angle * most if share else angle))
            for angle in (setpoint.roll, setpoint.pitch)
        )
        climb = setpoint.climb * limits["max_climb"] if share else setpoint.climb
        self._turn(setpoint.yaw_rate * (limits["max_yaw_rate"] if share else 1.0), step)
        pull = rotate_xy(_GRAVITY * tan(pitch), -_GRAVITY * tan(roll), self.yaw)
        x, y = self._velocity.x + pull[0] * step, self._velocity.y + pull[1] * step
        return self._towards(self.position.plus(Point(x, y, climb).times(step)), step)

    def _turn(self, rate: float, step: float) -> None:
        most = self._limits["max_yaw_rate"]
        self._turning = max(-most, min(most, rate))
        self.yaw = wrap(self.yaw + self._turning * step)

    def _towards(self, place: Point, step: float) -> Point:
        """The position after ``step`` seconds on the way to a place, within the limits."""
        limits = self._limits
        x, y, z = place.minus(self.position)
        if self._mode == "flying":
            z = max(z, limits["min_altitude"] - self.position.z)
        z = min(z, limits["max_altitude"] - self.position.z)
        far, most = hypot(x, y), limits["max_speed"] * step
        most_up = limits["max_climb"] * step
        share = most / far if far > most else 1.0
        return self.position.plus((x * share, y * share, max(-most_up, min(most_up, z))))

    def _reach(self) -> None:
        """Enter the next mode if the present one is completed."""
        if self._mode == "taking-off" and abs(self.position.z - self._target.z) < 1e-6:
            self.orders.end()
            self._mode, self._setpoint = "flying", Hold()
        elif self._mode == "returning" and horizontal_distance(self.position, self._home) < 1e-6:
            self._mode = "landing"
        elif self._mode in ("landing", "stopped") and not self._is_aloft():
            if self._mode == "landing" and self.unstable_on:
                self._leave(self.unstable_on.pop(0))
            else:
                self._stop_motors()

    def _leave(self, thing: str) -> None:
        """Fly again, since it does not stand on a thing."""
        self.tell("vehicle.unstable", thing=thing)
        self.orders.end(f"it does not stand on the {thing}")
        self._mode, self._setpoint = "flying", Hold()


class FakeSession(BaseSession[FakeVehicle]):
    """Fake vehicles, 2 m apart along x, in lockstep (see :class:`hal.vehicle.Session`)."""

    engine = "fake"

    def __init__(
        self,
        names: Iterable[str] = ("drone",),
        places: Mapping[str, Point] | None = None,
        options: Options | None = None,
    ) -> None:
        super().__init__(
            FakeVehicle(name, Point(2.0 * place, 0.0, 0.0)) for place, name in enumerate(names)
        )
        self.places = MappingProxyType(dict(places or {}))
        self.late = 0.0
        """Seconds by which the next period, and only that one, is late."""
        self._options = options or Options()
        self._lateness = 0.0
        """Sum of the delays of all periods so far, seconds."""

    def wait(self) -> float:
        """See the contract. Raises VehicleError for a vehicle that is silent from the start."""
        if self.periods == 0:
            for vehicle in self.vehicles.values():
                if vehicle.silent:
                    raise not_heard(vehicle.name, self._options)
        self.periods += 1
        step, self.late = PERIOD + self.late, 0.0
        self._lateness += step - PERIOD
        for vehicle in self.vehicles.values():
            vehicle.advance(self.periods / PERIODS_PER_SECOND + self._lateness, step)
        return step
