"""The simulated vehicle: its modes, orders and set-points."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, inf

from hal.base import BaseVehicle, not_to_be_swapped
from hal.lights import Lights, Rgb
from hal.limits import Limits
from hal.orders import DONE, UNDER_WAY, Decision, refused
from hal.sim.battery import Battery
from hal.sim.contact_tracker import REST, ContactTracker
from hal.sim.dynamics import Dynamics
from hal.sim.flight_model import RETURN_HEIGHT
from hal.sim.model import Model
from hal.sim.noise import NO_NOISE, CommandNoise
from hal.sim.sensors.camera_switch import CameraSwitch
from hal.sim.touchdown import Touchdown
from hal.vehicle import (
    ACCEPTED,
    PERIOD,
    Answer,
    Attitude,
    Camera,
    Hold,
    Observation,
    Sensor,
    Setpoint,
    Unavailable,
    VehicleEvent,
    Velocity,
)
from vencejo.geometry import Point, horizontal_distance, wrap, yaw_of

_ORIGIN = Point(0.0, 0.0, 0.0)
_CAPABILITIES = frozenset(
    {"position", "velocity", "attitude", "yaw", "arm", "disarm", "takeoff", "land", "land.moving"}
    | {"return_home", "emergency_stop", "reset", "trim", "lights", "limits"}
    | {"battery", "battery.swap", "terrain"}
)
_AT_HOME = 0.5
"""Distance from home within which a landed vehicle has returned already, metres."""
_ARRIVED = 0.05
"""Distance within which a place or height is reached, metres."""
_TOUCHDOWN_SPEED = 0.3
"""Least descent of a landing, m/s; above 0.3 m it is 1/s times the height above ground."""
_CLEAR = 0.5
"""Height by which it rises from what it does not stand on, metres."""
_OVER = 20
"""Mission periods of lying on its back or a side, half a second, after which its motors stop."""
_MAY_STAND = ("landed", "taking-off", "landing")
"""Modes in which it may touch what it can stand on; in the others that is a collision."""


def capabilities_of(model: Model) -> frozenset[str]:
    """The capabilities of a model's vehicles, without cameras and sensors."""
    return _CAPABILITIES | {"wind"} if model.estimates_wind else _CAPABILITIES


