"""The simulated vehicle: its modes, and how it answers verbs and commands."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite

from hal.orders import Orders
from hal.sim.airframe import Airframe
from hal.sim.battery import Battery
from hal.sim.contact_tracker import REST, ContactTracker
from hal.sim.control import Controller
from hal.sim.limits import set_limits
from hal.sim.noise import CommandNoise
from hal.sim.obstacle_heights import ObstacleHeightGrid
from hal.sim.physics import Physics, State, in_body
from hal.sim.pose_history import PoseHistory
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
    Velocity,
    VisionPose,
)
from vencejo.geometry import Point, horizontal_distance, wrap, yaw_of, yaw_quaternion
from worlds.model import Start

STEPS = 6
"""Physics steps in a mission period."""
CAPABILITIES = frozenset(
    {"position", "velocity", "yaw", "arm", "takeoff", "land", "return_home", "emergency_stop"}
    | {"battery", "limits"}
)
_RETURN_HEIGHT = 5.0
"""Height above home at which a return flies at least, metres."""
_ARRIVED = 0.05
"""A place this near is reached, metres."""
_TOUCHDOWN_SPEED = 0.3
"""Descent in the last of a landing, m/s; higher up it is the height above ground per second."""


class SimVehicle:
    """One vehicle in the simulator (see :class:`hal.vehicle.Vehicle`).

    Its position is that of the point between the skids, right below the centre of mass: z is 0
    when it stands on the ground.
    """

    def __init__(
        self,
        name: str,
        physics: Physics,
        *,
        airframe: Airframe,
        start: Start,
        charge: float,
        noise: CommandNoise,
        obstacles: ObstacleHeightGrid | None,
    ) -> None:
        """``obstacles`` tells where there is something to touch; without it that is everywhere."""
        self._name = name
        self._airframe = airframe
        self._body = physics.add_body(
            airframe.mass,
            airframe.inertia,
            airframe.size,
            (start.at.x, start.at.y, start.at.z + airframe.height),
            yaw_quaternion(start.heading),
            name,
        )
        self._state: State = self._body.state()
        self.pose_history = PoseHistory()
        self._keep = self.pose_history.append
        self._keep(self._state)
        self.cameras: Mapping[str, Camera] = {}
        self.sensors: Mapping[str, Sensor] = {}
        self._controller = Controller(airframe)
        self._battery = Battery(airframe, charge)
        self._noise = noise
        self._footing = ContactTracker(physics, self._body, airframe.height, obstacles)
        self._home = start.at
        self._time = 0.0
        self._mode = "landed"
        self._armed = False
        self._orders = Orders()
        self._holding = False
        """Hold is the command in force."""
        self._braking = False
        """To stay where it stops, once it has stopped."""
        self._target = 0.0
        """World height that a take-off or a return climbs to, metres."""
        self._thrust = 0.0
        """Sum over the steps of the period, newtons."""
        self._led: Point | None = None
        """Feed-forward velocity commanded in the period before, m/s."""
        self._leading: Point | None = None
        """The same of this period."""
        self._observation: Observation | None = None

    # What is known of it.

    @property
    def name(self) -> str:
        return self._name

    @property
    def capabilities(self) -> frozenset[str]:
        cameras = {f"camera.{name}" for name in self.cameras}
        return CAPABILITIES | cameras | {f"sensor.{name}" for name in self.sensors}

    def observe(self) -> Observation:
        if self._observation is None:
            _, attitude, velocity, turning = self._state
            self._observation = Observation(
                self._time,
                self._position(),
                Point(*velocity),
                attitude,
                wrap(yaw_of(attitude)),
                in_body(turning, attitude),
                self._battery.charge,
                self._armed,
                not self._footing.supported,
                self._mode,
                self._home,
                self._health(),
                touched=self._footing.touched,
            )
        return self._observation

    def _position(self) -> Point:
        x, y, z = self._state[0]
        return Point(x, y, z - self._airframe.height)

    def _health(self) -> tuple[str, ...]:
        problems: tuple[str, ...] = ()
        if self._battery.empty:
            problems += ("the battery is empty",)
        if self._mode == "stopped":
            problems += ("the motors were stopped in the air",)
        qx, qy, _, _ = self._state[1]
        if self._footing.supported and 1 - 2 * (qx * qx + qy * qy) < 0.8:
            problems += ("the vehicle does not stand upright",)
        return problems

    # Verbs.

    def arm(self) -> Order:
        health = self._health()
        if not self._armed and health:
            return _refused("arm", ", ".join(health))
        self._armed = True
        self._observation = None
        return Order("arm", "done")

    def disarm(self) -> Order:
        if self._armed and not self._footing.supported:
            return _refused("disarm", "the vehicle is in the air")
        if self._armed:
            self._stop_motors("the motors were stopped")
        return Order("disarm", "done")

    def takeoff(self, altitude: float) -> Order:
        if order := self._orders.get("takeoff"):
            return order
        if self._mode in ("flying", "returning") and not self._footing.supported:
            return Order("takeoff", "done")
        health = self._health()
        if health:
            return _refused("takeoff", ", ".join(health))
        x, y, z = self._position()
        ground = z if self._footing.supported else z - self._footing.free_below(self._state)
        if not 0 < altitude < float("inf"):
            return _refused("takeoff", f"there is no altitude of {altitude:g} m")
        if ground + altitude > self._controller.max_altitude:
            limit = self._controller.max_altitude
            return _refused("takeoff", f"{ground + altitude:g} m is above the limit of {limit:g} m")
        self._armed = True
        self._braking = False
        self._target = ground + altitude
        self._controller.fly_to(x, y, self._target)
        self._controller.turn(0.0)
        return self._begin("takeoff", "taking-off")

    def land(self) -> Order:
        if order := self._orders.get("land"):
            return order
        if self._mode == "landed":
            return self.disarm()
        if self._mode == "stopped":
            return _refused("land", "the motors are stopped")
        self._brake()
        self._controller.turn(0.0)
        return self._begin("land", "landing")

    def return_home(self) -> Order:
        if order := self._orders.get("return_home"):
            return order
        away = horizontal_distance(self._position(), self._home)
        if self._mode == "landed" and away < 0.5:
            return Order("return_home", "done")
        if self._mode in ("landed", "stopped"):
            return _refused("return_home", "the motors are stopped")
        height = max(self._position().z, self._home.z + _RETURN_HEIGHT)
        self._target = min(height, self._controller.max_altitude)
        self._brake()
        self._controller.turn(0.0)
        return self._begin("return_home", "returning")

    def emergency_stop(self) -> Order:
        if self._armed:
            self._stop_motors("the motors were stopped")
        return Order("emergency_stop", "done")

    def _begin(self, verb: str, mode: str) -> Order:
        """Put an order in the place of those under way."""
        self._enter(mode)
        return self._orders.begin(verb)

    def _enter(self, mode: str) -> None:
        self._mode = mode
        self._footing.stir()
        self._holding = False
        self._observation = None

    def _stop_motors(self, reason: str = "") -> None:
        self._armed = False
        self._orders.end(reason)
        self._enter("landed" if self._footing.supported else "stopped")

    # Commands.

    def command(self, setpoint: Setpoint) -> None:
        """See the contract. Raises ValueError for numbers that are not finite."""
        _check(setpoint)
        grounded = self._footing.supported and self._mode != "flying"
        if grounded or self._mode in ("landed", "stopped"):
            return
        if self._mode != "flying":
            self._orders.end("ended by a command")
            self._enter("flying")
        controller = self._controller
        if isinstance(setpoint, Hold):
            if not self._holding:
                self._brake()
            self._holding = True
            controller.turn(0.0)
            return
        self._holding = self._braking = False
        if isinstance(setpoint, Velocity):
            controller.fly_at(setpoint.x, setpoint.y, setpoint.z, setpoint.frame == "heading")
            controller.turn(setpoint.yaw_rate)
            return
        if setpoint.velocity is None:
            controller.fly_to(*setpoint.xyz)
        else:
            self._follow(setpoint.xyz, setpoint.velocity)
        if setpoint.yaw is not None:
            controller.face(setpoint.yaw)
        else:
            controller.turn(setpoint.yaw_rate or 0.0)

    def _follow(self, place: Point, velocity: Point) -> None:
        # Set-points that come every period tell the acceleration too; one more is needed for it.
        led = self._led or velocity
        self._controller.fly_to(*place, velocity)
        self._controller.acceleration = (
            (velocity[0] - led[0]) / PERIOD,
            (velocity[1] - led[1]) / PERIOD,
            (velocity[2] - led[2]) / PERIOD,
        )
        self._leading = velocity

    def _brake(self) -> None:
        self._controller.fly_at(0.0, 0.0, 0.0)
        self._braking = True

    def configure(self, limits: Limits) -> None:
        """Change limits in flight. Raises UserError (``bad-limit``)."""
        set_limits(self._controller, limits)

    def camera(self, name: str) -> Camera:
        if name not in self.cameras:
            known = ", ".join(self.cameras) or "none"
            raise Unavailable(f"the simulated vehicle has no camera '{name}' (it has: {known})")
        return self.cameras[name]

    def sensor(self, name: str) -> Sensor:
        if name not in self.sensors:
            known = ", ".join(self.sensors) or "none"
            raise Unavailable(f"the simulated vehicle has no sensor '{name}' (it has: {known})")
        return self.sensors[name]

    def send_vision_pose(self, pose: VisionPose) -> None:
        raise Unavailable("the simulated vehicle takes no vision poses: it knows where it is")

    # Time. A period is `plan`; six times `drive`, the engine's step and `sense`; then `update`.

    def plan(self) -> None:
        """Begin a mission period."""
        self._controller.plan(self._state)
        self._footing.plan(self._state)

    def drive(self) -> None:
        """Push for the next physics step."""
        if self._armed and self._mode != "landed":
            thrust, x, y, z = self._controller.step(self._state)
            self._thrust += thrust
            self._body.push(thrust, x, y, z)

    def sense(self) -> None:
        """See where the step has led."""
        self._state = self._body.state()
        self._keep(self._state)
        if self._footing.beside and self._is_active():
            self._footing.feel()

    def _is_active(self) -> bool:
        return self._armed or self._mode != "landed"

    def update(self, time: float) -> None:
        """End a mission period: what was reached, and what to do in the next."""
        self._time = time
        self._observation = None
        self._led, self._leading = self._leading, None
        self._controller.acceleration = (0.0, 0.0, 0.0)
        self._battery.drain(self._thrust / STEPS, PERIOD)
        self._thrust = 0.0
        active = self._is_active()
        self._footing.end_period(self._state, active)
        if not active:
            return
        noise = self._noise.next()
        self._controller.noise = (0.0, 0.0, 0.0) if self._footing.supported else noise
        if self._battery.empty and self._armed:
            self._stop_motors("the battery is empty")
        elif self._mode == "taking-off":
            if self._position().z > self._target - _ARRIVED:
                self._orders.end()
                self._enter("flying")
        elif self._mode == "landing":
            self._update_landing()
        elif self._mode == "returning":
            self._update_return()
        elif self._mode == "stopped":
            if self._footing.settled():
                self._enter("landed")
        elif self._braking and Point(*self._state[2]).norm() < REST:
            self._controller.fly_to(*self._position())
            self._braking = False

    def _update_landing(self) -> None:
        height = self._footing.free_below(self._state)
        if self._footing.settled(on_an_edge=height >= _ARRIVED):
            self._stop_motors()
            return
        self._stay_where_it_stops()
        controller = self._controller
        controller.climb_at(-max(_TOUCHDOWN_SPEED, min(height, controller.max_climb)))

    def _update_return(self) -> None:
        controller, position = self._controller, self._position()
        home = horizontal_distance(position, self._home)
        if home < _ARRIVED:
            self._enter("landing")
        elif self._braking:
            self._stay_where_it_stops()
            controller.height = None if self._braking else self._target
        elif position.z > self._target - _ARRIVED:
            controller.fly_to(self._home.x, self._home.y, self._target)

    def _stay_where_it_stops(self) -> None:
        """Hold the place once the braking is over; the height is left alone."""
        vx, vy, _ = self._state[2]
        if self._braking and Point(vx, vy, 0.0).norm() < REST:
            self._controller.stay_over(*self._position()[:2])
            self._braking = False


def _refused(verb: str, reason: str) -> Order:
    return Order(verb, "refused", reason)


def _check(setpoint: Setpoint) -> None:
    """Keep what is no number out of the physics, where nothing would ever be a number again."""
    if isinstance(setpoint, Velocity):
        total = setpoint.x + setpoint.y + setpoint.z + setpoint.yaw_rate
    elif isinstance(setpoint, Position):
        # One sum tests all: it is finite only when every part is.
        total = sum(setpoint.xyz) + (setpoint.yaw or 0.0) + (setpoint.yaw_rate or 0.0)
        if setpoint.velocity is not None:
            total += sum(setpoint.velocity)
    else:
        return
    if not isfinite(total):
        raise ValueError(f"a set-point needs finite numbers: {setpoint}")
