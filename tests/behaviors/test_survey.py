"""survey, and the lines that it flies."""

from __future__ import annotations

from itertools import pairwise
from math import cos, hypot, pi, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors import PlanStart, describe
from behaviors.survey import Survey, survey_lines
from hal.vehicle import Frame, Intrinsics
from tests.behaviors.flying import Solo
from vencejo.geometry import Point, distance

INFO = describe(Survey)
FIELD = [Point(0, 0, 0), Point(12, 0, 0), Point(12, 6, 0), Point(0, 6, 0)]


def test_the_lines_of_a_field() -> None:
    lines = survey_lines(FIELD, 5.0, 2.0, None)
    assert lines == [
        Point(0, 1, 5), Point(12, 1, 5), Point(12, 3, 5), Point(0, 3, 5), Point(0, 5, 5),
        Point(12, 5, 5),
    ]  # fmt: skip
    upright = survey_lines(FIELD, 5.0, 6.0, pi / 2)
    assert [(round(p.x, 6), round(p.y, 6)) for p in upright] == [(9, 0), (9, 6), (3, 6), (3, 0)]


def test_where_an_area_is_concave_a_line_has_parts() -> None:
    hollow = [
        Point(*p, 0) for p in [(0, 0), (9, 0), (9, 4), (6, 4), (6, 2), (3, 2), (3, 4), (0, 4)]
    ]
    lines = survey_lines(hollow, 5.0, 2.0, 0.0)
    assert [(p.x, p.y) for p in lines[2:]] == [(9, 3), (6, 3), (3, 3), (0, 3)]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.floats(2, 20), min_size=3, max_size=8), st.floats(0.3, 5), st.floats(-4, 4))
def test_no_place_of_an_area_is_farther_from_a_line_than_half_the_spacing(
    radii: list[float], spacing: float, axis: float
) -> None:
    corners = [
        Point(r * cos(2 * pi * k / len(radii)), r * sin(2 * pi * k / len(radii)), 0)
        for k, r in enumerate(radii)
    ]
    lines = survey_lines(corners, 5.0, spacing, axis)
    assert len(lines) % 2 == 0
    across = [-sin(axis) * p.x + cos(axis) * p.y for p in corners]
    flown = sorted({round(-sin(axis) * p.x + cos(axis) * p.y, 6) for p in lines})
    assert all(b - a <= spacing + 1e-5 for a, b in pairwise(flown))
    assert flown[0] - min(across) <= spacing / 2 + 1e-5
    assert max(across) - flown[-1] <= spacing / 2 + 1e-5
    for a, b in zip(lines[::2], lines[1::2], strict=True):
        assert abs((b.x - a.x) * sin(axis) - (b.y - a.y) * cos(axis)) < 1e-6


def fly(solo: Solo, seconds: float = 200) -> list[Point]:
    track = []
    while solo.run(0.025) is None and solo.time < seconds:
        track.append(solo.vehicle.position)
    return track


def test_it_flies_over_everything_and_says_its_lines() -> None:
    solo = Solo(INFO, {"area": FIELD, "height": 4.0, "spacing": 2.0})
    track = fly(solo)
    assert solo.word == "done"
    assert solo.events == [("survey.line", {"line": k}) for k in (1, 2, 3)]
    for line in survey_lines(FIELD, 4.0, 2.0, None):
        assert min(distance(line, place) for place in track) <= 0.5
    assert solo.activity.published.lines == 3


class Camera:
    """Shows nothing in its first two looks."""

    def __init__(self) -> None:
        self.looks = 0

    def latest(self) -> Frame | None:
        self.looks += 1
        if self.looks < 3:
            return None
        lens = Intrinsics.from_field_of_view(100, 80, pi / 2)
        image = np.zeros((80, 100, 3), np.uint8)
        return Frame(image, self.looks, 0.0, lens, Point(0, 0, 3), (0.0, 0.0, 0.0, 1.0))


def test_without_spacing_it_is_what_the_camera_sees() -> None:
    solo = Solo(INFO, {"area": FIELD, "height": 4.0, "overlap": 0.5, "camera": "down"})
    looking = Camera()
    solo.vehicle.camera = lambda name: looking  # type: ignore[method-assign, assignment]
    solo.run(0.2)
    # 90° see 8 m from a height of 4 m, half of it twice.
    assert solo.activity.progress()["spacing"] == pytest.approx(4.0)  # type: ignore[index]


def test_without_the_camera_it_has_failed() -> None:
    solo = Solo(INFO, {"area": FIELD, "camera": "down"})
    solo.run(1)
    assert solo.outcome and "no camera 'down'" in solo.outcome.fields["reason"]


@pytest.mark.parametrize(("moved", "again"), [(0.0, []), (9.0, [2])])
def test_it_goes_on_with_its_line(moved: float, again: list[int]) -> None:
    values: dict[str, Any] = {"area": FIELD, "height": 4.0, "spacing": 2.0}
    solo = Solo(INFO, values)
    while solo.activity.published.line < 2 or solo.vehicle.position.x > 7:
        solo.step()
    progress = solo.activity.progress()
    solo.activity.stop()
    solo.vehicle.position = solo.vehicle.position.plus((0.0, moved, 0.0))
    solo.session.wait()
    other = Solo(INFO, values, progress=progress, vehicle=(solo.session, solo.vehicle))
    track = fly(other)
    assert [fields["line"] for _, fields in other.events] == [2, 3]
    begin = survey_lines(FIELD, 4.0, 2.0, None)[2]
    nearest = min(hypot(place.x - begin.x, place.y - begin.y) for place in track)
    assert (nearest <= 0.5) == bool(again)


def test_its_plan() -> None:
    start = PlanStart(Point(0, 0, 4), 0.0, True, 0.0, 5.0)
    values = {name: parameter.default for name, parameter in INFO.parameters.items()}
    values |= {"area": FIELD, "height": 4.0, "camera": "ventral"}
    assert Survey.plan(Survey.Params(**values), start) is None
    legs = Survey.plan(Survey.Params(**{**values, "spacing": 2.0}), start)
    assert legs is not None
    assert [leg.to for leg in legs] == survey_lines(FIELD, 4.0, 2.0, None)
