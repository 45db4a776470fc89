"""Cameras of the simulated vehicle."""

from __future__ import annotations

import json
import subprocess
import sys
import tracemalloc
from collections.abc import Mapping
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from hal.engines import open_engine
from hal.lights import Rgb
from hal.scene.appearance import color_of
from hal.scene.transforms import rotation_matrix
from hal.sim import CameraSpec, SimSession, open_session
from hal.sim.sensors.lens import Lens
from hal.vehicle import Frame, Options, Position, Unavailable, VehicleSpec, Velocity
from tests.hal.engines import needs_pybullet
from tests.hal.flying import LONG, named
from tests.hal.scenes import ROAD, marker, town, world_of
from vencejo.errors import UserError
from vencejo.geometry import Point, turned
from worlds.world import Start, World

ROOT = Path(__file__).parents[2]
AHEAD, DOWN = (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)
"""In optical axes: where the camera looks, and its picture's upper edge."""


def session_on(world: World, vehicles: tuple[str, ...] = ("drone",), **settings: Any) -> SimSession:
    return SimSession(Options(named(*vehicles), settings=settings), world, open_engine())


def latest(session: SimSession, camera: str) -> Frame:
    """The newest frame of a camera, which becomes the active one."""
    drone = session.vehicles["drone"]
    drone.use_camera(camera)
    frame = drone.camera(camera).latest()
    assert frame is not None
    return frame


def frames(session: SimSession, camera: str, periods: int) -> list[Frame]:
    """The frames of a camera after each of some periods."""
    found = []
    for _ in range(periods):
        session.wait()
        found.append(latest(session, camera))
    return found


def test_one_camera_of_an_ar_drone_delivers_images_at_a_time() -> None:
    with session_on(world_of()) as session:
        drone = session.vehicles["drone"]
        front, ventral = drone.camera("front"), drone.camera("ventral")
        assert (drone.active_camera, front.latest() is not None) == ("front", True)
        with pytest.raises(
            Unavailable,
            match=r"^the camera 'ventral' is not active, 'front' is: `call: \{camera: ventral\}`",
        ):
            ventral.latest()
        drone.use_camera("ventral")
        assert (drone.active_camera, ventral.latest() is not None) == ("ventral", True)
        with pytest.raises(Unavailable, match="'front' is not active"):
            front.latest()
        drone.use_camera()
        assert drone.active_camera == "front"
        drone.use_camera("front")
        assert drone.active_camera == "front"
        with pytest.raises(Unavailable, match="no camera 'rear'"):
            drone.use_camera("rear")
        assert drone.active_camera == "front"


def test_both_cameras_of_another_model_deliver_images() -> None:
    options = Options((VehicleSpec("drone", "f450"),))
    with SimSession(options, world_of(), open_engine()) as session:
        drone = session.vehicles["drone"]
        assert drone.active_camera is None
        drone.use_camera("ventral")
        drone.use_camera()
        assert all(drone.camera(name).latest() for name in ("front", "ventral"))
        with pytest.raises(Unavailable, match="no camera 'rear'"):
            drone.use_camera("rear")


def test_both_default_cameras_are_told_of() -> None:
    with session_on(world_of()) as session:
        drone = session.vehicles["drone"]
        assert {"camera.front", "camera.ventral"} <= drone.capabilities
        with pytest.raises(Unavailable, match=r"no camera 'rear' \(it has: front, ventral\)"):
            drone.camera("rear")


def test_where_the_default_cameras_look() -> None:
    with session_on(world_of()) as session:
        front, ventral = (latest(session, name) for name in ("front", "ventral"))
        assert turned(AHEAD, front.attitude) == pytest.approx((1, 0, 0), abs=1e-6)
        assert turned(DOWN, front.attitude) == pytest.approx((0, 0, 1), abs=1e-6)
        assert turned(AHEAD, ventral.attitude) == pytest.approx((0, 0, -1), abs=1e-6)
        assert turned(DOWN, ventral.attitude) == pytest.approx((1, 0, 0), abs=1e-6)
        assert front.image.shape == ventral.image.shape == (240, 320, 3)
        assert front.image.dtype == np.uint8
        assert not front.image.flags.writeable
        assert (front.image[:110] == (230, 190, 150)).all()
        assert front.intrinsics.cx == 159.5 and front.intrinsics.distortion == ()


