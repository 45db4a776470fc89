"""Fiducial markers in rendered images."""

from __future__ import annotations

from collections.abc import Mapping
from random import Random

import cv2
import numpy as np
import pytest

from behaviors.perception.fiducials import REFINEMENTS, FiducialDetector
from hal.raster.renderer import Raster
from hal.sim.sensors.camera_spec import CameraSpec
from tests.behaviors.perception.markers import (
    DOWN,
    above,
    corners_of,
    marker_of,
    photograph,
    pixels_of,
)
from tests.hal.scenes import ROAD, world_of
from vencejo.geometry import Point, yaw_quaternion

ORIGIN = Point(0.0, 0.0, 0.0)


@pytest.mark.parametrize("dictionary", ["4X4_50", "DICT_6X6_250", "APRILTAG_36h11"])
def test_a_marker_is_found_to_a_pixel(dictionary: str) -> None:
    """From one to five metres, tilted and turned, in noise."""
    name = dictionary.removeprefix("DICT_")
    raster = Raster(world_of(marker_of(name, 7, ORIGIN, 0.5), ground=ROAD), {}, False)
    camera = CameraSpec(noise=3.0)
    finder = FiducialDetector(dictionary, ids=(2, 7, 12))
    draw = Random(1)
    errors = []
    for number in range(12):
        pose = above(draw, draw.uniform(1.5, 5.0), spread=0.1)
        frame = photograph(raster, pose, camera, number)
        found = finder.detect(frame.image).found
        assert [each.id for each in found] == [7]
        want = pixels_of(corners_of(0.5, ORIGIN), pose, camera.intrinsics)
        errors.append(float(np.abs(found[0].corners - want).max()))
        centre = pixels_of(np.array([ORIGIN]), pose, camera.intrinsics)[0]
        assert found[0].centre == pytest.approx(tuple(centre), abs=0.5)
        assert found[0].side == pytest.approx(camera.intrinsics.fx * 0.5 / pose[0].z, rel=0.1)
    assert np.median(errors) < 0.6 and max(errors) < 2.0


def test_a_marker_that_the_image_cuts_off_is_not_found_in_a_wrong_place() -> None:
    raster = Raster(world_of(marker_of("4X4_50", 3, ORIGIN, 0.5), ground=ROAD), {}, False)
    camera = CameraSpec()
    finder = FiducialDetector("4X4_50", ids=(3,))
    draw, cut = Random(3), 0
    for number in range(80):
        pose = above(draw, draw.uniform(0.5, 1.2), spread=0.5, tilt=6.0)
        want = pixels_of(corners_of(0.5, ORIGIN), pose, camera.intrinsics)
        cut += bool((want < 0).any() or (want > (319, 239)).any())
        for found in finder.detect(photograph(raster, pose, camera, number).image).found:
            assert np.abs(found.corners - want).max() < 1.0
    assert cut > 40


def test_only_the_ids_wanted_are_found_and_the_largest_is_first() -> None:
    things = [
        marker_of("4X4_50", number, Point(0.8 * k, 0.0, 0.0), 0.3 + 0.1 * k)
        for k, number in enumerate((5, 1, 9))
    ]
    raster = Raster(world_of(*things), {}, False)
    image = photograph(raster, (Point(0.8, 0.0, 3.0), DOWN), CameraSpec())
    both = FiducialDetector("4X4_50", ids=(9, 5, 9)).detect(image.image)
    assert [each.id for each in both.found] == [9, 5]
    centres = [square.mean(axis=0) for square in both.rejected]
    assert any(np.abs(centre - (159.5, 119.5)).max() < 5 for centre in centres)
    assert [each.id for each in FiducialDetector("4X4_50").detect(image.image).found] == [9, 1, 5]


