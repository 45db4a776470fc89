"""A diagram of a graph: boxes and lines in pixels, y downwards, nothing left to be decided."""

from __future__ import annotations

from dataclasses import dataclass

from fsm.language.spec import StateType

XY = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Box:
    """A state."""

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
    """What stands beside a line."""

    x: float
    y: float
    width: float
    height: float
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Line:
    """The transitions from one state to another, or where a state begins.

    ``points`` go from the source's border, or from the initial dot, to the target's border.
    """

    source: str
    target: str
    points: tuple[XY, ...]
    label: Label | None
    dot: bool
    """Whether it begins at a dot: where a state begins."""
    title: str


@dataclass(frozen=True, slots=True)
class Diagram:
    """Everything there is to draw. Outer boxes come before those inside."""

    name: str
    description: str
    width: float
    height: float
    boxes: tuple[Box, ...]
    lines: tuple[Line, ...]
    separators: tuple[tuple[XY, XY], ...]
    """Between the regions of parallel states."""
