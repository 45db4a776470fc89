"""`drone-cli worlds NAME --render` and `--gui`, and the run's options for cameras."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from pathlib import Path
from unittest.mock import Mock

import cv2
import pytest

from cli.look import LENS, render, view
from cli.options import cameras
from hal.engines import is_installed
from hal.scene.transforms import rotation_matrix
from tests.cli.run_cli import run_cli
from vencejo.geometry import Point
from worlds import find_world, outlines_of, pose_at, world_families, world_names
from worlds.solids import top_of


@pytest.mark.parametrize("name", world_names())
def test_every_shipped_world_is_rendered(name: str, tmp_path: Path) -> None:
    path = tmp_path / "world.png"
    result = run_cli("worlds", name, "--render", str(path))
    assert (result.code, result.out.strip()) == (0, str(path))
    image = cv2.imread(str(path))
    assert image is not None and image.shape == (480, 640, 3)
    assert image.std() > 2


def test_from_a_place_of_ones_own() -> None:
    world = find_world("yard")
    at, attitude = view(world, "front", (1.0, 2.0, 3.0, 0.0))
    assert at == (1.0, 2.0, 3.0)
    assert rotation_matrix(attitude)[:, 2].tolist() == pytest.approx([1, 0, 0])
    at, attitude = view(world, "down", None)
    assert at == (0.0, 0.0, 10.0)
    assert rotation_matrix(attitude)[:, 2].tolist() == pytest.approx([0, 0, -1])
    _, attitude = view(world, "top", None)
    # North is up.
    assert rotation_matrix(attitude)[:, 1].tolist() == pytest.approx([0, -1, 0])


def test_all_of_a_world_is_in_the_picture() -> None:
    world = find_world("roads:17")
    for camera in ("front", "top"):
        at, attitude = view(world, camera, None)
        for spot in [*world.places.values(), *(Point(*p, 0.0) for p in world.roads[0].points)]:
            x, y, depth = rotation_matrix(attitude).T @ spot.minus(at)
            across, down = LENS.fx * x / depth + LENS.cx, LENS.fy * y / depth + LENS.cy
            assert depth > 0 and -1 < across < LENS.width and -1 < down < LENS.height


GENERATED = [f"{family}:{number}" for family in world_families() for number in (1, 7, 17)]


@pytest.mark.parametrize("name", [*world_names(), *GENERATED])
def test_every_thing_is_in_the_picture_from_above(name: str) -> None:
    world = find_world(name)
    at, attitude = view(world, "top", None)
    axes = rotation_matrix(attitude).T
    for thing in world.things:
        for time in (0.0, 3.0, 11.0, 30.0):
            place = pose_at(thing, time)[0]
            heights = [top_of(replace(thing, motion=None, at=place)), place.z]
            for outline in outlines_of(thing, time):
                for x, y in outline:
                    for z in filter(isfinite, heights):
                        right, down, depth = axes @ Point(x, y, z).minus(at)
                        across = LENS.fx * right / depth + LENS.cx
                        along = LENS.fy * down / depth + LENS.cy
                        assert 0 <= across <= LENS.width - 1, thing.name
                        assert 0 <= along <= LENS.height - 1, thing.name


def test_a_tower_beside_nothing_is_whole_from_above(tmp_path: Path) -> None:
    path = tmp_path / "tower.yaml"
    path.write_text("world: tower\nboxes: {tower: {at: [40, 30], size: [4, 4, 60], color: red}}")
    world = find_world(str(path))
    render(world, tmp_path / "top.png", "top")
    image = cv2.imread(str(tmp_path / "top.png"))
    red = (image[..., 2] > 120) & (image[..., 1] < 90)
    assert red.sum() > 400
    assert not (red[0].any() or red[-1].any() or red[:, 0].any() or red[:, -1].any())


def test_a_camera_named_twice_has_what_was_said_of_it_both_times() -> None:
    found = cameras(Mock(), Mock(), ("front:64x48", "front@5", "ventral:off", "side:32x32"))
    assert found == {
        "front": {"width": 64, "height": 48, "rate": 5.0},
        "ventral": None,
        "side": {"width": 32, "height": 32},
    }


TWICE = ("--camera", "front:64x48@10", "--camera")


NO_WINDOW = "there is no display" if is_installed("bullet") else "the window is pybullet's"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("worlds", "yard", "--render", "no/such/folder/x.png"), "cannot be written"),
        (("worlds", "yard", "--render", "x.nothing"), "cannot be written"),
        (("worlds", "--render", "x.png"), "which world?"),
        (("worlds", "yard", "--render", "x.png", "--at", "1,2"), "'1,2' is not x,y,z"),
        (
            ("worlds", "yard", "--render", "x.png", "--camera", "top", "--at", "1,2,3"),
            "--camera down",
        ),
        (("worlds", "yard", "--gui"), NO_WINDOW),
        (("worlds", "yard", "--render", "x.png", "--json"), "exclude one another"),
        (("run", "first_flight", "--camera", "front:640"), "is not NAME:WIDTHxHEIGHT@RATE"),
        (("run", "first_flight", *TWICE, "front:off"), "the camera 'front' is set twice"),
        (("run", "first_flight", *TWICE, "front@5"), "the camera 'front' is set twice"),
        (("run", "first_flight", "--camera", "front@1000"), "has a rate of 1000"),
        (("run", "first_flight", "--renderer", "tny"), "did you mean 'tiny'?"),
        (("worlds", "yard", "--renderer", "gl"), "'gl' is none of egl, raster, tiny"),
    ],
)
def test_what_cannot_be_is_told(
    arguments: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    result = run_cli(*arguments)
    assert result.code == 2 and message in result.err
    assert list(tmp_path.iterdir()) == []


def test_shadows_darken_the_ground(tmp_path: Path) -> None:
    pictures = []
    for name, options in (("lit.png", ()), ("dark.png", ("--shadows",))):
        path = str(tmp_path / name)
        assert run_cli("worlds", "yard", "--render", path, *options).code == 0
        pictures.append(cv2.imread(path).astype(int))
    lit, dark = pictures
    darker = (dark < lit).any(2)
    assert (dark <= lit).all()
    assert 0.005 < darker.mean() < 0.3
