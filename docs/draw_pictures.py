"""Draws what behaviours see in some of the shipped missions, for the page of pictures.

A part of `make images`; alone `python -m docs.draw_pictures`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from fsm import parse_parameters
from hal.scene.arrays import Pixels
from runner import missions, read_run
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder

FILE = Path(__file__).parent / "images" / "vision" / "pictures.jpg"
MOMENTS: Mapping[str, tuple[str, float]] = {
    "follow_road": ("road", 20.0),
    "land_on_pad": ("land_on", 10.6),
    "track_object": ("track_object", 24.4),
    "tag_follower": ("detect_tags", 22.9),
}
"""By mission the name of its annotated pictures, and the second of the flight shown."""
QUALITY = 80


def seen_in(mission: str, name: str, moment: float) -> Pixels:
    """The annotated picture of a name nearest to a second of a mission's flight."""
    prepared = prepare(missions.find(mission))
    plan = Plan.alone(prepared, parse_parameters(prepared.graph, {}))
    with TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder))
        fly(plan, lambda: recorder)
        named = [picture for picture in read_run(folder).pictures if picture.name == name]
        nearest = min(named, key=lambda picture: abs(picture.time - moment))
        return np.asarray(cv2.imread(str(nearest.path)), np.uint8)


def draw_pictures() -> None:
    """The pictures of four missions, two by two."""
    views = [seen_in(mission, *shown) for mission, shown in MOMENTS.items()]
    tiled = np.vstack([np.hstack(views[:2]), np.hstack(views[2:])])
    FILE.parent.mkdir(exist_ok=True)
    cv2.imwrite(str(FILE), tiled, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    draw_pictures()
