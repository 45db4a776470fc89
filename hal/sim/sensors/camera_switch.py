"""The cameras of a vehicle, of which all deliver images or only the active one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hal.vehicle import Camera, Frame, Unavailable


class CameraSwitch:
    """Chooses the active camera; the first one is active at first."""

    def __init__(self, cameras: Mapping[str, Camera], *, one_active: bool) -> None:
        self.active: str | None = None
        """The only camera that delivers images; None where all do, or there is none."""
        self.cameras = cameras
        """By name, as whoever reads them gets them."""
        if one_active and cameras:
            self.active = next(iter(cameras))
            self.cameras = {n: _Switched(n, camera, self) for n, camera in cameras.items()}

    def use(self, name: str | None) -> None:
        """Activate a camera that there is; None for the one after the active one."""
        if self.active is None:
            return
        names = list(self.cameras)
        self.active = name or names[(names.index(self.active) + 1) % len(names)]


@dataclass(frozen=True)
class _Switched:
    """A camera that delivers images while it is the active one."""

    name: str
    camera: Camera
    switch: CameraSwitch

    def latest(self) -> Frame | None:
        """See the contract. Raises Unavailable while another camera is active."""
        active = self.switch.active
        if active != self.name:
            raise Unavailable(
                f"the camera '{self.name}' is not active, '{active}' is: "
                f"`call: {{camera: {self.name}}}` switches"
            )
        return self.camera.latest()
