"""The built-in detectors, and the reading of those that a mission names.

A mission gives a list; each entry is a name, or a map of a name to its settings::

    detect: [people, {fiducials: {ids: [1, 2, 3]}}, {color: {color: orange, size: 60 cm}}]
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from math import hypot, isfinite
from typing import Any

import cv2
import numpy as np

from behaviors.action import arguments_of
from behaviors.detector import BUILT_IN, Detector, OwnDetector, Sighting, require_word
from behaviors.perception.blobs import Blob, blobs, touches_edge
from behaviors.perception.color import ColorRange, hsv_mask, mask, read_color
from behaviors.perception.fiducials import FiducialDetector
from behaviors.perception.projection import ground_points, pixels_of
from behaviors.plan import Unflyable
from fsm.host import Parameter
from fsm.values.conversion import convert
from fsm.values.functions import EvaluationError, shown
from hal.scene.arrays import Float64s, Pixels
from hal.vehicle import Frame
from vencejo.errors import nearest

_LEAST_PIXELS = 12.0
"""Blobs of fewer pixels tell nothing."""


def read_detectors(given: Any, own: Mapping[str, OwnDetector]) -> list[Detector]:
    """The detectors of a mission's list. Raises Unflyable for what is none.

    ``own`` are the person's functions by name.
    """
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        raise Unflyable("`detect` is a list of detectors, with one or more", "detect", _HINT)
    return [_read(entry, own) for entry in given]


_HINT = "such as [people, {color: {color: orange, size: 60 cm}}]"


def _read(entry: Any, own: Mapping[str, OwnDetector]) -> Detector:
    name, settings = (entry, {}) if isinstance(entry, str) else _parts(entry)
    if name in own:
        return _own(own[name], settings)
    if name not in _BUILT:
        hint = nearest(name, [*_BUILT, *own]) or ""
        raise Unflyable(f"there is no detector '{name}'", "detect", hint)
    make = _BUILT[name]
    given = _checked(name, settings, arguments_of(make))
    try:
        return make(**given)
    except ValueError as error:
        raise Unflyable(f"the detector '{name}': {error}", "detect") from None


def _checked(
    name: str, settings: Mapping[str, Any], known: Mapping[str, Parameter]
) -> dict[str, Any]:
    """Settings that a detector has, with all that it needs. Raises Unflyable for others."""
    for each in settings:
        if each not in known:
            hint = (nearest(each, known) or "") if known else "it has none"
            raise Unflyable(f"the detector '{name}' has no setting '{each}'", "detect", hint)
    for each, setting in known.items():
        if setting.required and each not in settings:
            raise Unflyable(f"the detector '{name}' needs '{each}'", "detect")
    try:
        return {each: convert(value, known[each].type) for each, value in settings.items()}
    except EvaluationError as error:
        raise Unflyable(f"the detector '{name}': {error}", "detect") from None


def _parts(entry: Any) -> tuple[str, Mapping[str, Any]]:
    """The name and the settings of a map."""
    if isinstance(entry, Mapping) and len(entry) == 1:
        [(name, settings)] = entry.items()
        if isinstance(settings, Mapping):
            return name, settings
    raise Unflyable(f"{shown(entry)} names no detector", "detect", _HINT)


def _own(own: OwnDetector, settings: Mapping[str, Any]) -> Detector:
    """A person's function with the settings of a mission."""
    if own.function is None:
        return lambda frame, ground: []
    given = _checked(own.name, settings, own.parameters)
    return partial(_called, own.name, partial(own.function, **given))


def _called(
    name: str, function: Callable[[Frame, float], Any], frame: Frame, ground: float
) -> list[Sighting]:
    """What a person's function has found. Raises TypeError or ValueError for anything else."""
    found = function(frame, ground)
    if not isinstance(found, Iterable):
        raise TypeError(f"the detector '{name}' gave {found!r:.40}, which is no list of Sighting")
    found = list(found)
    for each in found:
        if not isinstance(each, Sighting):
            raise TypeError(f"the detector '{name}' gave {each!r:.40}, which is no Sighting")
        try:
            x, y = each.pixel
            is_finite = all(map(isfinite, (x, y, each.height)))
        except (TypeError, ValueError):
            is_finite = False
        if not is_finite:
            place = f"{each.pixel!r:.40} and {each.height!r:.20}"
            raise ValueError(f"the detector '{name}' gave {place}, no finite pixel and height")
    return found


# -- markers ------------------------------------------------------------------------------------


