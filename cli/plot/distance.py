"""The panel of a referee: the distance of two vehicles over time, and when one lost the other."""

from __future__ import annotations

from cli.plot.axes import LABEL, axes_over
from cli.plot.canvas import RED, Box, Canvas, Color
from runner.referee import LOST, Contest
from runner.run_folder import Run
from vencejo.geometry import distance

_LINE: Color = (60, 60, 60)
_NEAR: Color = (222, 240, 222)


def draw_distance(canvas: Canvas, box: Box, run: Run, contest: Contest) -> None:
    """Draw how far a pursuer was from whom it pursued, from the telemetry of a run.

    What counts as near is shaded, and the moments at which the pursuer lost it are red.
    """
    one, other = (run.telemetry.get(name, ()) for name in contest.between)
    far = [(a.time, distance(a.position, b.position)) for a, b in zip(one, other, strict=False)]
    if not far:
        return
    begin, end = far[0][0], max(far[0][0] + 0.1, far[-1][0])
    highest = max(contest.near, *(each for _, each in far))
    axes = axes_over(box, (begin, end), (0.0, 1.05 * highest))
    canvas.rectangle(Box(box.left, axes.y.pixel(contest.near), box.right, box.bottom), _NEAR)
    axes.grid(canvas)
    canvas.line(axes.places(far), _LINE, 1.8)
    pursuer, pursued = contest.between
    losses = [
        entry.time
        for entry in run.events
        if entry.vehicle == pursuer and entry.kind == "event" and entry.fields.get("name") == LOST
    ]
    for time in losses:
        x = axes.x.pixel(time)
        canvas.line([(x, box.top), (x, box.bottom)], RED, 1.4)
    axes.frame(canvas, f"distance of {pursuer} and {pursued}, m; near is up to {contest.near:g} m")
    axes.label_x(canvas)
    axes.label_y(canvas)
    if losses:
        canvas.text((box.right - 6, box.top + 10), "lost from sight", 11, LABEL, "rm")
