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

from hal.engines import is_installed
from hal.renderers import GROUP, check_renderer, open_renderer, renderer_names, show_window
from hal.sim import open_session
from hal.vehicle import Intrinsics, Options
from tests.hal.scenes import lens, look, thing_of, world_of
from vencejo.errors import UserError
from vencejo.geometry import Point, Pose
from worlds.things import UPRIGHT, Cuboid, Cylinder, Sphere, Thing
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


NOT_HERE = ("no-egl",) if is_installed("bullet") else ("no-pybullet",)
"""Why a renderer may be missing."""


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


@pytest.mark.parametrize("name", ["tiny", "egl"])
def test_without_pybullet_its_renderers_and_its_window_say_so(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    for use in (
        lambda: check_renderer(name),
        lambda: open_session(Options(settings={"renderer": name})),
        lambda: show_window(world_of()),
    ):
        with pytest.raises(UserError, match="is pybullet's, which is not installed") as caught:
            use()
        assert caught.value.code == "no-pybullet" and "vencejo[bullet]" in str(caught.value)


def test_all_renderers_show_the_same_scene() -> None:
    """A red box, a blue vehicle of the same name above it, and one that has no pose."""
    box = thing_of("box", Cuboid(Point(1, 1, 1)), (0, 0, 0.5), color=(250, 0, 0))
    drone = thing_of("box", Cuboid(Point(1, 1, 1)), (0, 0, 0), color=(0, 0, 250))
    for name in renderer_names():
        try:
            renderer = open_renderer(name, world_of(box), {"box": drone, "mouse": drone})
        except UserError as error:
            assert error.code in NOT_HERE
            continue
        try:
            alone = renderer.render(EYE, LENS, 0.0, {})
            covered = renderer.render(EYE, LENS, 0.0, {"box": (Point(0, 0, 2), UPRIGHT)})
        finally:
            renderer.close()
        for image, shown, hidden in ((alone, 2, 0), (covered, 0, 2)):
            assert image[12, 16, shown] > 200 and image[12, 16, hidden] == 0, name


CLOSE = [
    (Cuboid(Point(1, 20, 20)), (0.5, 0, 5), (1, 0, 0)),
    (Cuboid(Point(1, 20, 20)), (0.5, 0, 5), (1, 0.8, 0.2)),
    (Cuboid(Point(10, 10, 1)), (0, 0, 4.5), (0, 0, -1)),
    (Cylinder(0.3, 4), (0.3, 0, 5), (1, 0, 0)),
    (Sphere(0.1), (0.1, 0, 5), (1, 0, 0)),
    (Sphere(3.0), (3.0, 0, 5), (1, 0, 0)),
]
"""Shapes, places where they touch (0, 0, 5), and directions in which a camera looks at them."""


@pytest.mark.parametrize("name", ["egl", "raster", "tiny"])
@pytest.mark.parametrize("gap", [0.002, 0.01, 0.049, 0.051])
def test_nothing_close_is_seen_through(name: str, gap: float) -> None:
    """A camera on a vehicle that touches something has it right before its lens."""
    for shape, at, to in CLOSE:
        away = [gap * (-1 if axis < 0 else axis > 0) for axis in (at[0], 0, at[2] - 5)]
        place = (at[0] + away[0], 0.0, at[2] + away[2])
        world = world_of(thing_of("thing", shape, place, color=(200, 0, 0)))
        try:
            renderer = open_renderer(name, world, {})
        except UserError as error:
            assert error.code in NOT_HERE
            return
        eye = look((0, 0, 5), (to[0], to[1], 5 + to[2]))
        image = renderer.render(eye, LENS, 0.0, {})
        renderer.close()
        assert (image[..., 2] > 50).all() and (image[..., :2] < 10).all(), shape


@pytest.mark.parametrize(("name", "off"), [("egl", 0.03), ("raster", 0.001), ("tiny", 0.001)])
def test_what_is_close_hides_what_is_behind_and_nothing_else(name: str, off: float) -> None:
    """A rod 1 cm before the lens, in front of a wall with a poster a little off it."""
    rod = thing_of("rod", Cylinder(0.001, 4), (0.011, 0, 5), color=(200, 0, 0))
    wall = thing_of("wall", Cuboid(Point(1, 20, 20)), (6.5, 0, 5), color=(0, 200, 0))
    poster = thing_of("poster", Cuboid(Point(0.1, 4, 4)), (6.05 - off, 0, 5), color=(0, 0, 200))
    try:
        renderer = open_renderer(name, world_of(rod, wall, poster), {})
    except UserError as error:
        assert error.code in NOT_HERE
        return
    image = renderer.render(look((0, 0, 5), (1, 0, 5)), LENS, 0.0, {})
    renderer.close()
    shown = [int(np.argmax(image[12, column])) for column in range(32)]
    assert set(shown[14:18]) == {2}, "the rod"
    assert set(shown[8:13]) == set(shown[19:24]) == {0}, "the poster"
    assert set(shown[:4]) == set(shown[-4:]) == {1}, "the wall"


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
