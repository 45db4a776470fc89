"""Draws the pictures of tracking and landing: what their behaviours see, at some moments of a
flight.

A part of `make images`; alone `python -m docs.draw_landings`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from fsm import parse_parameters
from hal.scene.arrays import Pixels
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from runner.run_folder import read_run

IMAGES = Path(__file__).parent / "images" / "vision"
WIDTH, HEIGHT = 240, 180
"""Of each moment, pixels."""
MOMENTS: Mapping[str, Sequence[float]] = {
    "track_object": (1.8, 6.6, 12.0, 30.0),
    "land_on_pad": (7.4, 9.0, 10.6, 11.6),
    "land_on_moving_pad": (6.6, 8.0, 9.2, 10.3),
}
"""Seconds of the flights."""


def seen_in(mission: str, moments: Sequence[float]) -> Pixels:
    """Fly a mission with command noise; its annotated pictures of some moments, side by side."""
    prepared = prepare(missions.find(mission))
    values = parse_parameters(prepared.graph, {})
    plan = Plan.alone(prepared, values, seed=1, settings={"noise": 1.0})
    with TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder))
        recorder.write_summary(fly(plan, lambda: recorder))
        pictures = read_run(Path(folder)).pictures
        taken = [min(pictures, key=lambda each: abs(each.time - time)) for time in moments]
        images = [cv2.imread(str(each.path)) for each in taken]
    size = WIDTH, HEIGHT
    small = [cv2.resize(image, size, interpolation=cv2.INTER_AREA) for image in images]
    return np.asarray(np.hstack(small), np.uint8)


def draw_landings() -> None:
    """Draw the pictures of all of them."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    for mission, moments in MOMENTS.items():
        image = seen_in(mission, moments)
        cv2.imwrite(str(IMAGES / f"{mission}.jpg"), image, [cv2.IMWRITE_JPEG_QUALITY, 80])


if __name__ == "__main__":
    draw_landings()
