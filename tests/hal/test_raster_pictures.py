"""The accuracy and steadiness of images."""

from __future__ import annotations

from dataclasses import replace
from itertools import product as combined
from math import pi, radians
from pathlib import Path
from random import Random

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hal.raster import Raster
from hal.scene.arrays import Float64s
from hal.scene.surfaces import sphere_mesh
from hal.scene.transforms import rotation_matrix
from hal.sim.bullet_renderers import EglRenderer, TinyRenderer
from hal.vehicle import Intrinsics
from tests.hal.engines import needs_pybullet
from tests.hal.scenes import (
    GREEN,
    ROAD,
    lens,
    look,
    marker,
    random_attitude,
    thing_of,
    town,
    turned,
    world_of,
)
from vencejo.errors import UserError
from vencejo.geometry import Point, Pose, product, yaw_quaternion
from worlds import figures
from worlds.things import (
    Cuboid,
    Fiducial,
    Image,
    Mesh,
    Motion,
    Plate,
    Shape,
    Sphere,
    Terrain,
    Thing,
)
from worlds.world import Ground, Light, World

LENS = lens(320, 240)
SKY = (230, 190, 150)


def picture(world: World, pose: Pose, camera: Intrinsics = LENS) -> NDArray[np.uint8]:
    return Raster(world, {}).render(pose, camera, 0.0, {})


def projected(points: NDArray[np.float64], pose: Pose, camera: Intrinsics) -> NDArray[np.float64]:
    seen = (points - np.array(pose[0])) @ rotation_matrix(pose[1])
    x, y = seen[:, 0] / seen[:, 2], seen[:, 1] / seen[:, 2]
    return np.stack([camera.fx * x + camera.cx, camera.fy * y + camera.cy], 1)


def detector(name: int = cv2.aruco.DICT_4X4_50) -> cv2.aruco.ArucoDetector:
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    settings.cornerRefinementWinSize = 3
    return cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(name), settings)


def edge(image: NDArray[np.float32], start: Float64s, end: Float64s) -> tuple[Float64s, Float64s]:
    """The line along a black edge near a segment: a normal, and two places on it, to subpixels.

    On lines across the edge, the middle of the rise from dark to bright (its weighted mean).
    """
    along = (end - start) / np.linalg.norm(end - start)
    normal = np.array([-along[1], along[0]])
    shares, across = np.linspace(0.15, 0.85, 60), np.arange(-3, 3.01, 0.1)
    places = start + (end - start) * shares[:, None]
    grid = (places[:, None] + across[None, :, None] * normal).astype(np.float32)
    rise = np.abs(np.diff(cv2.remap(image, grid, None, cv2.INTER_LINEAR), axis=1))
    middles = (rise * (across[1:] - 0.05)).sum(1) / rise.sum(1)
    slope, offset = np.polyfit(shares, middles, 1)
    ends = [start + normal * offset, end + normal * (offset + slope)]
    return np.array(ends[0]), np.array(ends[1])


def crossing(one: tuple[Float64s, Float64s], other: tuple[Float64s, Float64s]) -> Float64s:
    a, b = np.append(one[0], 1.0), np.append(one[1], 1.0)
    c, d = np.append(other[0], 1.0), np.append(other[1], 1.0)
    x, y, w = np.cross(np.cross(a, b), np.cross(c, d))
    return np.array([x / w, y / w])


def corner_errors(seed: int, count: int, camera: Intrinsics) -> list[float]:
    """Between the corners of a marker as drawn and as projected, pixels, over random poses.

    Each is found in the picture where lines along the black square's edges meet: the detector's
    own corners lie 0.15 pixels inside, also on pictures that are averaged from much finer ones.
    """
    draw, size, errors, detected = Random(seed), 0.5, [], 0
    eye = look((0.0, 0.0, 3.0), (0.001, 0.0, 0.0))
    for _ in range(count):
        axis = draw.uniform(-1, 1), draw.uniform(-1, 1)
        length = (axis[0] ** 2 + axis[1] ** 2) ** 0.5 or 1.0
        lean = turned((axis[0] / length, axis[1] / length, 0.0), radians(draw.uniform(0, 45)))
        attitude = product(lean, yaw_quaternion(draw.uniform(-pi, pi)))
        at = draw.uniform(-0.3, 0.3), draw.uniform(-0.12, 0.12), draw.uniform(0.4, 1.2)
        image = picture(world_of(marker(7, at, size, attitude)), eye, camera)
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        corners, ids, _ = detector().detectMarkers(grey)
        local = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * size / 2
        want = projected(local @ rotation_matrix(attitude).T + at, eye, camera)
        if ids is not None and ids.ravel().tolist() == [7]:
            detected += 1
            assert np.abs(corners[0].reshape(4, 2) - want).max() < 1.0
        exact = grey.astype(np.float32)
        edges = [edge(exact, want[k], want[(k + 1) % 4]) for k in range(4)]
        drawn = [crossing(edges[k - 1], edges[k]) for k in range(4)]
        errors.extend(np.linalg.norm(np.array(drawn) - want, axis=1).tolist())
    assert detected >= 0.99 * count
    return errors


