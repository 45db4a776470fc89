"""Sections of a road on a few rows of a picture, and the point to steer for.

The row method of the road follower of D. Yagüe Sánchez, "Cuadricóptero AR.Drone en Gazebo y
JdeRobot", Univ. Rey Juan Carlos 2015, §5.2. Three main rows divide the picture in four, and each
has one above and one below it. On a row a section begins after some pixels in a row of the road's
colour and ends after some others. Coordinates are from the middle of the picture: x to the right,
y upwards, pixels.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2
from typing import NamedTuple

from hal.scene.arrays import Bools, Pixels


class Section(NamedTuple):
    """A part of a row that is road."""

    row: int
    """From the top of the picture."""
    begin: int
    """The first column."""
    end: int
    """The last column."""

    @property
    def centre(self) -> float:
        return (self.begin + self.end) / 2


class Runs(NamedTuple):
    """Pixels in a row that are needed to believe in a change."""

    begin: int = 5
    """Of the road's colour, to begin a section."""
    end: int = 5
    """Of others, to end it."""


@dataclass(frozen=True)
class Sections:
    """What the rows of a picture have of the road."""

    upper: int = 0
    """The most sections on one of the upper rows."""
    lower: int = 0
    """The same of the lower rows."""
    middle_at_edge: bool = False
    """Whether a section on the middle rows reaches the left or right edge of the picture."""
    section: Section | None = None
    """The one with the reference point; None where no road is seen."""
    x: float = 0.0
    """Of the reference point."""
    y: float = 0.0

    @property
    def angle(self) -> float:
        """The direction of the reference point, from straight ahead, clockwise, radians."""
        return atan2(self.x, self.y) if self.section else 0.0


def sections_on(row: Bools, number: int, runs: Runs) -> list[Section]:
    """The sections on one row of a mask."""
    found: list[Section] = []
    begin: int | None = None
    like = unlike = 0
    for column, is_road in enumerate(row.tolist()):
        like, unlike = (like + 1, 0) if is_road else (0, unlike + 1)
        if begin is None and like >= runs.begin:
            begin = column - like + 1
        elif begin is not None and unlike >= runs.end:
            found.append(Section(number, begin, column - unlike))
            begin = None
    if begin is not None:
        found.append(Section(number, begin, len(row) - 1 - unlike))
    return found


def road_sections(mask: Pixels, last_x: float, apart: int, runs: Runs) -> Sections:
    """The sections of a mask (height, width; 0 is no road), and the reference point.

    ``last_x``: of the last reference point; ``apart``: rows from a main one to its neighbours.

    The reference point is on the first row that gives one, the upper rows first, from the top
    down. Of several sections, that counts which is nearest to the last reference point on the upper
    rows (it keeps to its road), and that farthest from it on the lower rows (a hairpin: the part
    that it has not come by). A single section on the lower rows is the way back: where the road
    leaves by the side on the middle rows, the edge it leaves by goes before it. On the middle rows
    y is 0: they are not of the upper half.
    """
    height, width = mask.shape[:2]
    groups = []
    for main in (height // 4, 3 * height // 4, height // 2):
        rows = dict.fromkeys(min(height - 1, max(0, main + k * apart)) for k in (-1, 0, 1))
        groups.append([sections_on(mask[row] > 0, row, runs) for row in rows])
    upper, lower, middle = groups
    found = Sections(
        max(map(len, upper)),
        max(map(len, lower)),
        any(s.begin == 0 or s.end == width - 1 for row in middle for s in row),
    )
    choice = _choice(upper, lower, middle, last_x + (width - 1) / 2, width)
    if choice is None:
        return found
    section, column = choice
    on_middle = any(section in row for row in middle)
    y = 0.0 if on_middle else (height - 1) / 2 - section.row
    return replace(found, section=section, x=column - (width - 1) / 2, y=y)


Rows = list[list[Section]]


def _choice(
    upper: Rows, lower: Rows, middle: Rows, last: float, width: int
) -> tuple[Section, float] | None:
    """The section with the reference point, and the column of that; None where no road is seen.

    ``last``: the column of the last one.
    """
    for row in filter(None, upper):
        return _pointed(min(row, key=lambda section: abs(section.centre - last)), width)
    for row in lower:
        if len(row) > 1:
            return _pointed(max(row, key=lambda section: abs(section.centre - last)), width)
    for section in (section for row in middle for section in row):
        if (section.begin == 0) != (section.end == width - 1):
            return section, 0.0 if section.begin == 0 else width - 1.0
    for row in filter(None, (*lower, *middle)):
        return _pointed(row[0], width)
    return None


def _pointed(section: Section, width: int) -> tuple[Section, float]:
    """A section with the column of its reference point: its centre, or its left end where it is
    the whole row.
    """
    is_whole = section.begin == 0 and section.end == width - 1
    return section, 0.0 if is_whole else section.centre
