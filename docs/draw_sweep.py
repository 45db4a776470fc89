"""Draws the picture of a search: the way over the meadow, and some of what was seen on it."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from cli.plot import draw
from fsm import parse_parameters
from runner import Plan, Recorder, fly, missions, prepare, read_run
from runner.findings import findings_of

_MAP = (slice(50, 610), slice(20, 595))
"""Where the map is in the picture of a run, pixels."""
_SHOWN = ("person_1", "buoy_1", "marker_7", "person_4")


def draw_sweep(path: Path) -> None:
    """Fly the mission sweep_detect, and draw its map beside four annotated pictures."""
    prepared = prepare(missions.find("sweep_detect"))
    plan = Plan.alone(prepared, parse_parameters(prepared.graph, {}))
    with TemporaryDirectory() as name:
        folder = Path(name)
        recorder = Recorder(folder)
        recorder.write_summary(fly(plan, lambda: recorder))
        flown = cv2.imread(str(draw(folder)))[_MAP]
        run = read_run(folder)
        found = {finding.id: finding.time for finding in findings_of(run)}
        views = [
            cv2.imread(str(min(run.pictures, key=lambda p: abs(p.time - found[each] - 0.3)).path))
            for each in _SHOWN
        ]
    seen = np.vstack([np.hstack(views[:2]), np.hstack(views[2:])])
    height = seen.shape[0]
    width = round(flown.shape[1] * height / flown.shape[0])
    small = cv2.resize(flown, (width, height), interpolation=cv2.INTER_AREA)
    path.parent.mkdir(exist_ok=True)
    cv2.imwrite(str(path), np.hstack([small, seen]), [cv2.IMWRITE_JPEG_QUALITY, 70])