class SimVehicle(BaseVehicle):
    """One vehicle in the simulator (see :class:`hal.vehicle.Vehicle`).

    Its position is that of the point between the skids, straight below the centre of mass: z is 0
    when it stands on the ground.
    """

    _lands_with: Point | None = None
    """Velocity over the ground with which it lands, world frame, m/s; None over one place."""

    def __init__(
        self,
        name: str,
        dynamics: Dynamics,
        *,
        model: Model,
        home: Point,
        battery: Battery,
        noise: CommandNoise,
        contacts: ContactTracker,
    ) -> None:
        """``home``: the place of its start."""
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
        self.profiles = model.profiles
        self.model = model.name
        self._model = model
        self.dynamics = dynamics
        self._state = dynamics.state
        """At the end of the last mission period."""
        # The wind that it observes, world frame, m/s; None where its model estimates none.
        self.estimated_wind = _ORIGIN if model.estimates_wind else None
        self._switch = CameraSwitch({}, one_active=False)
        self.sensors: Mapping[str, Sensor] = {}
        self._controller = dynamics.controller
        self.others_near = False
        """True when it can touch another vehicle in this mission period."""
        self._may_touch = False
        """True when it can touch a thing in this mission period."""
        self._motors_run = False
        """In this mission period."""
        self._over = 0
        """Mission periods since it lies on its back or a side."""
        self._crash = ""
        """Why its rotors stand still; empty where they can turn."""
        self._crashed: VehicleEvent | None = None
        """What of that is told in this mission period."""
        self._battery = battery
        self._noise = noise
        self._contacts = contacts
        self._touchdown = Touchdown(self._contacts, model)
        self._unstable = False
        """True when it found in this period that it does not stand where it came down."""
        if battery.chargers:
            self._contacts.look_below(self._state)
        self._home = home
        self._time = 0.0
        self._mode = "landed"
        self._armed = False
        self._lights = self._lights_before = Lights()
        self._lights_since = self._lights_before_since = 0.0
        """Times at which the lamps' pattern and the one before began, session's clock, seconds."""
        self._holding = False
        """True while the last set-point is Hold."""
        self._braking = False
        """True until the vehicle has come to rest, where it then holds its position."""
        self._climb_height = 0.0
        """Height to which a take-off or a return climbs, world frame, metres."""
        self._last_feed_forward: Point | None = None
        """Feed-forward velocity of the last period's set-point, m/s."""
        self._feed_forward: Point | None = None
        """Feed-forward velocity of this period's set-point, m/s."""
        self._min_altitude = -inf

    # Observation.

    def fit(self, switch: CameraSwitch, sensors: Mapping[str, Sensor]) -> None:
        """Mount cameras and sensors, by name."""
        self._switch, self.sensors = switch, sensors
        mounted = {f"camera.{name}" for name in switch.cameras}
        mounted |= {f"sensor.{name}" for name in sensors}
        self.capabilities = capabilities_of(self._model) | mounted

    def _observed(self) -> Observation:
        (x, y, z), attitude, velocity, turning = self._state
        mode, touched = self._mode, self._contacts.touched
        stopped = mode == "stopped"
        # In the order of its fields: with their names it takes twice as long, in every period.
        return Observation._make(
            (
                self._time,
                Point(x, y, z - self._model.height),
                Point(*velocity),
                attitude,
                wrap(yaw_of(attitude)),
                Point(*turning),
                self._battery.charge,
                self._armed,
                not self._contacts.supported,
                mode,
                self._home,
                self._health(),
                0.0,
                "alive",
                "none" if stopped else "mission",
                "the motors are stopped" if stopped else "",
                0,
                _ORIGIN,
                self._events(touched) if touched or self._unstable or self._crashed else (),
                self.estimated_wind,
            )
        )

    def _events(self, touched: tuple[str, ...]) -> tuple[VehicleEvent, ...]:
        events = [VehicleEvent("vehicle.collision", {"thing": thing}) for thing in touched]
        if self._unstable:
            events.append(VehicleEvent("vehicle.unstable", {"thing": self._below()}))
        if self._crashed:
            events.append(self._crashed)
        return tuple(events)

    def _below(self) -> str:
        """What it touched last from below, in words."""
        return self._contacts.thing or "ground"

    def lamps(self, time: float) -> tuple[Rgb, ...]:
        """The colours of its four lamps at a time of the session's clock (see hal.lights)."""
        if time < self._lights_since:
            return self._lights_before.lamps(time - self._lights_before_since)
        return self._lights.lamps(time - self._lights_since)

    def _position(self) -> Point:
        x, y, z = self._state[0]
        return Point(x, y, z - self._model.height)

    def _health(self) -> tuple[str, ...]:
        problems: tuple[str, ...] = ()
        if self._battery.charge <= 0.0:
            problems += ("the battery is empty",)
        if self._mode == "stopped":
            problems += ("the motors were stopped in the air",)
        if self._crash:
            problems += (self._crash,)
        qx, qy, _, _ = self._state[1]
        if self._contacts.supported and 1 - 2 * (qx * qx + qy * qy) < 0.8:
            problems += ("the vehicle does not stand upright",)
        return problems

    # The decision on each verb, made at the beginning of the next period.

    def _decide_arm(self) -> Decision:
        health = self._health()
        if not self._armed and health:
            return refused(", ".join(health))
        self._armed = True
        return DONE

    def _decide_disarm(self) -> Decision:
        if self._armed and not self._contacts.supported:
            return refused("the vehicle is in the air")
        if self._armed:
            self._stop_motors("the motors were stopped")
        return DONE

    def _decide_takeoff(self, altitude: float) -> Decision:
        if self._mode in ("flying", "returning") and not self._contacts.supported:
            return DONE
        health = self._health()
        if health:
            return refused(", ".join(health))
        x, y, z = self._position()
        contacts = self._contacts
        ground = z if contacts.supported else z - contacts.height_above_ground(self._state)
        if not 0 < altitude < inf:
            return refused(f"there is no altitude of {altitude:g} m")
        if ground + altitude > self._controller.max_altitude:
            limit = self._controller.max_altitude
            return refused(f"{round(ground + altitude, 2):g} m is above the limit of {limit:g} m")
        self._armed = True
        self._braking = False
        self._climb_height = ground + altitude
        self._controller.fly_to(x, y, self._climb_height)
        self._controller.turn(0.0)
        self._enter("taking-off")
        return UNDER_WAY

    def _decide_land(self, moving: Point | None = None) -> Decision:
        if self._mode == "landed":
            return self._decide_disarm()
        if self._mode == "stopped":
            return refused("the motors are stopped")
        if self._mode != "landing":
            self._enter("landing")
            self._come_down(moving)
            self._controller.turn(0.0)
        return UNDER_WAY

    def _come_down(self, moving: Point | None) -> None:
        """Land over one place, or with a velocity over the ground."""
        self._lands_with = moving
        if moving is None:
            self._brake()
        else:
            self._controller.fly_at(moving.x, moving.y, 0.0)
            self._braking = False

    def _decide_return_home(self) -> Decision:
        away = horizontal_distance(self._position(), self._home)
        if self._mode == "landed" and away < _AT_HOME:
            return DONE
        if self._mode in ("landed", "stopped"):
            return refused("the motors are stopped")
        height = max(self._position().z, self._home.z + RETURN_HEIGHT)
        self._climb_height = min(height, self._controller.max_altitude)
        self._brake()
        self._controller.turn(0.0)
        self._enter("returning")
        return UNDER_WAY

    def _decide_emergency_stop(self) -> Decision:
        if self._armed:
            self._stop_motors("the motors were stopped")
        return DONE

    def _decide_reset(self) -> Decision:
        # An emergency ends by itself once the vehicle rests, unless it lies on its back.
        if self._mode == "landed":
            self._crash = ""
        health = self._health()
        return refused(", ".join(health)) if health or self._mode != "landed" else DONE

    def _decide_trim(self) -> Decision:
        # The simulated attitude has no error to trim.
        idle = self._mode == "landed" and not self._armed
        return DONE if idle else refused("the motors are running")

    def _decide_swap_battery(self) -> Decision:
        reason = not_to_be_swapped(aloft=not self._contacts.supported, armed=self._armed)
        if reason:
            return refused(reason)
        self._battery.swap()
        return DONE

    def _decide_lights(self, lights: Lights) -> Decision:
        self._lights_before, self._lights_before_since = self._lights, self._lights_since
        self._lights, self._lights_since = lights, self._time
        return DONE

    def _enter(self, mode: str) -> None:
        self._mode = mode
        self.dynamics.body.moor(mode == "landed")
        self._contacts.restart_rest()
        self._touchdown.restart()
        self._holding = False
        self._lands_with = None
        # The lowest altitude does not bind take-off, landing and return.
        self._controller.min_altitude = -inf

    def _stop_motors(self, reason: str = "") -> None:
        self._armed = False
        self.orders.end(reason)
        self._enter("landed" if self._contacts.supported else "stopped")

    # Set-points.

    def refusal(self) -> str:
        """See BaseVehicle."""
        mode = self._mode
        if mode == "flying":
            return ""
        if mode == "stopped":
            return "the motors are stopped"
        grounded = self._contacts.supported or mode == "landed"
        return "the vehicle is on the ground" if grounded else ""

    def fly(self, setpoint: Setpoint) -> None:
        """Let the controller follow a set-point."""
        if self._mode != "flying":
            self._enter("flying")
        controller = self._controller
        if isinstance(setpoint, Hold):
            if not self._holding:
                self._brake()
            self._holding = True
            controller.turn(0.0)
            return
        self._holding = self._braking = False
        controller.min_altitude = self._min_altitude
        if isinstance(setpoint, Velocity):
            controller.fly_at(setpoint.x, setpoint.y, setpoint.z, setpoint.frame == "heading")
            controller.turn(setpoint.yaw_rate)
            return
        if isinstance(setpoint, Attitude):
            self._tilt(setpoint)
            return
        if setpoint.velocity is None:
            controller.fly_to(*setpoint.xyz)
        else:
            self._follow(setpoint.xyz, setpoint.velocity, setpoint.acceleration)
        if setpoint.yaw is not None:
            controller.face(setpoint.yaw)
        else:
            controller.turn(setpoint.yaw_rate or 0.0)

    def _tilt(self, setpoint: Attitude) -> None:
        controller = self._controller
        roll, pitch, climb, thrust, yaw_rate, unit = setpoint
        if unit == "share":
            most = controller.max_tilt
            roll, pitch = roll * most, pitch * most
            climb, yaw_rate = climb * controller.max_climb, yaw_rate * controller.max_yaw_rate
        controller.tilt(roll, pitch, climb, thrust)
        controller.turn(yaw_rate)

    def _follow(self, place: Point, velocity: Point, acceleration: Point | None) -> None:
        self._controller.fly_to(*place, velocity)
        if acceleration is None:
            # Then it is that between the set-points of two successive periods.
            led = self._last_feed_forward or velocity
            acceleration = Point(
                (velocity[0] - led[0]) / PERIOD,
                (velocity[1] - led[1]) / PERIOD,
                (velocity[2] - led[2]) / PERIOD,
            )
        self._controller.acceleration = acceleration
        self._feed_forward = velocity

    def _brake(self) -> None:
        self._controller.fly_at(0.0, 0.0, 0.0)
        self._braking = True

    @property
    def limits(self) -> Limits:
        controller, low = self._controller, self._min_altitude
        high = controller.max_altitude
        return Limits(
            controller.max_speed,
            controller.max_climb,
            controller.max_tilt,
            controller.max_yaw_rate,
            None if low == -inf else low,
            None if high == inf else high,
        )

    def configure(self, limits: Limits) -> Answer:
        """See the contract. Raises UserError (``bad-limit``)."""
        given = limits.given()
        if given.get("max_tilt", 0.0) > self._model.steepest:
            steepest = self._model.steepest
            return Answer(False, f"'max_tilt' can be {steepest:.2f} rad at most")
        low = given.get("min_altitude", self._min_altitude)
        high = given.get("max_altitude", self._controller.max_altitude)
        if low >= high:
            return Answer(False, f"the lowest altitude {low:g} m is above the highest {high:g} m")
        for name, value in given.items():
            if name == "min_altitude":
                self._min_altitude = value  # binds from the next set-point on
            else:
                setattr(self._controller, name, value)
        return ACCEPTED

    @property
    def active_camera(self) -> str | None:
        return self._switch.active

    def camera(self, name: str) -> Camera:
        cameras = self._switch.cameras
        if name not in cameras:
            known = ", ".join(cameras) or "none"
            raise Unavailable(f"the vehicle '{self.name}' has no camera '{name}' (it has: {known})")
        return cameras[name]

    def use_camera(self, name: str | None = None) -> None:
        if name is not None:
            self.camera(name)
        self._switch.use(name)

    def sensor(self, name: str) -> Sensor:
        if name not in self.sensors:
            known = ", ".join(self.sensors) or "none"
            raise Unavailable(f"the vehicle '{self.name}' has no sensor '{name}' (it has: {known})")
        return self.sensors[name]

    # A mission period is `plan`; six steps of the dynamics, each with `sense`; then `update`.

    def plan(self) -> None:
        """Begin a mission period: carry out orders and set-points, and plan the control."""
        self.begin_period()
        state, contacts, dynamics = self._state, self._contacts, self.dynamics
        self._controller.plan(state)
        contacts.begin_period(state, self._mode in _MAY_STAND, self.others_near)
        landed, active = self._mode == "landed", self._is_active()
        self._motors_run = self._armed and not landed and not self._touchdown.idle
        if landed:
            dynamics.body.moor(True)
        free = active and not contacts.near_things and not contacts.near_ground
        self._may_touch = contacts.near_things and active
        dynamics.begin_period(free=free, motors_run=self._motors_run, supported=contacts.supported)
        if self._motors_run:
            far = free or not dynamics.effects.ground_effect
            above = inf if far else contacts.height_above_ground(state) + self._model.height
            voltage = self._battery.voltage / self._model.battery.full
            dynamics.set_air(voltage=voltage, height=above, touched=contacts.clear == 0)

    def sense(self) -> None:
        """Read the state and the contacts after a physics step."""
        self.dynamics.sense()
        if self._may_touch:
            self._contacts.update(self.dynamics.state)

    def _is_active(self) -> bool:
        return self._armed or self._mode != "landed"

    def update(self, time: float) -> None:
        """End the mission period at ``time``: update the mode, and make the observation."""
        self._time, self._state = time, self.dynamics.state
        self._last_feed_forward, self._feed_forward = self._feed_forward, None
        self._controller.acceleration = (0.0, 0.0, 0.0)
        self._battery.drain(self.dynamics.power(self._armed), PERIOD)
        if self._battery.chargers and self._mode == "landed" and not self._armed:
            self._battery.charge_on(self._contacts.thing, PERIOD)
        active = self._is_active()
        self._contacts.end_period(self._state, active, self._motors_run)
        self._unstable = False
        self._crashed = None
        if active:
            self._update_mode()
            self._look_for_crash()
        self.end_period(self._observed())

    def _look_for_crash(self) -> None:
        """Tell that it was hit too hard, or lies on its back, and stop its motors if they run."""
        if not self.dynamics.effects.crashes or self._crash:
            return
        contacts = self._contacts
        if contacts.impact > self._model.withstands:
            thing = contacts.hit_by or "ground"
            hit = "a rotor was stopped by" if self._armed else "it fell on"
            self._tell_crash(f"{hit} the {thing}", thing)
        elif self._armed and self._lies_over():
            self._tell_capsizing()

    def _lies_over(self) -> bool:
        """Whether it has lain, leaning further than its thrust could ever lift it, for a while."""
        x, y, _, _ = self._state[1]
        leans = 1 - 2 * (x * x + y * y) < cos(self._model.steepest)
        self._over = self._over + 1 if leans and self._contacts.still else 0
        return self._over >= _OVER

    def _tell_capsizing(self) -> None:
        self._tell_crash(f"it has capsized on the {self._below()}", self._below())

    def _tell_crash(self, reason: str, thing: str) -> None:
        self._crash, self._over = reason, 0
        facts = {"thing": thing, "speed": self._contacts.impact, "reason": reason}
        self._crashed = VehicleEvent("vehicle.crashed", facts)
        self._stop_motors(reason)

    def _update_mode(self) -> None:
        noise = self._noise.next()
        self._controller.noise = NO_NOISE if self._contacts.supported else noise
        if self._battery.empty and self._armed:
            self._stop_motors("the battery is empty")
        elif self._mode == "taking-off":
            if self._position().z > self._climb_height - _ARRIVED:
                self.orders.end()
                self._enter("flying")
        elif self._mode == "landing":
            self._update_landing()
        elif self._mode == "returning":
            self._update_return()
        elif self._mode == "stopped":
            if self._contacts.settled:
                self._enter("landed")
        elif self._braking and Point(*self._state[2]).norm() < REST:
            self._controller.fly_to(*self._position())
            self._braking = False

    def _update_landing(self) -> None:
        height = self._contacts.height_above_ground(self._state)
        verdict = self._touchdown.update(self._state, height)
        if verdict == "stands":
            self._stop_motors()
        elif verdict == "unstable":
            self._leave()
        elif verdict == "capsized" and self.dynamics.effects.crashes:
            self._tell_capsizing()
        elif verdict == "capsized":
            self._stop_motors(f"it has capsized on the {self._below()}")
        else:
            self._follow_landing()
            sinking = max(_TOUCHDOWN_SPEED, min(height, self._controller.max_climb))
            self._controller.climb_at(-sinking)

    def _follow_landing(self) -> None:
        """Land with the velocity that it was asked for last; without one, stop and stay there."""
        if self.landing_with != self._lands_with:
            self._come_down(self.landing_with)
        self._hold_when_at_rest()

    def _leave(self) -> None:
        """Rise from what it does not stand on, and hold there."""
        self._unstable = True
        self.orders.end(f"it does not stand on the {self._below()}")
        self._enter("flying")
        x, y, z = self._position()
        self._controller.fly_to(x, y, z + _CLEAR)
        self._holding = True

    def _update_return(self) -> None:
        controller, position = self._controller, self._position()
        home = horizontal_distance(position, self._home)
        if home < _ARRIVED:
            self._enter("landing")
        elif self._braking:
            self._hold_when_at_rest()
            controller.height = None if self._braking else self._climb_height
        elif position.z > min(self._climb_height, controller.max_altitude) - _ARRIVED:
            controller.fly_to(self._home.x, self._home.y, self._climb_height)

    def _hold_when_at_rest(self) -> None:
        """Hold the horizontal position once the vehicle has come to rest."""
        vx, vy, _ = self._state[2]
        if self._braking and Point(vx, vy, 0.0).norm() < REST:
            self._controller.stay_over(*self._position()[:2])
            self._braking = False
