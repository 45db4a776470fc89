"""Draws what the road missions see, for the page of roads.

A part of `make images`; alone `python -m docs.draw_roads`.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from docs.draw_pictures import QUALITY, seen_in

FILE = Path(__file__).parent / "images" / "vision" / "follow_road.jpg"
MOMENTS = (
    ("follow_road", "road", 8.5),
    ("follow_road", "road", 18.5),
    ("road_travel", "road", 18.0),
    ("road_watch", "traffic", 15.5),
)
"""Mission, name of its pictures, and second of the flight: two by two."""


def draw_roads() -> None:
    views = [seen_in(*moment) for moment in MOMENTS]
    tiled = np.vstack([np.hstack(views[:2]), np.hstack(views[2:])])
    FILE.parent.mkdir(exist_ok=True)
    cv2.imwrite(str(FILE), tiled, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    draw_roads()