def test_marker_corners_lie_where_they_are_projected() -> None:
    errors = corner_errors(1, 25, lens(640, 480))
    assert np.median(errors) < 0.02
    assert max(errors) < 0.3


@pytest.mark.slow
def test_marker_corners_in_many_poses() -> None:
    assert max(corner_errors(2, 500, lens(640, 480))) < 0.3


def test_edges_of_solids_lie_where_they_are_projected() -> None:
    draw, eye, camera = Random(4), look((0.0, 0.0, 4.0), (0.001, 0.0, 0.0)), lens(640, 480)
    off = []
    for _ in range(20):
        attitude = yaw_quaternion(draw.uniform(0.05, pi / 2 - 0.05))
        at = draw.uniform(-0.2, 0.2), draw.uniform(-0.2, 0.2), 0.5
        box = thing_of("box", Cuboid(Point(0.8, 0.8, 1.0)), at, attitude, (255, 255, 255))
        dark = Ground((0, 0, 0), 10.0, tile=1.0)
        image = picture(world_of(box, ground=dark), eye, camera)
        top = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * 0.4
        corners = projected(top @ rotation_matrix(attitude).T + at + (0, 0, 0.5), eye, camera)
        white = cv2.compare(image[..., 1], 200, cv2.CMP_GT)
        # All four sides are seen from above as one white outline, which the top's corners span.
        outline = cv2.findContours(white, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0][0]
        hull = outline.reshape(-1, 2).astype(np.float32)
        inside = [cv2.pointPolygonTest(corners.astype(np.float32), p, True) for p in hull.tolist()]
        off.append(float(np.mean(inside)))
    # Pixels on the rim lie between 0 and 1 pixel inside the true edge.
    assert 0.2 < np.mean(off) < 0.6


def test_a_textured_face_shows_its_marker_upright_on_every_side() -> None:
    cube = thing_of(
        "cube", Cuboid(Point(1, 1, 1)), (0, 0, 1.5), texture=Fiducial("APRILTAG_36h11", 5)
    )
    world = world_of(cube)
    find = detector(cv2.aruco.DICT_APRILTAG_36h11)
    raster = Raster(world, {})
    for side in ((-4, 0, 1.5), (4, 0, 1.5), (0, -4, 1.5), (0, 4, 1.5), (0.001, 0, 5.0)):
        image = raster.render(look(side, (0, 0, 1.5)), lens(640, 480), 0.0, {})
        corners, ids, _ = find.detectMarkers(image)
        assert ids is not None and ids.ravel().tolist() == [5], side
        first, second, third = corners[0].reshape(4, 2)[:3]
        if side[2] == 1.5:
            # Its first corner is the upper left one, and it is not mirrored.
            assert first[0] < second[0] - 20 and abs(first[1] - second[1]) < 2
            assert third[1] > second[1] + 20


@needs_pybullet
def test_markers_are_detected_at_least_as_far_as_in_the_reference() -> None:
    def seen(renderer: Raster | TinyRenderer, height: float) -> int:
        found = 0
        for k in range(8):
            eye = look((0.3 * k - 1.0, 0.2 * k, height), (0.1 * k, 0.0, 0.0), (0.3, 1.0, 0.1 * k))
            image = renderer.render(eye, LENS, 0.0, {})
            ids = detector().detectMarkers(image)[1]
            found += ids is not None and ids.ravel().tolist() == [3]
        return found

    world = world_of(marker(3, (0, 0, 0.01), 0.5), ground=Ground((128, 128, 128), 40.0))
    raster, reference = Raster(world, {}), TinyRenderer(world, {})
    heights = (2.0, 4.0, 6.0, 8.0, 9.0, 10.0, 11.0)
    try:
        theirs = [seen(reference, height) for height in heights]
    finally:
        reference.close()
    ours = [seen(raster, height) for height in heights]
    assert sum(ours) >= sum(theirs)
    assert ours[:4] == [8, 8, 8, 8]


