"""A diagram of a graph with all coordinates: boxes and lines in pixels, y downwards."""

from __future__ import annotations

from dataclasses import dataclass

from fsm.language.spec import StateType

XY = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Box:
    """The box of a state."""

    path: str
    kind: StateType
    depth: int
    x: float
    y: float
    width: float
    height: float
    name: str
    lines: tuple[str, ...]
    title: str

    @property
    def right(self) -> float:
        return self.x + self.width

    @property
    def bottom(self) -> float:
        return self.y + self.height


@dataclass(frozen=True, slots=True)
class Label:
    """The text beside a line."""

    x: float
    y: float
    width: float
    height: float
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Line:
    """The transitions from one state to another, or the line to an initial state.

    ``points`` go from the source's border, or from the initial dot, to the target's border.
    """

    source: str
    target: str
    points: tuple[XY, ...]
    label: Label | None
    dot: bool
    """True for the line to an initial state, which begins at a dot."""
    title: str


@dataclass(frozen=True, slots=True)
class Diagram:
    """All boxes and lines of a graph; outer boxes come before those inside them."""

    name: str
    description: str
    width: float
    height: float
    boxes: tuple[Box, ...]
    lines: tuple[Line, ...]
    separators: tuple[tuple[XY, XY], ...]
    """The lines between the regions of parallel states."""
