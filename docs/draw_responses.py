"""Draws how the shipped models answer steps of the commanded speed, climb and turn rate."""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle
from math import degrees
from pathlib import Path

from cli.plot.axes import axes_over
from cli.plot.canvas import XY, Box, Canvas, Color
from hal import Observation, Options, VehicleSpec, Velocity, backend_models, open_backend
from hal.vehicle import PERIODS_PER_SECOND

_COLORS: tuple[Color, ...] = ((31, 119, 180), (214, 39, 40), (44, 160, 44), (148, 103, 189))
_DASHED: Color = (60, 60, 60)
_BEFORE, _STEP, _AFTER = 0.5, 2.5, 2.0
"""Seconds before the step, of the step, and after it."""
_WIDTH, _HEIGHT, _LEFT, _TOP = 320, 210, 48, 34
"""Of a panel, and its place in its part of the picture, pixels."""
_STEPS: tuple[tuple[str, Velocity, float, Callable[[Observation], float]], ...] = (
    ("forward speed, m/s", Velocity(x=2.0), 2.0, lambda seen: seen.velocity.x),
    ("climb, m/s", Velocity(z=1.0), 1.0, lambda seen: seen.velocity.z),
    (
        "turn rate, deg/s",
        Velocity(yaw_rate=1.0),
        degrees(1.0),
        lambda seen: degrees(seen.rates.z),
    ),
)
"""Title, command, its value, and what is measured of its answer."""


def draw_responses(path: Path) -> None:
    """Fly the steps with every model of the simulator, without noise and wind, and draw them."""
    models = backend_models("sim")
    names = models.names() if models else []
    width, height = _LEFT + _WIDTH + 22, _TOP + _HEIGHT + 60
    canvas = Canvas(width * len(_STEPS), height)
    for column, (title, command, value, measured) in enumerate(_STEPS):
        left = column * width + _LEFT
        box = Box(left, _TOP, left + _WIDTH, _TOP + _HEIGHT)
        lines = [response(name, command, measured) for name in names]
        low = min(0.0, *(y for line in lines for _, y in line)) - 0.1 * value
        high = max(y for line in lines for _, y in line) + 0.1 * value
        axes = axes_over(box, (-_BEFORE, _STEP + _AFTER), (low, high))
        axes.grid(canvas)
        asked = [(-_BEFORE, 0.0), (0.0, 0.0), (0.0, value), (_STEP, value), (_STEP, 0.0)]
        canvas.dashes(axes.places([*asked, (_STEP + _AFTER, 0.0)]), _DASHED)
        for line, color in zip(lines, cycle(_COLORS), strict=False):
            canvas.line(axes.places(line), color)
        axes.frame(canvas, title)
        axes.label_x(canvas)
        axes.label_y(canvas)
    place = float(_LEFT)
    for name, color in zip(names, cycle(_COLORS), strict=False):
        canvas.line([(place, height - 18), (place + 22, height - 18)], color, 2.5)
        canvas.text((place + 28, height - 18), name)
        place += 130
    canvas.text((place, height - 18), "dashes: as commanded; seconds since the step")
    path.write_bytes(canvas.png())


def response(model: str, command: Velocity, measured: Callable[[Observation], float]) -> list[XY]:
    """The answer of a model that hovers to a command and its end: seconds since it, and values."""
    options = Options((VehicleSpec("drone", model),))
    with open_backend("sim", options) as session:
        drone = session.vehicles["drone"]
        drone.takeoff(5.0)
        for _ in range(8 * PERIODS_PER_SECOND):
            session.wait()
        found = []
        periods = round((_BEFORE + _STEP + _AFTER) * PERIODS_PER_SECOND)
        for period in range(periods):
            time = period / PERIODS_PER_SECOND - _BEFORE
            drone.command(command if 0 <= time < _STEP else Velocity())
            session.wait()
            found.append((time, measured(drone.observe())))
        return found