def changes(world: World) -> Float64s:
    """Mean change of each row between two pictures 1 cm apart, grey levels, looking far."""
    raster = Raster(world, {})
    first, second = (
        raster.render(look((x, 0, 2), (x + 10, 0, 2)), LENS, 0.0, {}).astype(float)
        for x in (0.0, 0.01)
    )
    return np.asarray(np.abs(second - first).mean((1, 2)))


def test_nothing_sparkles_towards_the_horizon(tmp_path: Path) -> None:
    board = np.kron(np.indices((8, 8)).sum(0) % 2, np.ones((32, 32))) * 255
    path = tmp_path / "checked.png"
    cv2.imwrite(str(path), cv2.cvtColor(board.astype(np.uint8), cv2.COLOR_GRAY2BGR))
    checked = world_of(ground=Ground((128, 128, 128), 400.0, texture=path, tile=2.0))
    # Beyond 14 m a square of 25 cm is less than a pixel high; averaging over each pixel's area
    # gives up to 3.8 there, looking at its centre alone up to 90.
    assert changes(checked)[119:152].max() < 4.0
    assert changes(world_of(ground=GREEN)).max() < 1.5


def test_the_horizon_in_any_attitude() -> None:
    draw, raster = Random(8), Raster(world_of(ground=Ground((0, 0, 0), 4000.0)), {})
    for _ in range(40):
        attitude = random_attitude(draw)
        image = raster.render((Point(0.0, 0.0, 2.0), attitude), LENS, 0.0, {})
        y, x = np.mgrid[:240, :320]
        rays = np.stack([(x - LENS.cx) / LENS.fx, (y - LENS.cy) / LENS.fy, np.ones((240, 320))], -1)
        up = rays @ rotation_matrix(attitude)[2]
        sky = (image == SKY).all(2)
        assert (sky == (up >= 0))[np.abs(up) > 1e-9].all()


@pytest.mark.parametrize(
    ("pose", "sky"),
    [
        (look((0, 0, 3), (0, 0, 9)), True),
        (look((0, 0, 3), (0, 0, 0)), False),
        (look((0, 0, -1), (0, 0, -9)), True),
        (look((0, 0, -1), (5, 0, 0)), True),
        (look((0, 0, 0.0), (0, 0, -1)), True),
    ],
)
def test_straight_up_and_down_and_below_the_ground(pose: Pose, sky: bool) -> None:
    image = picture(world_of(), pose)
    assert (image == SKY).all(2).all() == sky
    assert (image == SKY).all(2).any() == sky


def test_what_reaches_behind_the_camera_is_cut() -> None:
    wall = thing_of("wall", Cuboid(Point(100, 0.2, 2)), (0, 1.0, 1.0), color=(250, 0, 0))
    image = picture(world_of(wall), look((0, 0, 1), (10, 0, 1)))
    # Left of the middle the wall runs from overhead to the horizon; right of it there is none.
    wall_seen = (image == (0, 0, 250)).all(2)
    assert wall_seen[:, 0].all() and wall_seen[118:122, 150].all() and not wall_seen[:, 170:].any()


def test_flat_faces_show_their_colour_and_others_less() -> None:
    box = thing_of("box", Cuboid(Point(1, 1, 1)), (0, 0, 0.5), color=(200, 100, 50))
    light = Light(sun=(0, 0, 1), ambient=0.5)
    above = picture(world_of(box, light=light), look((0, 0, 4), (0, 0, 0)))
    beside = picture(world_of(box, light=light), look((-4, 0, 0.5), (0, 0, 0.5)))
    assert above[120, 160].tolist() == [50, 100, 200]
    assert beside[120, 160].tolist() == [25, 50, 100]


def test_plates_are_seen_from_above_only() -> None:
    world = world_of(thing_of("plate", Plate(1, 1), (0, 0, 2), color=(250, 0, 0)))
    red = [0, 0, 250]
    assert picture(world, look((0, 0, 4), (0, 0, 0)))[120, 160].tolist() == red
    assert picture(world, look((0, 0, 0.5), (0, 0, 4)))[120, 160].tolist() == list(SKY)


def _two_balls() -> Mesh:
    one = sphere_mesh(1.0, 16)
    vertices = np.concatenate([one.vertices, one.vertices + np.array([0.0, 2.5, 0.0])])
    return Mesh(vertices, np.concatenate([one.faces, one.faces + len(one.vertices)]))


