"""The simulated camera: capture times and poses of its images.

An image shows the world at the capture time that the camera's own rate gives, but it is rendered
only when it is read: reading changes nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from hal.lights import Rgb
from hal.renderers import Renderer, open_renderer
from hal.scene.lamps import lit_lamps
from hal.sim.pose_history import PoseHistory
from hal.sim.sensors.camera_spec import CameraSpec
from hal.sim.sensors.sampling import Capture, newest_capture
from hal.vehicle import Frame
from vencejo.geometry import Pose, product, turned
from worlds.things import Thing
from worlds.world import World

if TYPE_CHECKING:
    from hal.sim.sensors.lens import Lens

_EXPOSURE_SAMPLES = 5
"""Images that are averaged for one with motion blur."""


class RenderContext:
    """The world, vehicles and renderer that the cameras of one session share.

    The renderer is opened with the first image.
    """

    def __init__(self, world: World, renderer: str, shadows: bool, seed: int) -> None:
        self._world = world
        self._name = renderer
        self._shadows = shadows
        self.seed = seed
        """The run's seed, from which the noise is drawn."""
        self.pose_histories: dict[str, PoseHistory] = {}
        """Name of a vehicle → its poses."""
        self.appearances: dict[str, Thing] = {}
        """Appearance of each vehicle, by its name, and of its lamps."""
        self.lamps: dict[str, Callable[[float], Sequence[Rgb]]] = {}
        """Name of a vehicle → colours of its lamps at a time of the session's clock, seconds."""
        self._renderer: Renderer | None = None

    @property
    def renderer(self) -> Renderer:
        """The renderer, opened at the first call. Raises UserError when that fails."""
        if self._renderer is None:
            self._renderer = open_renderer(
                self._name, self._world, self.appearances, shadows=self._shadows
            )
        return self._renderer

    def close(self) -> None:
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


class SimCamera:
    """A camera of a simulated vehicle (see :class:`hal.vehicle.Camera`)."""

    def __init__(
        self,
        vehicle: str,
        name: str,
        spec: CameraSpec,
        context: RenderContext,
        steps: Callable[[], int],
    ) -> None:
        """``steps``: gives the number of physics steps made."""
        self._vehicle = vehicle
        self._name = name
        self._spec = spec
        self._context = context
        self._steps = steps
        self._last: Frame | None = None
        self._lens: Lens | None = None

    def latest(self) -> Frame:
        """The newest frame; its image is read-only.

        Raises UserError when the renderer cannot be opened or the distortion is too strong.
        """
        steps = self._steps()
        capture = newest_capture(self._spec.rate, steps)
        if self._last is None or self._last.sequence != capture.sequence:
            self._last = self._take(capture, steps - capture.step)
        return self._last

    def _take(self, capture: Capture, steps_ago: int) -> Frame:
        if self._lens is None:
            from hal.sim.sensors.lens import Lens  # late: a flight without images needs no OpenCV

            names = self._vehicle, f"camera.{self._name}"
            self._lens = Lens(self._spec, self._context.seed, names)
        spec, lens, context = self._spec, self._lens, self._context
        moments = [0.0]
        if spec.exposure:
            last = _EXPOSURE_SAMPLES - 1
            moments = [spec.exposure * (k / last - 0.5) for k in range(_EXPOSURE_SAMPLES)]
        images = []
        for moment in moments:
            histories = context.pose_histories.items()
            poses = {name: history.pose(steps_ago, moment) for name, history in histories}
            pose = self._camera_pose(poses.pop(self._vehicle))
            time = capture.time + moment
            for name, body in [*poses.items()]:
                poses.update(lit_lamps(name, context.lamps[name](time), body))
            images.append(context.renderer.render(pose, lens.pinhole, time, poses))
        body = context.pose_histories[self._vehicle].pose(steps_ago)
        position, attitude = self._camera_pose(body)
        image = lens.develop(images, capture.sequence)
        return Frame(image, capture.sequence, capture.time, spec.intrinsics, position, attitude)

    def _camera_pose(self, body: Pose) -> Pose:
        at, attitude = body
        return at.plus(turned(self._spec.at, attitude)), product(attitude, self._spec.attitude)