def fiducials(
    dictionary: str = "4X4_50",
    ids: Sequence[int] | None = None,
    kind: str = "marker",
    parameters: Mapping[str, Any] | None = None,
) -> Detector:
    """Markers of a dictionary, only those with these ids if some are given.

    ``parameters`` are OpenCV's DetectorParameters. Raises ValueError for what OpenCV does not have.
    """
    require_word(kind)
    if not (ids is None or isinstance(ids, (list, tuple))):
        raise ValueError(f"`ids` is a list of whole numbers, not {ids!r:.40}")
    if not (parameters is None or isinstance(parameters, Mapping)):
        raise ValueError(f"`parameters` is a map of names to values, not {parameters!r:.40}")
    found = FiducialDetector(dictionary, ids, parameters)

    def detect(frame: Frame, ground: float) -> list[Sighting]:
        sightings = []
        for each in found.detect(frame.image).found:
            (left, top), (right, bottom) = each.corners.min(0), each.corners.max(0)
            box = (int(left), int(top), int(right) + 1, int(bottom) + 1)
            sightings.append(Sighting(kind, each.centre, 0.0, str(each.id), box))
        return sightings

    return detect


# -- colours ------------------------------------------------------------------------------------

_SIZE_ERROR = 1.35
"""A thing counts whose width is between its size by this and its size times this."""
_ROUND, _ROUND_PIXELS = 0.13, 1.5
"""Difference of the largest and least distances of a round thing's edge from its middle, by their
mean, and what pixels add to that; of a square it is 0.36."""
_SOLID = 0.75
"""Least share of the pixels inside a thing's outline that have its colour."""


def color(
    color: Any, size: float, kind: str = "", shape: str = "any", height: float | None = None
) -> Detector:
    """Things of a colour and a size, metres across.

    ``shape`` is ``round`` (a ball) or ``any``; ``height`` that of their middle above the ground,
    metres, by default half the size. Raises ValueError for what is no colour, size or shape.
    """
    wanted = read_color(color)
    require_word(kind or "thing")
    if not 0 < size < 1000:
        raise ValueError(f"a size is a length above 0, not {size:g}")
    if shape not in ("any", "round"):
        raise ValueError(f"a shape is any or round, not {shape!r:.20}")
    middle = size / 2 if height is None else float(height)
    word = kind or (color if isinstance(color, str) else "thing")

    def detect(frame: Frame, ground: float) -> list[Sighting]:
        pixels = mask(_calmed(frame.image), wanted)
        return [
            Sighting(word, (blob.x, blob.y), middle, "", blob.box)
            for blob in blobs(pixels, _LEAST_PIXELS)
            if _is_thing(blob, pixels, frame, ground + middle, size, shape)
        ]

    return detect


def _is_thing(  # the measures of one blob
    blob: Blob, pixels: Pixels, frame: Frame, level: float, size: float, shape: str
) -> bool:
    if touches_edge(blob, frame.image) or _solidity(blob, pixels) < _SOLID:
        return False
    sides = _sides(blob, frame, level)
    if not all(size / _SIZE_ERROR <= side <= size * _SIZE_ERROR for side in sides):
        return False
    return shape == "any" or _is_round(blob)


def _calmed(image: Pixels) -> Pixels:
    """An image without single wrong pixels."""
    return np.asarray(cv2.medianBlur(image, 3), np.uint8)


def _solidity(blob: Blob, pixels: Pixels) -> float:
    """The share of the pixels inside a blob's outline that belong to it."""
    left, top, right, bottom = blob.box
    inside = cv2.countNonZero(pixels[top:bottom, left:right])
    return min(1.0, inside / blob.area)


def _rectangle(blob: Blob) -> Any:
    return cv2.minAreaRect(blob.contour.reshape(-1, 1, 2))


def _sides(blob: Blob, frame: Frame, level: float) -> tuple[float, float]:
    """The sides of the smallest rectangle round a blob, metres at a level; the longer one last."""
    (x, y), _, _ = rectangle = _rectangle(blob)
    corners = np.asarray(cv2.boxPoints(rectangle), np.float64)
    # From the middles of the outermost pixels to their edges.
    centre = np.array([x, y])
    out = corners - centre
    length = np.maximum(np.hypot(*out.T), 1e-6)[:, None]
    a, b, c, _ = ground_points(frame, corners + out / length * 0.7, level)
    sides = hypot(*(b - a)[:2]), hypot(*(c - b)[:2])
    return (min(sides), max(sides)) if all(map(isfinite, sides)) else (0.0, 0.0)


def _is_round(blob: Blob) -> bool:
    out = np.hypot(*(blob.contour - (blob.x, blob.y)).T)
    least, most = np.percentile(out, (2, 98))
    mean = float(out.mean())
    return bool(most - least <= _ROUND * mean + _ROUND_PIXELS)


# -- people -------------------------------------------------------------------------------------

