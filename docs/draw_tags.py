"""Draws the pictures of the tag missions: what their behaviours see, at one moment of a flight.

A part of `make images`; alone `python -m docs.draw_tags`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import cv2

from cli.plot import draw
from fsm import parse_parameters
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder

IMAGES = Path(__file__).parent / "images" / "vision"
WIDTH = 480
"""Of the pictures, pixels."""


class View(NamedTuple):
    """A view of a flight."""

    behavior: str
    """Whose annotated picture it is; empty for the picture of the whole flight."""
    moment: float = 0.0
    """Seconds of the flight."""


VIEWS: Mapping[str, View] = {
    "square": View(""),
    "tag_lights": View("detect_tags", 8.8),
    "tag_follower": View("detect_tags", 20.0),
    "tag_follower_braking": View("detect_tags", 24.0),
    "roundel_follower": View("hover_over", 20.0),
    "tag_navigator": View("hover_over", 6.0),
}


def picture_of(mission: str, view: View, folder: Path) -> Path:
    """Fly a mission with command noise, and give the file of its picture."""
    prepared = prepare(missions.find(mission))
    plan = Plan.alone(
        prepared, parse_parameters(prepared.graph, {}), seed=1, settings={"noise": 1.0}
    )
    recorder = Recorder(folder)
    recorder.write_summary(fly(plan, lambda: recorder))
    if not view.behavior:
        return draw(folder)
    lines = (folder / "pictures.jsonl").read_text("utf-8").splitlines()[1:]
    taken = [line for line in map(json.loads, lines) if line["name"] == view.behavior]
    nearest = min(taken, key=lambda line: abs(line["t"] - view.moment))
    return folder / str(nearest["file"])


def draw_tags() -> None:
    """Draw the picture of every tag mission."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    for mission, view in VIEWS.items():
        with TemporaryDirectory() as folder:
            image = cv2.imread(str(picture_of(mission, view, Path(folder))))
        scale = WIDTH / image.shape[1]
        way = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=way)
        cv2.imwrite(str(IMAGES / f"{mission}.jpg"), image, [cv2.IMWRITE_JPEG_QUALITY, 85])


if __name__ == "__main__":
    draw_tags()
