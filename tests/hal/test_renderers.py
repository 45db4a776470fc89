"""Renderers by name, those of others too."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from hal.renderers import GROUP, check_renderer, open_renderer, renderer_names
from hal.sim import open_session
from hal.vehicle import Intrinsics, Options
from tests.hal.scenes import lens, look, thing_of, world_of
from vencejo.errors import UserError
from vencejo.geometry import Point, Pose
from worlds.things import UPRIGHT, Cuboid, Sphere, Thing
from worlds.world import World

ROOT = Path(__file__).parents[2]
LENS = lens(32, 24)
EYE = look((0, 0, 4), (0, 0, 0))


class Flat:
    """A renderer of somebody else: all of an image in the colour of the ground."""

    def __init__(self, world: World, vehicles: Mapping[str, Thing], shadows: bool) -> None:
        self.opened_with = world, tuple(vehicles), shadows
        self.closed = False

    def render(
        self, pose: Pose, intrinsics: Intrinsics, time: float, vehicles: Mapping[str, Pose]
    ) -> NDArray[np.uint8]:
        image = np.empty((intrinsics.height, intrinsics.width, 3), np.uint8)
        image[:] = self.opened_with[0].ground.color[::-1]
        return image

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def flat_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """An environment where a package with that renderer is installed, and nothing else."""
    points = [EntryPoint("flat", f"{__name__}:Flat", GROUP)]
    monkeypatch.setattr(
        "hal.renderers.plugins",
        lambda group: {point.name: point for point in points if group == GROUP},
    )


def test_the_renderers_of_this_package_are_installed() -> None:
    assert renderer_names() == ["egl", "raster", "tiny"]


@pytest.mark.usefixtures("flat_installed")
def test_a_renderer_of_somebody_else_is_found_and_opened() -> None:
    world, box = world_of(), thing_of("drone", Sphere(0.1), (0, 0, 0))
    assert renderer_names() == ["flat"] and check_renderer("flat") == "flat"
    renderer = open_renderer("flat", world, {"drone": box}, shadows=True)
    assert isinstance(renderer, Flat)
    assert renderer.opened_with == (world, ("drone",), True)
    assert (renderer.render(EYE, LENS, 0.0, {}) == world.ground.color[::-1]).all()


@pytest.mark.usefixtures("flat_installed")
def test_cameras_use_a_renderer_of_somebody_else() -> None:
    settings = {"renderer": "flat", "cameras": {"front": {"width": 32, "height": 24}}}
    with open_session(Options(world="yard", settings=settings)) as session:
        frame = session.vehicles["drone"].camera("front").latest()
        assert frame is not None and frame.image.shape == (24, 32, 3)
        assert len(np.unique(frame.image.reshape(-1, 3), axis=0)) == 1


@pytest.mark.parametrize("name", ["raste", 7])
def test_an_unknown_renderer_is_told_with_the_nearest(name: object) -> None:
    def opened() -> object:
        return open_renderer(name, world_of(), {})  # type: ignore[arg-type]

    for use in (lambda: check_renderer(name), opened):
        with pytest.raises(UserError) as caught:
            use()
        (fault,) = caught.value.faults
        assert (fault.code, fault.message) == (
            "unknown-renderer",
            f"there is no renderer '{name}'",
        )
        known = "known: egl, raster, tiny"
        assert fault.hint == ("did you mean 'raster'?" if name == "raste" else known)


def test_all_renderers_show_the_same_scene() -> None:
    """A red box, a blue vehicle of the same name above it, and one that has no pose."""
    box = thing_of("box", Cuboid(Point(1, 1, 1)), (0, 0, 0.5), color=(250, 0, 0))
    drone = thing_of("box", Cuboid(Point(1, 1, 1)), (0, 0, 0), color=(0, 0, 250))
    for name in renderer_names():
        try:
            renderer = open_renderer(name, world_of(box), {"box": drone, "mouse": drone})
        except UserError as error:
            assert error.code == "no-egl"
            continue
        try:
            alone = renderer.render(EYE, LENS, 0.0, {})
            covered = renderer.render(EYE, LENS, 0.0, {"box": (Point(0, 0, 2), UPRIGHT)})
        finally:
            renderer.close()
        for image, shown, hidden in ((alone, 2, 0), (covered, 0, 2)):
            assert image[12, 16, shown] > 200 and image[12, 16, hidden] == 0, name


def test_nothing_of_a_renderer_is_imported_before_an_image_is_wanted() -> None:
    program = (
        "import sys\n"
        "import cli.main, hal.sim\n"
        "from hal.renderers import renderer_names\n"
        "renderer_names()\n"
        "names = ('cv2', 'numpy', 'pybullet', 'hal.raster', 'hal.sim.bullet_renderers')\n"
        "print([name for name in names if name in sys.modules])\n"
        "from hal.scene import ground_texture, scene, shadows, surfaces, transforms\n"
        "print([name for name in names[2:] if name in sys.modules])\n"
    )
    command = [sys.executable, "-c", program]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert ran.stdout.splitlines() == ["[]", "[]"]
