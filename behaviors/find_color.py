"""find_color: tell where the largest thing of a colour is in the picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import cv2
import numpy as np

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.new_frames import NewFrames
from behaviors.params import BehaviorParams, param
from behaviors.perception.annotations import GREEN, YELLOW, circle, rejected, text_line
from behaviors.perception.color import ColorRange, mask, read_color
from behaviors.plan import Legs, PlanStart, Unflyable, is_known, require_order
from fsm.host import Outcome
from hal.scene.arrays import Int32s, Pixels

_GAUSS, _BLUR = (3, 3), (7, 7)
"""Sizes of the filters before and after the range of the colour, pixels."""
_SIMPLIFIED = 2.0
"""How far a polygon may be from its contour, pixels."""


@dataclass(frozen=True, slots=True)
class ColorSpot:
    """The largest thing of the colour in the last picture; nothing but zeros where there is none.

    Places are from the middle of the picture, in half widths of it.
    """

    visible: bool = False
    area: float = 0.0
    """Square pixels."""
    x: float = 0.0
    """To the right."""
    y: float = 0.0
    """Upwards."""


class FindColor(Behavior):
    """Look for the largest thing of a colour in each picture of a camera. Never ends by itself.

    It does what the published cat did: blur, HSV, range, blur, threshold, polygons, and the
    largest whose area is within the limits. It commands nothing: put it on a state with states.
    """

    name = "find_color"

    class Params(BehaviorParams):
        camera: str = param("front", help="that it looks through", names="camera")
        color: Any = param(help="a name, {hsv: [[h, s, v], [h, s, v]]} or {rgb: …}")
        min_area_limit: float = param(50.0, min=0.0, help="least area, square pixels")
        max_area_limit: float = param(20_000.0, min=0.0, help="greatest area, square pixels")
        edge_threshold: int = param(50, min=0, max=254, help="of the blurred mask, 0 to 255")
        roll_pitch_thr: float | None = param(
            None, unit="rad", min=0.0, help="pictures taken while it is tilted more are ignored"
        )

    outcomes: ClassVar[Mapping[str, type | None]] = {}
    publishes = ColorSpot
    controls = ()

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if is_known(params.color):
            color_of(params.color)
        require_order(params, "min_area_limit", "max_area_limit")
        return []

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        self.wanted = color_of(self.params.color)
        require_order(self.params, "min_area_limit", "max_area_limit")
        self.frames = NewFrames(flight.camera(self.params.camera), self.params.roll_pitch_thr)

    def step(self, flight: Flight) -> Outcome | str | None:
        params = self.params
        frame = self.frames.next(flight.observation)
        if frame is None:
            return None
        polygons = color_polygons(frame.image, self.wanted, params.edge_threshold)
        spot = _largest(polygons, params.min_area_limit, params.max_area_limit, frame.image)
        flight.publish(spot)
        flight.picture("color", lambda: _drawn(frame.image, polygons, spot))
        return None


def color_of(given: object, parameter: str = "color") -> ColorRange:
    """The colour that a parameter gives. Raises Unflyable for what is none."""
    try:
        return read_color(given)
    except ValueError as error:
        raise Unflyable(str(error), parameter) from None


def color_polygons(image: Pixels, wanted: ColorRange, threshold: int) -> list[Int32s]:
    """The outlines, each (n, 1, 2) pixels, of what has a colour in a BGR image.

    ``threshold``: of the blurred mask, 0 to 255. The steps are those of the cat of D. Yagüe
    Sánchez, "Cuadricóptero AR.Drone en Gazebo y JdeRobot", Univ. Rey Juan Carlos 2015, §5.5.
    """
    smooth = np.asarray(cv2.GaussianBlur(image, _GAUSS, 0), np.uint8)
    blurred = cv2.blur(mask(smooth, wanted), _BLUR)
    _, solid = cv2.threshold(blurred, threshold, 255, cv2.THRESH_BINARY)
    contours, _ = cv2.findContours(solid, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    return [
        np.asarray(cv2.approxPolyDP(contour, _SIMPLIFIED, True), np.int32) for contour in contours
    ]


def _drawn(image: Pixels, polygons: list[Int32s], spot: ColorSpot) -> Pixels:
    """All outlines, and the middle of what was chosen."""
    image = rejected(image, polygons, YELLOW)
    height, width = image.shape[:2]
    half, middle = width / 2, ((width - 1) / 2, (height - 1) / 2)
    place = middle[0] + half * spot.x, middle[1] - half * spot.y
    words = f"{spot.area:.0f} px" if spot.visible else "nothing"
    return text_line(circle(image, place, 4.0, GREEN) if spot.visible else image, words)


def _largest(polygons: list[Int32s], least: float, most: float, image: Pixels) -> ColorSpot:
    """The largest of some polygons whose area is within the limits."""
    height, width = image.shape[:2]
    areas = [(cv2.contourArea(polygon), polygon) for polygon in polygons]
    within = [each for each in areas if least <= each[0] <= most and each[0] > 0]
    if not within:
        return ColorSpot()
    area, polygon = max(within, key=lambda each: each[0])
    moments = cv2.moments(polygon)
    x, y = moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
    half = width / 2
    return ColorSpot(True, area, (x - (width - 1) / 2) / half, ((height - 1) / 2 - y) / half)
