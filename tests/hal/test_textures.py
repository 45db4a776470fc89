"""Textures as pixels: their coarser versions, files, markers and boards."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from hal.scene.textures import Bitmap, Mipmap, load_image, mipmap_of, uniform_image
from vencejo.errors import UserError
from worlds.things import Charuco, Fiducial, Image, Roundel


def shape(mipmap: Mipmap, step: float) -> tuple[int, ...]:
    return mipmap.level(step).shape


@pytest.mark.parametrize(
    ("step", "expected"),
    [
        # A texel of the finest version is an eighth of the width.
        (0.0, (2, 8, 4)),
        (1 / 8, (2, 8, 4)),
        (1.4 / 8, (2, 8, 4)),
        (1.5 / 8, (1, 4, 4)),
        (2 / 8, (1, 4, 4)),
        (4 / 8, (1, 2, 4)),
        (1.0, (1, 1, 4)),
        (99.0, (1, 1, 4)),
    ],
)
def test_the_version_whose_texels_are_nearest_in_size(
    step: float, expected: tuple[int, ...]
) -> None:
    wide = Mipmap(np.zeros((2, 8, 4), np.uint8))
    assert shape(wide, step) == expected
    # Whatever was asked for before.
    wide.level(99.0)
    assert shape(wide, step) == expected


def test_a_high_image_is_halved_down_to_one_pixel_too() -> None:
    high = Mipmap(np.zeros((9, 2, 4), np.uint8))
    assert [shape(high, step)[:2] for step in (0.5, 1.0, 2.0, 4.0, 8.0)] == [
        (9, 2),
        (4, 1),
        (2, 1),
        (1, 1),
        (1, 1),
    ]


def test_coarser_texels_are_the_mean_of_finer_ones() -> None:
    pixels = np.arange(4 * 4 * 4, dtype=np.uint8).reshape(4, 4, 4)
    mipmap = Mipmap(pixels)
    half = pixels.reshape(2, 2, 2, 2, 4).mean(axis=(1, 3))
    assert np.abs(mipmap.level(0.5) - half).max() <= 0.5
    assert np.abs(mipmap.level(1.0)[0, 0] - pixels.reshape(-1, 4).mean(0)).max() <= 1.0


def test_a_file_is_read_with_its_colours_and_made_opaque(tmp_path: Path) -> None:
    path = tmp_path / "flag.png"
    image = np.zeros((3, 5, 3), np.uint8)
    image[0, :] = (255, 0, 0)
    cv2.imwrite(str(path), image)
    pixels = mipmap_of(Image(path)).level(0.0)
    assert pixels.shape == (3, 5, 4)
    assert pixels[0, 4].tolist() == [255, 0, 0, 255]
    assert pixels[2, 0].tolist() == [0, 0, 0, 255]


@pytest.mark.parametrize(
    ("size", "expected"),
    [((2048, 100), (100, 2048)), ((4096, 100), (50, 2048)), ((64, 3072), (2048, 43))],
)
def test_a_very_large_file_is_scaled_down(
    size: tuple[int, int], expected: tuple[int, int], tmp_path: Path
) -> None:
    path = tmp_path / "large.png"
    cv2.imwrite(str(path), np.zeros((size[1], size[0], 3), np.uint8))
    assert load_image(path).level(0.0).shape == (*expected, 4)


def test_what_is_no_picture(tmp_path: Path) -> None:
    path = tmp_path / "text.png"
    path.write_text("no picture")
    with pytest.raises(UserError) as refused:
        load_image(path)
    assert (refused.value.code, str(refused.value.faults[0].where)) == ("bad-picture", str(path))


def test_pixels_that_are_known_already_are_taken_as_they_are() -> None:
    pixels = uniform_image(3, 2, (1, 2, 3, 4))
    assert pixels.shape == (2, 3, 4)
    assert (pixels == (1, 2, 3, 4)).all()
    assert mipmap_of(Bitmap(pixels)).level(0.0) is pixels


@pytest.mark.parametrize(
    ("dictionary", "id_", "modules"), [("4X4_50", 7, 6), ("APRILTAG_36h11", 9, 8)]
)
def test_a_marker_is_found_with_its_number(dictionary: str, id_: int, modules: int) -> None:
    pixels = mipmap_of(Fiducial(dictionary, id_)).level(0.0)
    # Its modules and a white one on each side.
    side = (modules + 2) * 64
    assert pixels.shape == (side, side, 4) and (pixels[..., 3] == 255).all()
    assert (pixels[:64] == 255).all() and (pixels[:, -64:] == 255).all()
    assert (pixels[64:128, 64:-64, :3] == 0).all()
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{dictionary}"))
    corners, found, _ = cv2.aruco.ArucoDetector(known).detectMarkers(
        np.ascontiguousarray(pixels[..., :3])
    )
    assert found is not None and found.reshape(-1).tolist() == [id_]
    # Upright: its first corner is the upper left one.
    assert corners[0][0, 0] == pytest.approx((64, 64), abs=2)


def test_a_marker_inside_another_one_is_in_its_middle() -> None:
    pixels = mipmap_of(Fiducial("6X6_250", 5, Fiducial("4X4_50", 9), 0.256)).level(0.0)
    middles = []
    for dictionary, id_, side in (("6X6_250", 5, 512), ("4X4_50", 9, 0.256 * 640 * 6 / 8)):
        known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{dictionary}"))
        settings = cv2.aruco.DetectorParameters()
        settings.errorCorrectionRate = 1.0
        corners, found, _ = cv2.aruco.ArucoDetector(known, settings).detectMarkers(
            np.ascontiguousarray(pixels[..., :3])
        )
        assert found is not None and found.reshape(-1).tolist() == [id_]
        assert np.ptp(corners[0][0, :, 0]) == pytest.approx(side, abs=3)
        middles.append(corners[0][0].mean(axis=0))
    assert middles[0] == pytest.approx(middles[1], abs=1)


@pytest.mark.parametrize(
    ("texture", "code", "hint"),
    [
        (Fiducial("4X4_50", 50), "no-such-marker", "it has 0 to 49"),
        (Fiducial("4X4_50", -1), "no-such-marker", "it has 0 to 49"),
        (Fiducial("4X4_51", 0), "unknown-dictionary", None),
        (Charuco("4X4_51", 3, 2, 0.5), "unknown-dictionary", None),
    ],
)
def test_markers_that_are_none(texture: Fiducial | Charuco, code: str, hint: str | None) -> None:
    with pytest.raises(UserError) as refused:
        mipmap_of(texture)
    (fault,) = refused.value.faults
    assert (fault.code, fault.hint) == (code, hint)


def test_a_board_has_its_columns_rows_and_corners() -> None:
    pixels = mipmap_of(Charuco("4X4_50", 5, 3, 0.7)).level(0.0)
    assert pixels.shape == (3 * 512, 5 * 512, 4)
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((5, 3), 1.0, 0.7, known)
    white = cv2.copyMakeBorder(
        np.ascontiguousarray(pixels[..., :3]), *[64] * 4, cv2.BORDER_CONSTANT, value=(255,) * 3
    )
    corners, ids, _, markers = cv2.aruco.CharucoDetector(board).detectBoard(white)
    assert ids.reshape(-1).tolist() == [*range(8)]
    assert markers.size == 7
    assert corners.reshape(-1, 2)[0] == pytest.approx((64 + 511.5, 64 + 511.5), abs=2)


@pytest.mark.parametrize(
    ("right", "up", "grey"),
    [
        (0.0, 0.0, 255),  # the rectangle in the disc
        (0.08, 0.23, 255),
        (0.12, 0.0, 0),  # the disc
        (0.0, 0.27, 0),
        (0.0, -0.48, 0),
        (-0.48, 0.0, 0),
        (0.52, 0.0, 255),
        (0.65, 0.58, 0),  # the line
        (0.75, -0.58, 0),
        (0.7, 0.62, 255),
        (0.79, 0.0, 255),
        (-0.7, 0.0, 255),  # none at the left
    ],
)
def test_a_roundel_in_diameters_of_its_disc(right: float, up: float, grey: int) -> None:
    pixels = mipmap_of(Roundel()).level(0.0)
    side = len(pixels)
    row, column = round(side * (0.5 - up / 1.8)), round(side * (0.5 + right / 1.8))
    assert pixels[row, column].tolist() == [grey, grey, grey, 255]
