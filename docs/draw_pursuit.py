"""Draws the picture of a pursuit: the ways of cat and mouse, their distance, and the cat's view."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from cli.plot import draw
from runner import Plan, Recorder, fly, missions, prepare_fleet, read_run

_SHOWN = (9.0, 30.0, 45.0)
"""Seconds of the flight at which the cat's view is shown."""


def draw_pursuit(path: Path) -> None:
    """Fly the fleet cat_and_mouse, and draw its picture above three annotated views."""
    prepared = prepare_fleet(missions.find("cat_and_mouse"))
    plan = Plan(prepared.assignments, fleet=prepared.fleet)
    with TemporaryDirectory() as name:
        folder = Path(name)
        recorder = Recorder(folder)
        recorder.write_summary(fly(plan, lambda: recorder))
        flown = cv2.imread(str(draw(folder)))
        taken = read_run(folder).pictures
        views = [
            cv2.imread(str(min(taken, key=lambda each: abs(each.time - moment)).path))
            for moment in _SHOWN
        ]
    seen = np.hstack(views)
    height = round(flown.shape[0] * seen.shape[1] / flown.shape[1])
    small = cv2.resize(flown, (seen.shape[1], height), interpolation=cv2.INTER_AREA)
    path.parent.mkdir(exist_ok=True)
    cv2.imwrite(str(path), np.vstack([small, seen]), [cv2.IMWRITE_JPEG_QUALITY, 60])