def test_pictures_come_at_the_rate_of_the_camera_and_are_of_its_capture_time() -> None:
    cameras = {"fast": {"rate": 30}, "slow": {"rate": 7.5}}
    with session_on(world_of(), cameras=cameras) as session:
        session.vehicles["drone"].takeoff(2.0)
        fast = frames(session, "fast", 80)
        slow = latest(session, "slow")
        assert [frame.sequence for frame in fast[:4]] == [0, 1, 2, 3]
        assert [frame.sequence for frame in fast[-4:]] == [57, 58, 59, 60]
        assert [frame.time for frame in fast] == [frame.sequence / 30 for frame in fast]
        assert (slow.sequence, slow.time) == (15, 2.0)


def test_a_picture_read_late_shows_its_capture_time() -> None:
    """Read at once or at the end of its time, a frame is the same, pose and pixels."""
    settings = {"cameras": {"down": {"tilt": pi / 2, "rate": 4.0}}}
    seen = []
    for late in (False, True):
        with session_on(town(), **settings) as session:
            drone = session.vehicles["drone"]
            drone.takeoff(3.0)
            for period in range(120):
                if period == 60:
                    drone.command(Velocity(x=2.0, yaw_rate=1.0), LONG)
                session.wait()
                if period == (118 if late else 109):
                    seen.append(latest(session, "down"))
    first, second = seen
    assert (first.sequence, first.time) == (second.sequence, second.time) == (11, 2.75)
    assert (first.position, first.attitude) == (second.position, second.attitude)
    assert (first.image == second.image).all()
    assert first.attitude[0] != 0


def test_the_pose_of_a_frame_fits_its_picture() -> None:
    """A marker is found where the frame's pose, lens and distortion project it."""
    bent = {"distortion": (-0.28, 0.09, 0.001, -0.0008, 0.0), "width": 640, "height": 480}
    world = world_of(marker(4, (2.5, 0.4, 0.01), 0.6), ground=ROAD)
    with session_on(world, cameras={"ventral": bent}) as session:
        drone = session.vehicles["drone"]
        drone.takeoff(2.0)
        frames(session, "ventral", 160)
        drone.command(Position(Point(2.2, 0.2, 2.0), yaw=0.5), LONG)
        checked = 0
        fine = cv2.aruco.DetectorParameters()
        fine.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        find = cv2.aruco.ArucoDetector(known, fine)
        for frame in frames(session, "ventral", 100)[40::10]:
            corners, ids, _ = find.detectMarkers(frame.image)
            if ids is None:
                continue
            lens = frame.intrinsics
            matrix = np.array([[lens.fx, 0, lens.cx], [0, lens.fy, lens.cy], [0, 0, 1]])
            turn = rotation_matrix(frame.attitude).T
            around = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * 0.3
            want, _ = cv2.projectPoints(
                np.add(around, (2.5, 0.4, 0.01)),
                cv2.Rodrigues(turn)[0],
                -turn @ np.array(frame.position),
                matrix,
                np.array(lens.distortion),
            )
            assert np.abs(corners[0].reshape(4, 2) - want.reshape(4, 2)).max() < 0.5
            checked += 1
        assert checked >= 4


def test_a_camera_of_ones_own() -> None:
    spec = CameraSpec(at=Point(0, 0.1, 0), pan=pi / 2, tilt=0.3, width=160, height=120, rate=10.0)
    with session_on(world_of(), cameras={"side": spec, "ventral": None}) as session:
        drone = session.vehicles["drone"]
        assert "camera.ventral" not in drone.capabilities
        side = latest(session, "side")
        assert side.image.shape == (120, 160, 3)
        assert turned(AHEAD, side.attitude) == pytest.approx((0, 0.9553, -0.2955), abs=1e-4)
        assert side.position == pytest.approx((0, 0.1, 0.06), abs=1e-3)