@needs_pybullet
@pytest.mark.parametrize("shape", [Sphere(1.0), _two_balls()])
def test_of_what_the_ground_cuts_the_upper_part_is_seen(shape: Shape) -> None:
    pose = look((-6.0, 0.0, 3.0), (6.0, 0.0, 0.0))
    for height in (1.0, 0.2, -0.5, -0.9, -1.2):
        world = world_of(thing_of("ball", shape, (6.0, 0.0, height)))
        raster, reference = Raster(world, {}), TinyRenderer(world, {})
        try:
            image = raster.render(pose, LENS, 0.0, {})
            _, bodies = reference.look(pose, LENS, 0.0, {})
            (body,) = reference.names
        finally:
            reference.close()
        mine, others = (image == (30, 30, 200)).all(2), bodies == body
        assert (mine & others).sum() >= 0.94 * (mine | others).sum()
        assert mine.any() == (height > -1)


def test_moving_things_and_vehicles_are_where_they_are() -> None:
    shape = thing_of("car", Cuboid(Point(1, 1, 1)), (0, 0, 0.5), color=(250, 0, 0))
    path = Motion((Point(0, 0, 0.5), Point(10, 0, 0.5)), 1.0, loop=False, turns=True)
    car = Thing("car", "car", shape.at, shape.attitude, shape.parts, motion=path)
    drone = thing_of("car", Cuboid(Point(1, 1, 1)), (0, 0, 0), color=(0, 0, 250))
    raster = Raster(world_of(car), {"drone": drone})
    flying = {"drone": (Point(6.0, 0.0, 4.0), car.attitude)}
    for time, poses in ((0.0, {}), (6.0, {}), (0.0, flying), (6.0, flying)):
        image = raster.render(look((6, 0, 9), (6, 0, 0)), LENS, time, poses)
        middle = image[120, 160].tolist()
        if poses:
            assert middle == [250, 0, 0]
        elif time:
            assert middle == [0, 0, 250]
        else:
            assert middle[1] > 100


def test_shadows_fall_away_from_the_sun() -> None:
    box = thing_of("box", Cuboid(Point(1, 1, 1)), (0, 0, 0.5), color=(200, 100, 50))
    world = world_of(box, ground=Ground((100, 100, 100), 50.0), light=Light((1, 0, 1), 0.5))
    eye = look((0, 0, 8), (0, 0, 0), (0, 1, 0))
    lit = Raster(world, {}).render(eye, LENS, 0.0, {})[..., 1].astype(int)
    dark = Raster(world, {}, True).render(eye, LENS, 0.0, {})[..., 1].astype(int)
    share = 0.5 / (0.5 + 0.5 * 0.5**0.5)
    # The shadow reaches one metre west of the box, which is 35 pixels on the ground.
    shaded = (dark < lit * (share + 0.05)) & (dark > lit * (share - 0.05))
    assert shaded[120, 110:138].all() and not shaded[120, :102].any()
    assert not shaded[:, 180:].any() and not shaded[:100].any()


def test_hills_hide_what_is_behind_them_and_bury_what_is_in_them() -> None:
    heights = tuple(
        tuple(3.0 if 3 <= row <= 5 and 3 <= column <= 5 else 0.0 for column in range(9))
        for row in range(9)
    )
    ground = Ground((0, 200, 0), 100.0, terrain=Terrain(heights, 16.0))
    behind = thing_of("behind", Cuboid(Point(1, 1, 1)), (6.5, 0, 0.5))
    inside = thing_of("inside", Cuboid(Point(1, 1, 1)), (0, 0, 1.0))
    on_top = thing_of("on_top", Cuboid(Point(1, 1, 1)), (0, 0, 3.5), color=(0, 0, 250))
    image = picture(world_of(behind, inside, on_top, ground=ground), look((-9, 0, 2), (0, 0, 2)))
    assert not (image == (30, 30, 200)).all(2).any()
    assert (image == (250, 0, 0)).all(2).sum() > 200


