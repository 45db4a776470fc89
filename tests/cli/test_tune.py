"""`tune color`: from a picture to a range that finds the colour again."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from behaviors.perception import mask, read_color
from hal.scene.arrays import Pixels
from tests.cli.run_cli import Result, run_cli

DISC = (220, 80, 25)
"""Centre and radius of the red disc, pixels."""


@pytest.fixture
def picture() -> Pixels:
    """A red disc on grass, with noise: ``scene.png``."""
    rng = np.random.default_rng(3)
    image = np.full((240, 320, 3), (60, 130, 85), np.uint8)
    cv2.circle(image, DISC[:2], DISC[2], (40, 35, 215), -1)
    noisy = np.clip(image + rng.normal(0, 4, image.shape), 0, 255).astype(np.uint8)
    assert cv2.imwrite("scene.png", noisy)
    return noisy


def colors(result: Result) -> list[Any]:
    """The printed colours, as YAML reads them."""
    assert (result.code, result.err) == (0, "")
    return [yaml.safe_load(line)["color"] for line in result.out.splitlines()]


def shares(result: Result) -> list[float]:
    """The printed shares of the picture, per cent."""
    return [float(text) for text in re.findall(r"# (\S+) % of the picture", result.out)]


@pytest.mark.parametrize(
    "where", [("--at", "220,80"), ("--box", "210,70,230,90"), ("--box", "230,90,210,70")]
)
def test_a_range_finds_the_colour_and_nothing_else(where: tuple[str, str], picture: Pixels) -> None:
    result = run_cli("tune", "color", "scene.png", *where)
    hsv, rgb, name = colors(result)
    assert (list(hsv), list(rgb), name) == (["hsv"], ["rgb"], "red")
    disc = np.zeros(picture.shape[:2], np.uint8)
    cv2.circle(disc, DISC[:2], DISC[2], 255, -1)
    for given, share in zip((hsv, rgb, name), shares(result), strict=True):
        found = mask(picture, read_color(given))
        assert (found[disc > 0] > 0).mean() > 0.97
        assert (found[disc == 0] > 0).mean() < 0.001
        assert share == pytest.approx(100 * (found > 0).mean(), abs=0.006)


def test_the_mask_is_a_picture(picture: Pixels) -> None:
    for file in ("mask.png", "mask.JPG"):
        hsv = colors(run_cli("tune", "color", "scene.png", "--at", "220,80", "-o", file))[0]
        written = cv2.imread(file, cv2.IMREAD_GRAYSCALE)
        assert ((written > 127) == (mask(picture, read_color(hsv)) > 0)).mean() > 0.995


def test_a_click_near_the_edge_takes_what_there_is(picture: Pixels) -> None:
    hsv, *_ = colors(run_cli("tune", "color", "scene.png", "--at", "0,239"))
    assert (mask(picture, read_color(hsv))[200:] > 0).mean() > 0.9


def test_what_has_no_name_is_told_without(picture: Pixels) -> None:
    cv2.imwrite("odd.png", np.full((20, 20, 3), (180, 120, 240), np.uint8))
    assert [
        list(given) for given in colors(run_cli("tune", "color", "odd.png", "--at", "5,5"))
    ] == [
        ["hsv"],
        ["rgb"],
    ]


@pytest.mark.parametrize("shape", [(20, 20), (20, 20, 4)])
def test_grey_pictures_and_such_with_an_alpha_channel(shape: tuple[int, ...]) -> None:
    cv2.imwrite("grey.png", np.full(shape, 128, np.uint8))
    hsv, _, name = colors(run_cli("tune", "color", "grey.png", "--at", "5,5"))
    assert name == "gray" and hsv["hsv"][0][0] == 0 and hsv["hsv"][1][0] == 179


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (["scene.png"], "say where the colour is: --at x,y or --box x1,y1,x2,y2 [bad-usage]"),
        (["scene.png", "--at", "1,1", "--box", "1,1,2,2"], "say where the colour is"),
        (["scene.png", "--at", "5"], "'5' is not x,y in whole pixels; for instance --at 160,120"),
        (["scene.png", "--at", "a,b"], "'a,b' is not x,y in whole pixels"),
        (["scene.png", "--box", "1,2,3"], "for instance --box 160,120,180,140"),
        (["scene.png", "--at", "500,500"], "nothing of the picture, 320 x 240 pixels, is in"),
        (["scene.png", "--at=-50,20"], "nothing of the picture, 320 x 240 pixels, is in"),
        (["gone.png", "--at", "1,1"], "gone.png: error: this picture cannot be read: no such"),
        (["text.png", "--at", "1,1"], "text.png: error: this is no picture [no-picture]"),
        (["empty.png", "--at", "1,1"], "empty.png: error: this is no picture [no-picture]"),
        (["scene.png", "--at", "1,1", "-o", "m.gif"], "'m.gif' does not end in .png or .jpg"),
        (["scene.png", "--at", "1,1", "-o", "no/m.png"], "this file cannot be written"),
    ],
)
def test_what_cannot_be_told_is_explained(
    given: list[str], told: str, picture: Pixels, write: Callable[[str, str], str]
) -> None:
    write("text.png", "no picture")
    write("empty.png", "")
    result = run_cli("tune", "color", *given)
    assert result.code in (2, 4) and told in result.err
    assert "Traceback" not in result.err and not Path("m.gif").exists()


def test_without_a_command_there_is_help() -> None:
    result = run_cli("tune")
    assert (result.code, result.err) == (0, "")
    assert "color  The range of a colour in a picture." in result.out


MISSION = """\
mission: look
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: look}}
  look:
    do: find_color
    with:
      COLOR
    on: {failed: land}
    states: {stay: {do: hover, after: {1 s: land}}}
  land: {do: land, on: {done: over}}
  over: {type: final}
"""


def test_each_line_can_be_pasted_into_a_mission(
    picture: Pixels, write: Callable[[str, str], str]
) -> None:
    lines = run_cli("tune", "color", "scene.png", "--at", "220,80").out.splitlines()
    assert len(lines) == 3
    for line in lines:
        result = run_cli("check", write("look.yaml", MISSION.replace("COLOR", line)))
        assert (result.code, result.err) == (0, ""), line
