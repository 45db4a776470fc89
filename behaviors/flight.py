"""The access of one behaviour to its vehicle: observations, clock, commands and its own events."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import TYPE_CHECKING, Any

from behaviors.channel import PICTURE_NAME, Channel, Draw
from behaviors.frame import MissionFrame
from behaviors.setpoints import checked, number
from fsm.values.intake import kind_of
from hal.lights import Lights
from hal.limits import Limits
from hal.orders import Order
from hal.vehicle import Camera, Frame, Observation, Sensor, Setpoint
from vencejo.geometry import Point

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MOST_PIXELS = 10_000
"""On a side of an annotated picture; JPEG has 65,500."""


class NotInControl(RuntimeError):
    """A behaviour commanded something that it does not control."""


class Flight:
    """One behaviour's access to the vehicle, from its ``start`` to its ``stop``.

    Every behaviour may read. Set-points and all verbs but ``lights`` need ``motion`` among the
    behaviour's ``controls``, and ``lights`` needs ``lights``; otherwise they raise NotInControl.
    """

    def __init__(
        self,
        channel: Channel,
        controls: tuple[str, ...],
        raise_event: Callable[[str, Any], None],
        publish: Callable[[Any], None],
    ) -> None:
        self._channel = channel
        self._controls = controls
        self._raise_event = raise_event
        self._publish = publish
        self.may_command = True
        """Not while its behaviour tells its progress, nor from its ``stop`` on."""

    # Reading.

    @property
    def observation(self) -> Observation:
        """The vehicle in this period; position and home in the mission frame."""
        return self._channel.observation

    @property
    def now(self) -> float:
        """Seconds of the session's clock."""
        return self._channel.observation.time

    @property
    def dt(self) -> float:
        """Seconds since the previous period; more than PERIOD when a real clock made it late."""
        return self._channel.dt

    @property
    def rng(self) -> Random:
        """Draws for this vehicle's behaviours, fixed by the run's seed."""
        return self._channel.rng

    @property
    def frame(self) -> MissionFrame:
        """The mission frame, to convert positions of the world frame."""
        return self._channel.frame

    @property
    def capabilities(self) -> frozenset[str]:
        """The vehicle's capabilities (see :attr:`hal.Vehicle.capabilities`)."""
        return self._channel.vehicle.capabilities

    @property
    def limits(self) -> Limits:
        """The vehicle's limits as they hold (see :attr:`hal.Vehicle.limits`)."""
        return self._channel.vehicle.limits

    def camera(self, name: str) -> Camera:
        """A camera whose frames carry mission-frame poses. Raises hal's Unavailable."""
        return self._channel.camera(name)

    def keep_photo(self, name: str, camera: str, frame: Frame) -> None:
        """Keep a frame of a camera under a name in the run folder, if there is one. Raises
        ValueError for a name that no file gets.
        """
        _require_name(name)
        self._channel.on_photo(name, camera, frame)

    def picture(self, name: str, draw: Draw) -> None:
        """Show people what the behaviour sees: a camera's image with what it found drawn on it.

        ``draw`` gives the annotated picture, BGR, (height, width, 3). It is called, at once, only
        when the picture is kept, which is not the case for every call, so it must change nothing
        that the behaviour goes by. What it raises ends the behaviour in ``failed``. Raises
        ValueError for a name that no folder gets or a picture that is too large, and TypeError when
        ``draw`` gives no picture.
        """
        _require_name(name)
        self._channel.on_picture(name, lambda: _drawn(draw))

    def sensor(self, name: str) -> Sensor:
        """A sensor by name. Raises hal's Unavailable."""
        return self._channel.sensor(name)

    # Events and published values.

    def raise_event(self, name: str, record: Any = None) -> None:
        """Raise an event that the behaviour declares, with a record of its fields.

        Raises ValueError for an event or a field that it does not declare and for values that
        missions cannot hold, TypeError for what is no record, and NotInControl after its ``stop``.
        """
        self._raise_event(name, record)

    def publish(self, record: Any) -> None:
        """Publish values: a record of the class that the behaviour declares.

        Raises TypeError for anything else, ValueError for values that missions cannot hold, and
        NotInControl after its ``stop``.
        """
        self._publish(record)

    # Commands.

    def command(self, setpoint: Setpoint) -> None:
        """Fly a set-point (mission frame) in this period; the last one of a period counts.

        It ends a manoeuvre under way. In a period without either the vehicle holds its place.
        Raises NotInControl, TypeError for what is no set-point, and ValueError for numbers that are
        not finite.
        """
        self._need("motion")
        self._channel.setpoint = checked(setpoint)
        self._channel.order = None

    def arm(self) -> Order:
        """Start the motors (see hal.Vehicle). Raises NotInControl."""
        self._need("motion")
        return self._channel.vehicle.arm()

    def disarm(self) -> Order:
        """Stop the motors on the ground (see hal.Vehicle). Raises NotInControl."""
        self._need("motion")
        return self._channel.vehicle.disarm()

    def takeoff(self, altitude: float) -> Order:
        """Rise to ``altitude`` metres above the ground here.

        Raises NotInControl, and TypeError or ValueError for what is no finite number.
        """
        self._need("motion")
        return self._manoeuvre(self._channel.vehicle.takeoff(number("altitude", altitude)))

    def land(self, moving: Point | None = None) -> Order:
        """Descend here and stop the motors, ``moving`` over the ground at a velocity (m/s) that may
        be given anew (see hal.Vehicle).

        Raises NotInControl, ValueError for what is not finite, and hal's Unavailable.
        """
        self._need("motion")
        return self._manoeuvre(self._channel.vehicle.land(moving))

    def return_home(self) -> Order:
        """Fly home by the vehicle's own means and land there. Raises NotInControl."""
        self._need("motion")
        return self._manoeuvre(self._channel.vehicle.return_home())

    def reset(self) -> Order:
        """Leave the emergency state on the ground. Raises NotInControl and hal's Unavailable."""
        self._need("motion")
        return self._manoeuvre(self._channel.vehicle.reset())

    def trim(self) -> Order:
        """Take the present attitude as level. Raises NotInControl and hal's Unavailable."""
        self._need("motion")
        return self._manoeuvre(self._channel.vehicle.trim())

    def lights(self, lights: Lights) -> Order:
        """Show a pattern on the lamps. Raises NotInControl, TypeError and hal's Unavailable."""
        self._need("lights")
        if not isinstance(lights, Lights):
            raise TypeError(f"lights are shown by a Lights, not by {kind_of(lights)}")
        return self._channel.vehicle.lights(lights)

    def _manoeuvre(self, order: Order) -> Order:
        self._channel.order = order
        return order

    def _need(self, resource: str) -> None:
        if resource not in self._controls:
            raise NotInControl(f"it does not control {resource}: name it in `controls`")
        if not self.may_command:
            told = "being stopped or asked for its progress"
            raise NotInControl(f"a behaviour that is {told} does not control {resource}")


def _require_name(name: str) -> None:
    """Raises ValueError for what is no name of a picture."""
    if not PICTURE_NAME.fullmatch(name):
        hint = "up to 64 letters, digits, _ and -"
        raise ValueError(f"'{name:.70}' is no name of a picture: {hint}")


def _drawn(draw: Draw) -> NDArray[np.uint8]:
    """The picture that ``draw`` gives. Raises TypeError when it is none."""
    import numpy as np  # late: missions that show no pictures start without it

    image: Any = draw()
    if not isinstance(image, np.ndarray):
        raise TypeError(f"a picture is an array of numpy, not {kind_of(image)}")
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or not image.size:
        told = f"{image.dtype} and {image.shape}"
        raise TypeError(f"a picture is of uint8 and (height, width, 3), not of {told}")
    if max(image.shape) > MOST_PIXELS:
        height, width, _ = image.shape
        raise ValueError(
            f"a picture of {width} x {height} pixels is too large: {MOST_PIXELS} a side"
        )
    return image.copy()  # it is written after the period, and may be drawn upon again before
