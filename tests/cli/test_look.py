"""`drone-cli worlds NAME --render` and `--gui`, and the run's options for cameras."""

from __future__ import annotations

from pathlib import Path
from unittest.mock import Mock

import cv2
import pytest

from cli.look import LENS, view
from cli.options import cameras
from hal.scene.transforms import rotation_matrix
from tests.cli.run_cli import run_cli
from vencejo.geometry import Point
from worlds import find_world, world_names


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


def test_a_camera_named_twice_has_what_was_said_of_it_both_times() -> None:
    found = cameras(Mock(), Mock(), ("front:64x48", "front@5", "ventral:off", "side:32x32"))
    assert found == {
        "front": {"width": 64, "height": 48, "rate": 5.0},
        "ventral": None,
        "side": {"width": 32, "height": 32},
    }


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
        (("worlds", "yard", "--gui"), "there is no display"),
        (("worlds", "yard", "--render", "x.png", "--json"), "exclude one another"),
        (("run", "first_flight", "--camera", "front:640"), "is not NAME:WIDTHxHEIGHT@RATE"),
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