def test_noise_is_as_strong_as_asked_and_the_runs_own() -> None:
    def noisy(seed: int) -> list[Frame]:
        options = Options(seed=seed, settings={"cameras": {"front": {"noise": 4.0}}})
        with SimSession(options, world_of(), open_engine()) as session:
            return frames(session, "front", 6)

    first, again, other = noisy(1), noisy(1), noisy(2)
    sky = [frame.image[:100].astype(int) - (230, 190, 150) for frame in first]
    assert abs(sky[0].mean()) < 0.1 and 3.8 < sky[0].std() < 4.2
    assert (first[1].image == again[1].image).all()
    assert (first[1].image != other[1].image).any()
    assert (first[1].image != first[3].image).any()


def test_exposure_blurs_along_the_motion() -> None:
    def sharpness(exposure: float) -> float:
        with session_on(town(), cameras={"ventral": {"exposure": exposure}}) as session:
            drone = session.vehicles["drone"]
            drone.takeoff(2.0)
            frames(session, "ventral", 100)
            drone.command(Velocity(yaw_rate=1.7), LONG)
            frame = frames(session, "ventral", 60)[-1]
        return float(cv2.Laplacian(frame.image, cv2.CV_64F).var())

    assert sharpness(0.04) < 0.5 * sharpness(0.0)


def test_vehicles_see_each_other_and_not_themselves() -> None:
    with session_on(world_of(), ("cat", "mouse")) as session:
        cat, mouse = session.vehicles["cat"], session.vehicles["mouse"]
        ahead, behind = cat.camera("front").latest(), mouse.camera("front").latest()
        assert ahead is not None and behind is not None
        colors = color_of("mouse"), color_of("cat")
        shown = [
            int((np.abs(frame.image.astype(int) - color[::-1]).max(2) < 60).sum())
            for frame, color in ((ahead, colors[0]), (behind, colors[1]))
        ]
        assert shown[0] > 300 and shown[1] == 0


PINK, LIME, BLACK = (250, 10, 160), (120, 250, 10), (40, 40, 45)


@pytest.mark.parametrize(
    ("asked", "start", "model", "seen"),
    [
        (PINK, LIME, "crazyflie", PINK),
        (None, LIME, "crazyflie", LIME),
        (None, None, "crazyflie", BLACK),
        (None, LIME, None, LIME),
        (None, None, None, color_of("mouse")),
    ],
)
def test_a_fleet_decides_on_a_colour_then_the_world_the_model_and_the_name(
    asked: Rgb | None, start: Rgb | None, model: str | None, seen: Rgb
) -> None:
    world = replace(
        world_of(),
        starts=(Start(Point(0.0, 0.0, 0.0), 0.0), Start(Point(2.0, 0.0, 0.0), 0.0, start)),
    )
    vehicles = VehicleSpec("cat"), VehicleSpec("mouse", model, color=asked)
    with SimSession(Options(vehicles), world, open_engine()) as session:
        session.wait()
        assert session.vehicles["mouse"].color == seen
        taken = session.vehicles["cat"].camera("front").latest()
        assert taken is not None
        shown = np.abs(taken.image.astype(int) - seen[::-1]).max(2) < 30
        assert shown.sum() > (10 if model else 300)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"cameras": {"front": {"widht": 3}}}, "the camera 'front' has no 'widht'"),
        ({"cameras": {"front": {"width": 0}}}, "has a width of 0"),
        ({"cameras": {"front": {"width": 3.5}}}, "has a width of 3.5"),
        ({"cameras": {"front": {"rate": 500}}}, "has a rate of 500"),
        ({"cameras": {"front": {"distortion": (1.0,)}}}, "has a distortion of (1.0,)"),
        ({"cameras": {"front": {"distortion": 0.1}}}, "has a distortion of 0.1"),
        ({"cameras": {"front": {"distortion": ["a"] * 4}}}, "has a distortion of ['a',"),
        ({"cameras": {"front": {"at": None}}}, "is at None"),
        ({"cameras": {"front": {"at": (1.0, 2.0)}}}, "is at (1.0, 2.0)"),
        ({"cameras": {"front": 7}}, "is 7"),
        ({"cameras": {"no name": {}}}, "'no name' is no name of a camera"),
        ({"cameras": 3}, "'cameras' is a map of names"),
        ({"renderer": "opengl"}, "there is no renderer 'opengl'"),
    ],
)
def test_settings_that_cannot_be_are_told(given: dict[str, object], message: str) -> None:
    with pytest.raises(UserError) as error:
        open_session(Options(settings=given))
    assert message in str(error.value)


