"""What a world in MuJoCo consists of: what stands still, what moves on a path, and free bodies."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import dist, isnan
from typing import Any

from hal.sim.mujoco_contacts import MujocoContacts
from hal.sim.mujoco_scene import let_meet, scalar_first
from hal.sim.physics import STEP, BodyState, Touch, Triple, in_body
from hal.sim.stretches import STRETCH_STEPS, STRETCH_TIME, velocities
from vencejo.errors import VehicleError
from vencejo.geometry import Point, Pose, product, turned
from worlds.motion import pose_at
from worlds.things import Thing

_STILL, _STILL_TURNING = 1e-3, 5e-3
"""Speed, m/s, and angular speed, rad/s, below which a body stands still."""
_SLIPS = 0.1
"""Speed over what it touches from which a body slides, m/s."""
_AT_REST = (0.0, 0.0, 0.0)


class MujocoFixed:
    """The ground, whose name is empty, or a thing that stands still."""

    free = restless = False

    def __init__(self, name: str, *, slippery: bool = True) -> None:
        self.name, self.slippery = name, slippery

    def velocity_at(self, _: Triple) -> Triple:
        return _AT_REST


class MujocoMover:
    """A thing that follows its path, whatever touches it."""

    free, slippery, restless = False, True, True

    def __init__(self, thing: Thing) -> None:
        self.name = thing.name
        self.turning: Triple = _AT_REST
        """Angular velocity, rad/s, world frame."""
        self._thing = thing
        self._velocity: Triple = _AT_REST
        self._steps = -1
        """Physics steps after which it is where its body is in the engine."""
        self._place: Any = None
        self._rate: Any = None

    def bind(self, model: Any, data: Any, number: int) -> None:
        """From now on it is the body of this number in these data."""
        self._place, self._rate = _views(model, data, number)
        self._steps = -1

    def show(self, steps: int) -> None:
        """Put it where it is after so many physics steps, unless it is there."""
        if steps != self._steps:
            at, attitude = pose_at(self._thing, steps * STEP)
            self._place[:] = *at, *scalar_first(attitude)
            self._steps = steps

    def drive(self, steps: int) -> None:
        """Set its velocity for the next physics step; ``steps`` were made before it.

        Friction then carries along what stands on it, which a body that is only placed does not do.
        """
        if steps % STRETCH_STEPS == 0 or steps != self._steps:
            self._steps = -1  # exactly on its path: errors do not add up
            self.show(steps)
            time = steps // STRETCH_STEPS * STRETCH_TIME
            begin, end = pose_at(self._thing, time), pose_at(self._thing, time + STRETCH_TIME)
            self._velocity, self.turning = velocities(begin, end, STRETCH_TIME)
        self._rate[:] = *self._velocity, *in_body(self.turning, self.pose()[1])
        self._steps = steps + 1

    def pose(self) -> Pose:
        """Its own frame to world."""
        x, y, z, w, i, j, k = self._place.tolist()
        return Point(x, y, z), (i, j, k, w)

    def velocity_at(self, place: Triple) -> Triple:
        """The velocity that it has at a place (world frame), m/s."""
        return _velocity_at(place, self.pose()[0], self._velocity, self.turning)


class MujocoBody:
    """A free body (see :class:`hal.sim.physics.Body`).

    Its state is kept here, so that asking for it costs nothing; the engine has another copy.
    """

    free = slippery = True

    def __init__(self, name: str, state: BodyState, size: Triple, contacts: MujocoContacts) -> None:
        """``size``: its sides, metres."""
        self.name = name
        self.restless = True
        """False while it stands still where nothing moves it, or is withdrawn."""
        self.thickness = min(size)
        """Its least side, metres."""
        self._state = state
        self._reach = dist(size, _AT_REST) / 2
        self._contacts = contacts
        self._resting: Sequence[Touch] = ()
        """What touched it when it fell asleep; the engine then forgets that."""
        self._pushed = self._still = False
        """Since the last look, and at it (see :meth:`look`)."""
        self._carrier: MujocoMover | None = None
        """What it is moored to."""
        self._offset: Pose = (Point(*_AT_REST), (0.0, 0.0, 0.0, 1.0))
        """Its pose on that."""
        self._pushes: list[tuple[Triple, Triple]] = []
        """For the next step."""
        self.withdrawn = False
        """True while it is out of the simulation."""
        self._place: Any = None
        self._rate: Any = None
        self._force: Any = None
        self._meet: Any = None

    def bind(self, model: Any, data: Any, number: int) -> None:
        """From now on it is the body of this number in these data."""
        new = self._place is None
        self._place, self._rate = _views(model, data, number)
        first = model.body_dofadr[number]
        self._force = data.qfrc_applied[first : first + 6]
        self._meet = partial(let_meet, model, number)
        if new:
            self._write()
        if self.withdrawn:
            self._meet()
        else:
            self._meet(things=self.restless, others=True)

    def state(self) -> BodyState:
        return self._state

    def velocity_at(self, place: Triple) -> Triple:
        """The velocity that it has at a place (world frame), m/s."""
        at, attitude, velocity, turning = self._state
        return _velocity_at(place, at, velocity, turned(turning, attitude))

    def push(self, force: Triple, torque: Triple) -> None:
        self._pushed = True
        self.wake()
        self._pushes.append((force, torque))

    def act(self) -> None:
        """Apply the pushes for the next step."""
        for force, torque in self._pushes:
            # MuJoCo wants the force along the world's axes and the torque about the body's.
            self._force += *turned(force, self._state[1]), *torque
        self._pushes.clear()

    def is_fast(self, limit: float) -> bool:
        """Whether a place on it may be faster than a limit, m/s, but for what carries it."""
        at, _, (u, v, w), (a, b, c) = self._state
        turning = self._reach**2 * (a * a + b * b + c * c)
        if u * u + v * v + w * w + turning < limit * limit:
            return False
        others = self._contacts.others(self)
        carrier = next((other for other in others if isinstance(other, MujocoMover)), None)
        return carrier is None or dist(carrier.velocity_at(at), (u, v, w)) > limit

    def slides(self) -> bool:
        """Whether it moves over what it touches."""
        at, _, velocity, _ = self._state
        return any(
            dist(velocity, other.velocity_at(at)) > _SLIPS for other in self._contacts.others(self)
        )

    def read(self) -> None:
        """Take over its state from the engine after a step. Raises VehicleError."""
        x, y, z, qw, qx, qy, qz = self._place.tolist()
        if isnan(x):
            raise VehicleError("no-physics", f"MuJoCo has lost the body '{self.name}'")
        self._resting = ()
        u, v, w, a, b, c = self._rate.tolist()
        self._state = (x, y, z), (qx, qy, qz, qw), (u, v, w), (a, b, c)
        if self._carrier is not None:
            self._go_with(self._carrier)

    def slow(self, velocity: Triple) -> None:
        """Give it another velocity, m/s."""
        place, attitude, _, turning = self._state
        self._state = place, attitude, velocity, turning
        self._write()

    def _write(self) -> None:
        at, attitude, velocity, turning = self._state
        self._place[:] = *at, *scalar_first(attitude)
        self._rate[:] = *velocity, *turning

    def look(self) -> bool:
        """Take a look at it: whether nothing has moved it since the one before."""
        _, _, (u, v, w), (a, b, c) = self._state
        slow = u * u + v * v + w * w < _STILL**2 and a * a + b * b + c * c < _STILL_TURNING**2
        calm = slow and not self._pushed
        rests, self._still, self._pushed = calm and self._still, calm, False
        return rests

    def fall_asleep(self) -> None:
        """Stay in this place until it is pushed, or touched by something restless."""
        self.restless, self._still = False, False
        self._resting = self.contacts()
        self._state = *self._state[:2], _AT_REST, _AT_REST
        self._write()
        self._meet(others=True)

    def withdraw(self) -> None:
        self.restless, self.withdrawn = False, True
        self._carrier = None
        if self._meet is not None:
            self._state = *self._state[:2], _AT_REST, _AT_REST
            self._write()
            self._meet()

    def place(self, state: BodyState) -> None:
        self.restless, self.withdrawn = True, False
        self._state, self._resting = state, ()
        if self._meet is not None:
            self._write()
            self._meet(things=True, others=True)
            self._contacts.outdate()

    def wake(self) -> None:
        """Sleep no longer, if it does."""
        if not self.restless and not self.withdrawn:
            self.restless = True
            self._write()
            self._meet(things=True, others=True)

    def moor(self, moored: bool) -> None:
        touching = set(self._contacts.others(self)) if moored else set()
        if self._carrier is not None:
            if not moored or touching - {self._carrier}:
                self._carrier = None
        elif len(touching) == 1:
            self._moor_to(touching.pop())

    def _moor_to(self, carrier: Any) -> None:
        """Keep the place on a moving thing: in a bend friction alone would let it creep."""
        at, attitude, velocity, _ = self._state
        if isinstance(carrier, MujocoMover) and dist(velocity, carrier.velocity_at(at)) < _SLIPS:
            base, (x, y, z, w) = carrier.pose()
            back = -x, -y, -z, w
            self._offset = turned(Point(*at).minus(base), back), product(back, attitude)
            self._carrier = carrier

    def _go_with(self, carrier: MujocoMover) -> None:
        base, turn = carrier.pose()
        at = base.plus(turned(self._offset[0], turn))
        velocity = carrier.velocity_at(at)
        attitude = product(turn, self._offset[1])
        self._state = at, attitude, velocity, in_body(carrier.turning, attitude)
        self._write()

    def contacts(self) -> Sequence[Touch]:
        if self.withdrawn:
            return ()
        at = self._state[0]
        return [*self._resting] + [
            Touch(
                each.other.name,
                each.place,
                each.normal,
                each.other.velocity_at(at),
                each.other.free,
            )
            for each in self._contacts.of(self)
        ]


def _velocity_at(place: Triple, middle: Triple, velocity: Triple, turning: Triple) -> Triple:
    """The velocity at a place of what turns about its middle; world frame."""
    x, y, z = place[0] - middle[0], place[1] - middle[1], place[2] - middle[2]
    (u, v, w), (a, b, c) = velocity, turning
    return u + b * z - c * y, v + c * x - a * z, w + a * y - b * x


def _views(model: Any, data: Any, number: int) -> tuple[Any, Any]:
    """The place with the attitude, and the velocity with the angular velocity, of a free body."""
    place, rate = model.jnt_qposadr[model.body_jntadr[number]], model.body_dofadr[number]
    return data.qpos[place : place + 7], data.qvel[rate : rate + 6]
