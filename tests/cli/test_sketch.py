"""The map in a terminal: what stands where on it, and how large it is."""

from __future__ import annotations

from math import cos, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cli.sketch import MAX_POINTS, MIN_SPAN, Mark, Path, Sketch

PLACES = st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4))


def drawn(sketch: Sketch, *marks: Mark, columns: int = 20, rows: int = 11) -> list[str]:
    """The rows below the title."""
    return [line.plain for line in sketch.draw(columns, rows, marks)[1:]]


def found(lines: list[str], sign: str) -> tuple[int, int]:
    (place,) = [(row, line.index(sign)) for row, line in enumerate(lines) if sign in line]
    return place


def test_a_square_with_marks() -> None:
    sketch = Sketch()
    for place in ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)):
        sketch.go("drone", place)
    lines = drawn(sketch, Mark((0.0, 0.0), "H", "green"), Mark((4.0, 4.0), "X", "red"))
    assert [len(line) for line in lines] == [20] * 10
    home, far = found(lines, "H"), found(lines, "X")
    assert home[0] > far[0], "north is up"
    assert home[1] < far[1], "east is right"
    corner = lines[home[0]][far[1]]
    assert 0x2800 < ord(corner) < 0x2900, "the path leads through the south-eastern corner"


def test_lines_of_the_world_are_cut_at_the_edge() -> None:
    sketch = Sketch()
    sketch.include((0.0, 0.0))
    sketch.line([(-1e9, 0.0), (1e9, 0.0)])
    sketch.line([(0.0, 500.0), (0.0, 700.0)])
    lines = drawn(sketch)
    assert [line.strip() != "" for line in lines].count(True) == 1
    assert all(0x2800 < ord(c) < 0x2900 for c in "".join(lines) if c != " ")
    assert sum(c != " " for c in "".join(lines)) == 20


def test_what_moves_leaves_no_trace() -> None:
    sketch = Sketch()
    sketch.include((0.0, 0.0))
    still = [line.plain for line in sketch.draw(20, 11, ())]
    moved = [line.plain for line in sketch.draw(20, 11, (), [[(-1.0, 0.0), (1.0, 0.0)]])]
    assert moved != still
    assert [line.plain for line in sketch.draw(20, 11, ())] == still


def test_labels_cover_no_signs_and_no_labels() -> None:
    sketch = Sketch()
    sketch.include((-3.0, -1.0))
    sketch.include((3.0, 1.0))
    marks = [
        Mark((-3.0, 0.0), "a", "", "west"),
        Mark((-2.0, 0.0), "b", "", "hidden_by_c"),
        Mark((-1.5, 0.0), "c", "", "right"),
        Mark((3.0, 0.0), "d", "", "left"),
    ]
    (row,) = [line for line in drawn(sketch, *marks, columns=40) if "a" in line]
    assert "cright" in row and "leftd" in row
    assert "b" in row and "hidden" not in row


@pytest.mark.parametrize("columns", [12, 20, 40, 44, 132])
@pytest.mark.parametrize("size", [1.0, 7.0, 33.0, 480.0, 12345.0])
def test_the_scale_is_true(columns: int, size: float) -> None:
    sketch = Sketch()
    for k in range(9):
        sketch.include((size * cos(k * pi / 4), size * sin(k * pi / 4)))
    title = sketch.draw(columns, 40, ())[0].plain
    bar, metres = title[title.index("├") : title.index("┤") + 1], title.split()[-2]
    assert title.endswith(" m")
    marks = [Mark((-float(metres) / 2, 0.0), "a", ""), Mark((float(metres) / 2, 0.0), "b", "")]
    lines = drawn(sketch, *marks, columns=columns, rows=40)
    if len(bar) > 2:
        assert abs(found(lines, "b")[1] - found(lines, "a")[1] - len(bar)) <= 1
    assert str(metres).lstrip("0.").rstrip("0").removesuffix(".") in ("1", "2", "5")


@given(st.lists(PLACES, min_size=1, max_size=30), st.integers(2, 80), st.integers(2, 40))
def test_every_place_it_has_come_to_is_on_the_map(
    places: list[tuple[float, float]], columns: int, rows: int
) -> None:
    sketch = Sketch()
    for place in places:
        sketch.go("drone", place)
        sketch.draw(columns, rows, ())
    lines = sketch.draw(columns, rows, [Mark(places[-1], "X", "")])
    assert len(lines) == rows
    assert all(len(line.plain) == columns for line in lines[1:])
    assert sum("X" in line.plain for line in lines) == 1
    again = Sketch()
    for place in places:
        again.go("drone", place)
    assert [line.plain for line in again.draw(columns, rows, [Mark(places[-1], "X", "")])] == [
        line.plain for line in lines
    ], "drawing as it goes is drawing at the end"


def test_what_is_no_place_is_left_out() -> None:
    sketch = Sketch()
    sketch.go("drone", (0.0, 0.0))
    sketch.go("drone", (float("nan"), 1.0))
    sketch.go("drone", (float("inf"), 1.0))
    assert "X" not in "".join(drawn(sketch, Mark((float("nan"), 0.0), "X", "")))


def test_standing_still_is_not_zoomed_in_on() -> None:
    sketch = Sketch()
    sketch.go("drone", (0.0, 0.0))
    edge = MIN_SPAN / 2 * 0.95
    lines = drawn(sketch, Mark((-edge, 0.0), "a", ""), Mark((edge, 0.0), "b", ""))
    assert found(lines, "a")[1] == 0 and found(lines, "b")[1] == 19


def test_a_long_path_is_thinned() -> None:
    path = Path()
    for k in range(10 * MAX_POINTS):
        path.add((k * 0.1, 0.0))
    assert MAX_POINTS / 3 < len(path.points) <= MAX_POINTS
    assert path.points[0] == (0.0, 0.0)
    assert path.points[-1][0] == pytest.approx(10 * MAX_POINTS * 0.1, rel=0.01)