@needs_pybullet
def test_opengl_shows_what_lies_close_to_other_things() -> None:
    """Windows lie 1 cm before their walls, markers 1 cm above the ground."""
    pane = thing_of("pane", Plate(1.0, 1.0), (29.99, 0.0, 2.0), figures.standing(pi), (0, 0, 200))
    mat = thing_of("mat", Plate(2.0, 2.0), (20.0, -5.0, 0.01), color=(255, 255, 255))
    wall = thing_of("wall", Cuboid(Point(1.0, 8.0, 4.0)), (30.5, 0.0, 2.0))
    world = world_of(pane, mat, wall)
    try:
        opengl = EglRenderer(world, {})
    except UserError as error:
        pytest.skip(str(error))
    raster = Raster(world, {})
    try:
        for height in (2.0, 4.0, 9.0):
            pose = look((0.0, 0.0, height), (20.0, 0.0, 1.0))
            image = raster.render(pose, LENS, 0.0, {})
            _, bodies = opengl.look(pose, LENS, 0.0, {})
            names = {name: body for body, name in opengl.names.items()}
            for name, color in (("pane", (200, 0, 0)), ("mat", (255, 255, 255))):
                mine, others = (image == color).all(2), bodies == names[name]
                assert (mine & others).sum() > 0.8 * (mine | others).sum() > 0
    finally:
        opengl.close()


@pytest.mark.parametrize("reference", [TinyRenderer, EglRenderer])
@pytest.mark.parametrize("size", [20.0, 400.0])
def test_what_lies_on_the_ground_is_seen_wherever_it_lies(
    reference: type[TinyRenderer | EglRenderer], size: float
) -> None:
    """West and east of the origin, in the very plane of the ground, from near and from far."""
    white = (255, 255, 255)
    spots = [(-0.1, 0.0), (-3.0, 4.0), (-9.0, -9.0), (0.0, 8.0), (4.0, -4.0), (9.0, 9.0)]
    mats = [
        thing_of(f"mat{number}", Plate(0.6, 0.6), (x, y, 0.0), color=white)
        for number, (x, y) in enumerate(spots)
    ]
    world = world_of(*mats, ground=replace(GREEN, size=size))
    try:
        other = reference(world, {})
    except UserError as error:
        pytest.skip(str(error))
    raster = Raster(world, {})
    try:
        for (x, y), height, aside in combined(spots, (0.8, 6.0, 60.0), (0.0, 0.5)):
            pose = look((x, y + aside * height, height), (x, y, 0.0), (1.0, 0.0, 0.0))
            ours, theirs = (each.render(pose, LENS, 0.0, {}) for each in (raster, other))
            mine, others = (ours > 200).all(2), (theirs > 200).all(2)
            # An outline's pixels may differ: of the smallest mats these are many.
            assert (mine & others).sum() > 0.7 * (mine | others).sum() > 0, (x, y, height, aside)
    finally:
        other.close()


@pytest.mark.parametrize("renderer", [Raster, pytest.param(TinyRenderer, marks=needs_pybullet)])
def test_roads_lead_over_hills(renderer: type[Raster | TinyRenderer]) -> None:
    """Seen from above, what is painted is where it would be without hills."""
    heights = tuple(
        tuple(2.0 if 0 < row < 4 and 0 < column < 4 else 0.0 for column in range(5))
        for row in range(5)
    )
    high = replace(ROAD, terrain=Terrain(heights, 40.0))
    pose = look((0.0, 0.0, 202.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    camera = lens(320, 240, 8)
    shown = []
    for ground, at in ((high, pose), (ROAD, (pose[0].minus(Point(0.0, 0.0, 2.0)), pose[1]))):
        world = world_of(ground=ground)
        drawn = renderer(world, {})
        try:
            image = drawn.render(at, camera, 0.0, {}).astype(int)
        finally:
            drawn.close()
        shown.append((image.max(2) - image.min(2))[60:180, 80:240] < 30)
    on_hills, flat = shown
    assert (on_hills & flat).sum() > 0.9 * (on_hills | flat).sum() > 900


def test_equal_arguments_give_equal_pictures() -> None:
    one, other = Raster(town(), {}), Raster(town(), {})
    poses = [look((-12, 0, 3), (0, 0, 1)), look((0, 0, 6), (0, 0, 0))]
    first = [one.render(pose, LENS, 0.0, {}) for pose in poses]
    # In another order: what is kept of one picture shows in no other.
    second = [other.render(pose, LENS, 0.0, {}) for pose in reversed(poses)]
    assert all((a == b).all() for a, b in zip(first, reversed(second), strict=True))


def test_a_broken_picture_is_told(tmp_path: Path) -> None:
    path = tmp_path / "broken.png"
    path.write_bytes(b"nothing")
    with pytest.raises(UserError) as error:
        Raster(world_of(thing_of("sign", Plate(1, 1), (0, 0, 1), texture=Image(path))), {})
    assert error.value.code == "bad-picture"
