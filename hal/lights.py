"""A vehicle's lamps: patterns, and the colour of each lamp over time.

A vehicle has four lamps, in the order front left, front right, rear right, rear left. The patterns
are those of the AR.Drone's LED animations that need one colour.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from vencejo.errors import UserError, nearest

Pattern = Literal["standard", "off", "solid", "blink", "snake", "fire"]
Rgb = tuple[int, int, int]

COLORS: dict[str, Rgb] = {
    "red": (255, 0, 0),
    "green": (0, 255, 0),
    "orange": (255, 140, 0),
    "yellow": (255, 255, 0),
    "blue": (0, 80, 255),
    "white": (255, 255, 255),
}
PATTERNS: tuple[str, ...] = get_args(Pattern)
STANDARD: tuple[Rgb, ...] = (COLORS["green"], COLORS["green"], COLORS["red"], COLORS["red"])
"""Green in front and red behind, so that a person can see the heading."""
_OFF: Rgb = (0, 0, 0)


@dataclass(frozen=True, slots=True)
class Lights:
    """A pattern for the lamps to show. Raises UserError (``bad-lights``) for an impossible one."""

    pattern: Pattern = "standard"
    color: str = "white"
    rate: float = 1.0
    """Repetitions of the pattern per second, Hz."""
    duration: float | None = None
    """Seconds until the standard pattern returns; None for never."""

    def __post_init__(self) -> None:
        for what, word, known in (
            ("pattern", self.pattern, PATTERNS),
            ("color", self.color, tuple(COLORS)),
        ):
            if word not in known:
                message = f"there is no {what} of lights '{word}'"
                raise UserError("bad-lights", message, hint=nearest(word, known))
        if not 0 < self.rate <= 20:
            raise UserError("bad-lights", f"lights blink 0 to 20 times a second, not {self.rate:g}")
        if self.duration is not None and not self.duration > 0:
            raise UserError("bad-lights", f"lights cannot last {self.duration:g} s")

    def lamps(self, elapsed: float) -> tuple[Rgb, ...]:
        """The RGB colours of the four lamps, ``elapsed`` seconds after the pattern was ordered."""
        if self.pattern == "standard" or (self.duration is not None and elapsed >= self.duration):
            return STANDARD
        color = COLORS[self.color]
        phase = elapsed * self.rate % 1.0
        match self.pattern:
            case "solid":
                return (color,) * 4
            case "blink":
                return (color if phase < 0.5 else _OFF,) * 4
            case "snake":
                # One at a time, clockwise as seen from above.
                return tuple(color if lamp == int(phase * 4) else _OFF for lamp in range(4))
            case "fire":
                front = color if phase < 0.5 else _OFF
                return front, front, COLORS["red"], COLORS["red"]
        return (_OFF,) * 4