_SKIN = ColorRange((3, 35, 80), (20, 150, 255))
_VIVID = ColorRange((0, 160, 50), (179, 255, 255))
_HEAD = (0.18, 0.60)
"""Least and largest width of a head, metres on the ground: one of 0.3 m that is 1.6 m above it
looks half as wide again from 5 m."""
_TRUNK = (0.02, 0.75)
"""Least and largest area of what a trunk shows of itself, square metres on the ground."""
_LONGEST = 1.3
"""Largest length of it, metres on the ground."""
_LYING = 0.2
"""Height of the middle of somebody who lies, metres."""
_STANDING_HEAD, _STANDING_TRUNK = 1.6, 1.15
"""Heights of the middles of head and trunk of somebody who stands, metres."""
_HEAD_TO_TRUNK, _HEAD_TO_MIDDLE = 0.45, 0.725
"""Distances from the middle of the head to that of the trunk, and of the whole body, metres."""
_BETWEEN = 0.12
"""Largest gap between head and trunk, metres."""


def people(kind: str = "person") -> Detector:
    """People who lie or stand: a bright trunk with a head at it.

    Things of the same colours without a head are none, nor those of other sizes. Bright are colours
    that are strong, whatever their hue.
    """
    require_word(kind)

    def detect(frame: Frame, ground: float) -> list[Sighting]:
        image = np.asarray(cv2.cvtColor(_calmed(frame.image), cv2.COLOR_BGR2HSV), np.uint8)
        skin = hsv_mask(image, _SKIN)
        heads = [each for each in _heads(skin, frame, ground) if not touches_edge(each, skin)]
        if not heads:
            return []
        vivid = cv2.bitwise_and(hsv_mask(image, _VIVID), cv2.bitwise_not(skin))
        trunks = [
            trunk
            for trunk in blobs(np.asarray(vivid, np.uint8), _LEAST_PIXELS)
            if not touches_edge(trunk, skin) and _is_trunk(trunk, frame, ground)
        ]
        pairs = ((head, _trunk_of(head, trunks, frame, ground)) for head in heads)
        return [_person(kind, head, trunk, frame, ground) for head, trunk in pairs if trunk]

    return detect


def _heads(skin: Pixels, frame: Frame, ground: float) -> Iterator[Blob]:
    for head in blobs(skin, _LEAST_PIXELS):
        narrow, wide = _sides(head, frame, ground)
        if _HEAD[0] <= narrow and wide <= _HEAD[1] and wide <= 1.7 * narrow:
            yield head


def _is_trunk(trunk: Blob, frame: Frame, ground: float) -> bool:
    _, longest = _sides(trunk, frame, ground)
    area = trunk.area * _metres_of_pixel(frame, ground) ** 2
    return _TRUNK[0] <= area <= _TRUNK[1] and longest <= _LONGEST


def _metres_of_pixel(frame: Frame, ground: float) -> float:
    return (frame.position.z - ground) / frame.intrinsics.fx


def _trunk_of(head: Blob, trunks: Sequence[Blob], frame: Frame, ground: float) -> Blob | None:
    """The trunk that a head is at; None for none."""
    gap = _BETWEEN / _metres_of_pixel(frame, ground) + 1.5
    near = [
        (distance, k) for k, trunk in enumerate(trunks) if (distance := _gap(head, trunk)) <= gap
    ]
    return trunks[min(near)[1]] if near else None


def _gap(a: Blob, b: Blob) -> float:
    """The distance between the edges of two blobs, pixels; 0 where one is inside the other."""
    outline = b.contour.reshape(-1, 1, 2)
    if cv2.pointPolygonTest(outline, (a.x, a.y), False) >= 0:
        return 0.0
    apart = a.contour[:, None, :].astype(np.float64) - b.contour[None, :, :]
    return float(np.sqrt((apart**2).sum(-1).min()))


def _person(kind: str, head: Blob, trunk: Blob, frame: Frame, ground: float) -> Sighting:
    """Somebody by head and trunk; lying where these are as far apart as on the ground."""
    ends = np.array([[head.x, head.y], [trunk.x, trunk.y]])
    lying = ground_points(frame, ends, ground + _LYING)
    above = np.stack(
        [
            ground_points(frame, ends[:1], ground + _STANDING_HEAD)[0],
            ground_points(frame, ends[1:], ground + _STANDING_TRUNK)[0],
        ]
    )
    along = (lying[1] - lying[0])[:2]
    length, upright = hypot(*along), hypot(*(above[1] - above[0])[:2])
    boxes = np.array([head.box, trunk.box])
    (left, top), (right, bottom) = boxes[:, :2].min(0), boxes[:, 2:].max(0)
    box = (int(left), int(top), int(right), int(bottom))
    if length > 0 and abs(length - _HEAD_TO_TRUNK) < upright:
        middle = lying[0].copy()
        middle[:2] += along / length * _HEAD_TO_MIDDLE
        return Sighting(kind, _pixel(frame, middle), _LYING, "", box)
    return Sighting(kind, (head.x, head.y), _STANDING_HEAD, "", box)


def _pixel(frame: Frame, place: Float64s) -> tuple[float, float]:
    x, y = map(float, pixels_of(frame, [place])[0])
    return x, y


_BUILT: Mapping[str, Callable[..., Detector]] = dict(
    zip(BUILT_IN, (fiducials, color, people), strict=True)
)