def test_of_nested_markers_each_has_its_own_detector() -> None:
    """With one dictionary OpenCV keeps one of two markers that lie in each other; with two, both
    are found.
    """
    things = (
        marker_of("6X6_250", 5, ORIGIN, 0.5),
        marker_of("4X4_50", 9, Point(0.0, 0.0, 0.001), 0.12, yaw_quaternion(0.0)),
    )
    raster = Raster(world_of(*things, ground=ROAD), {}, False)
    outer = FiducialDetector("6X6_250", ids=(5,), parameters={"errorCorrectionRate": 1.0})
    inner = FiducialDetector("4X4_50", ids=(9,), parameters={"errorCorrectionRate": 1.0})
    draw = Random(2)
    for number in range(12):
        image = photograph(raster, above(draw, 1.5, 0.05), CameraSpec(noise=3.0), number).image
        assert [each.id for each in outer.detect(image).found] == [5]
        assert [each.id for each in inner.detect(image).found] == [9]


@pytest.mark.parametrize("refinement", REFINEMENTS)
@pytest.mark.parametrize("shape", [(16, 16), (1, 1), (240, 320), (17, 300)])
def test_nothing_is_found_in_pictures_of_nothing(refinement: str, shape: tuple[int, int]) -> None:
    settings = {"cornerRefinementMethod": refinement}
    finder = FiducialDetector("APRILTAG_36h11", range(30), settings)
    noise = np.random.default_rng(0).integers(0, 256, (*shape, 3), dtype=np.uint8)
    flat = [np.full((*shape, 3), grey, np.uint8) for grey in (0, 255, 80)]
    for image in (*flat, flat[0][..., 0], noise, np.rot90(noise)):
        image.flags.writeable = False
        assert finder.detect(image).found == ()


def test_a_turned_picture_has_the_corners_turned() -> None:
    raster = Raster(world_of(marker_of("4X4_50", 3, ORIGIN, 0.5)), {}, False)
    image = photograph(raster, above(Random(5), 2.0), CameraSpec()).image
    finder = FiducialDetector("4X4_50", ids=(3,))
    (upright,), (turned,) = (finder.detect(each).found for each in (image, np.rot90(image)))
    x, y = upright.corners.T
    assert turned.corners == pytest.approx(np.column_stack([y, 319 - x]), abs=0.3)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"cornerRefinementMetod": "subpix"}, "no parameter 'cornerRefinementMetod' .*Method'"),
        ({"cornerRefinementMethod": "best"}, "is one of none, subpix, .*, not 'best'"),
        ({"cornerRefinementMethod": 9}, "not 9"),
        ({"adaptiveThreshWinSizeMin": 1}, "OpenCV refuses these parameters"),
        ({"adaptiveThreshWinSizeMin": 3.5}, "is a whole number, not 3.5"),
        ({"adaptiveThreshWinSizeMax": float("inf")}, "is a whole number, not inf"),
        ({"errorCorrectionRate": float("nan")}, "is a number, not nan"),
        ({"errorCorrectionRate": "high"}, "is a number, not 'high'"),
        ({"useAruco3Detection": 1}, "is true or false, not 1"),
    ],
)
def test_parameters_that_cannot_be_are_told(given: Mapping[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        FiducialDetector("4X4_50", parameters=given)


def test_every_parameter_of_opencv_can_be_set() -> None:
    settings = cv2.aruco.DetectorParameters()
    names = [name for name in dir(settings) if not name.startswith("_")]
    values = {name: getattr(settings, name) for name in names}
    given = {name: value for name, value in values.items() if not callable(value)}
    given["cornerRefinementMethod"] = "apriltag"
    assert len(given) > 30
    FiducialDetector("4X4_50", parameters=given)


@pytest.mark.parametrize(
    ("dictionary", "ids", "message"),
    [
        ("4x4_50", None, r"no marker dictionary is called '4x4_50' \(did you mean '4X4_50'"),
        ("4X4_50", (50,), "4X4_50 has the markers 0 to 49, not 50"),
        ("4X4_50", (-1,), "not -1"),
        ("4X4_50", (), "no id to look for"),
    ],
)
def test_markers_that_are_not_there_are_told(
    dictionary: str, ids: tuple[int, ...] | None, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        FiducialDetector(dictionary, ids)