def test_a_lens_takes_no_more_memory_than_some_pictures() -> None:
    lens = CameraSpec(width=800, height=600, distortion=(-0.1, 0.01, 0, 0, 0), noise=2.0)
    tracemalloc.start()
    try:
        Lens(lens, 0, ("test",))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 100 * 800 * 600


def test_a_distortion_that_bends_too_far_is_told() -> None:
    with (
        session_on(world_of(), cameras={"front": {"distortion": (-3.0, 0, 0, 0)}}) as session,
        pytest.raises(UserError, match="bends the edge of the picture too far"),
    ):
        session.vehicles["drone"].camera("front").latest()


def track(reads: tuple[str, ...], **settings: Any) -> list[object]:
    """All that a vehicle reports in a flight during which some cameras are read."""
    seen: list[object] = []
    with session_on(town(), noise=1.0, **settings) as session:
        drone = session.vehicles["drone"]
        drone.takeoff(2.0)
        for period in range(100):
            if period == 60:
                drone.command(Velocity(x=1.0, yaw_rate=0.5), LONG)
            session.wait()
            if period % 10 == 0:
                for name in reads:
                    latest(session, name)
            seen.append(drone.observe())
    return seen


def test_reading_cameras_changes_nothing_else() -> None:
    alone = track(())
    assert track(("front", "ventral")) == alone
    noisy = {"front": {"noise": 3.0, "exposure": 0.01}}
    assert track(("front",), cameras=noisy) == alone
    assert track(("front",), shadows=True) == alone


@needs_pybullet
def test_another_renderer_changes_nothing_else() -> None:
    assert track(("front",), renderer="tiny") == track(())


def test_a_flight_without_pictures_imports_nothing_for_them() -> None:
    program = (
        "import sys\n"
        "from hal.sim import open_session\n"
        "from hal.vehicle import Options\n"
        "with open_session(Options()) as session:\n"
        "    session.wait()\n"
        "print('cv2' in sys.modules, 'hal.raster' in sys.modules)\n"
    )
    command = [sys.executable, "-c", program]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["False", "False"]


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"wind": "5m/s@270deg,gusts=8m/s"},
        {"noise": True, "engine": "mujoco", "shadows": True, "sensors": {"down": {"rate": 10}}},
        {"cameras": {"front": None, "rear": {"pan": 3.0, "distortion": [0.1, 0.0, 0.0, 0.0]}}},
        {"cameras": {"ventral": {"at": (0.0, 0.1, 0.0), "view": 1.0, "width": 64}}},
    ],
)
def test_a_session_gives_back_its_settings(given: dict[str, object]) -> None:
    def settings(these: Mapping[str, object]) -> Mapping[str, object]:
        with open_session(Options(settings=these)) as session:
            return session.settings

    found = settings(given)
    assert set(found) == {
        "engine",
        "noise",
        "physics",
        "wind",
        "cameras",
        "sensors",
        "renderer",
        "shadows",
    }
    # Through JSON, as a log has them; and in the same sequence.
    assert json.dumps(settings(json.loads(json.dumps(found)))) == json.dumps(found)
