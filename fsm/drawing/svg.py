"""Writes a diagram as SVG, without scripts or fonts of its own, for light and dark pages."""

from __future__ import annotations

import html
from collections.abc import Collection, Iterator, Sequence
from itertools import pairwise

from fsm.chart.graph import Graph
from fsm.drawing.diagram import XY, Box, Diagram, Line
from fsm.drawing.inside import LABEL_SIZE, LINE_HEIGHT, LINE_SIZE, NAME_SIZE, PAD
from fsm.drawing.layout import draw
from vencejo.markup import ILLEGAL

ROUND = 6.0
Segment = tuple[str, XY, XY]
"""A straight piece of a line: the path of the line's target, and the two ends."""
STYLE = f"""\
text {{ font-family: system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; fill: #1f2933; }}
.name {{ font-size: {NAME_SIZE:g}px; font-weight: bold; }}
.more, .label {{ font-size: {LINE_SIZE:g}px; fill: #52606d; }}
.label {{ font-size: {LABEL_SIZE:g}px; fill: #334e68; }}
.page {{ fill: #ffffff; }}
.box {{ fill: #f5f7fa; stroke: #7b8794; }}
.even {{ fill: #ffffff; }}
.leaf {{ fill: #e4ecf4; stroke: #486581; }}
.ring {{ fill: none; stroke: #486581; }}
.line {{ fill: none; stroke: #486581; stroke-width: 1.3; }}
.dot, .head {{ fill: #486581; }}
.apart {{ stroke: #7b8794; stroke-dasharray: 6 4; }}
.active {{ fill: #ffe8a3; stroke: #b7791f; stroke-width: 2; }}
@media (prefers-color-scheme: dark) {{
text {{ fill: #e4e7eb; }} .more {{ fill: #b0bcc8; }} .label {{ fill: #c3d3e3; }}
.page {{ fill: #14191f; }} .box {{ fill: #1d242c; stroke: #66788a; }} .even {{ fill: #161c22; }}
.leaf {{ fill: #273644; stroke: #829ab1; }}
.ring, .line {{ stroke: #9fb3c8; }} .ring, .line {{ fill: none; }} .dot, .head {{ fill: #9fb3c8; }}
.active {{ fill: #5c4813; stroke: #f0b429; }}
}}"""


def write_svg(graph: Graph) -> str:
    """The graph's diagram as an SVG file."""
    return render(draw(graph))


def render(diagram: Diagram, active: Collection[str] = ()) -> str:
    """A diagram as SVG; ``active`` are the paths of states to highlight."""
    width, height = f"{diagram.width:g}", f"{diagram.height:g}"
    drawn: set[Segment] = set()
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'viewBox="0 0 {width} {height}" role="img">',
            f"<title>{_escape(diagram.name)}</title>",
            f"<desc>{_escape(diagram.description)}</desc>",
            f"<style>{html.escape(STYLE, quote=False)}</style>",
            '<rect class="page" width="100%" height="100%"/>',
            *(part for box in diagram.boxes for part in _box(box, box.path in active)),
            *(
                f'<path class="apart" d="M{_xy(one)} L{_xy(two)}"/>'
                for one, two in diagram.separators
            ),
            *(part for line in diagram.lines for part in _line(line, drawn)),
            "</svg>\n",
        ]
    )


def _box(box: Box, active: bool) -> Iterator[str]:
    leaf = box.kind in ("atomic", "final", "history")
    kind = "box leaf" if leaf else "box even" if box.depth % 2 else "box"
    kind += " active" if active else ""
    yield f'<g data-state="{_escape(box.path)}"><title>{_escape(box.title)}</title>'
    if box.kind == "history":
        x, y, radius = box.x + box.width / 2, box.y + box.height / 2, box.width / 2
        yield f'<circle class="{kind}" cx="{x:g}" cy="{y:g}" r="{radius:g}"/>'
        yield _text("more", x, y + 4, box.name, ' text-anchor="middle"')
        yield "</g>"
        return
    yield _rect(kind, box, 0)
    if box.kind == "final":
        yield _rect("ring", box, 3)
    y = box.y + 8 + 13
    yield _text("name", box.x + PAD, y, box.name)
    for index, line in enumerate(box.lines):
        yield _text("more", box.x + PAD, y + 3 + LINE_HEIGHT * (index + 1) - 1, line)
    yield "</g>"


def _rect(kind: str, box: Box, inset: float) -> str:
    return (
        f'<rect class="{kind}" x="{box.x + inset:g}" y="{box.y + inset:g}" '
        f'width="{box.width - 2 * inset:g}" height="{box.height - 2 * inset:g}" '
        f'rx="{8 - inset:g}"/>'
    )


def _text(kind: str, x: float, y: float, text: str, more: str = "") -> str:
    return f'<text class="{kind}" x="{x:g}" y="{y:g}"{more}>{_escape(text)}</text>'


def _line(line: Line, drawn: set[Segment]) -> Iterator[str]:
    yield f"<g><title>{_escape(line.title)}</title>"
    if line.dot:
        x, y = line.points[0]
        yield f'<circle class="dot" cx="{x:g}" cy="{y - 5:g}" r="5"/>'
    (x, y), up = line.points[-1], line.points[-1][1] < line.points[-2][1]
    base = y + 8 if up else y - 8
    own = _own(line.target, [*line.points[:-1], (x, base)], drawn)
    yield f'<path class="line" d="{_curve(own)}"/>'
    yield f'<path class="head" d="M{x:g} {y:g} L{x - 4:g} {base:g} L{x + 4:g} {base:g} Z"/>'
    if line.label:
        for index, text in enumerate(line.label.lines):
            bottom = line.label.y + LINE_HEIGHT * (index + 1) - 4
            yield _text("label", line.label.x, bottom, text)
    yield "</g>"


def _own(target: str, points: Sequence[XY], drawn: set[Segment]) -> Sequence[XY]:
    """The part of a line up to where it joins another, drawn already, to the same target."""
    for index, (one, two) in enumerate(pairwise(points)):
        if (target, one, two) in drawn:
            # A little of that piece as well: what is drawn twice looks thicker.
            return [*points[: index + 1], _along(one, two, min(2 * ROUND, _length(one, two) / 2))]
        drawn.add((target, one, two))
    return points


def _escape(text: str) -> str:
    """The text escaped for XML; letters that XML does not allow become U+FFFD."""
    return html.escape(ILLEGAL.sub("\ufffd", text))


def _curve(points: Sequence[XY]) -> str:
    """A polyline with rounded corners."""
    parts = [f"M{_xy(points[0])}"]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        radius = min(ROUND, _length(before, corner) / 2, _length(corner, after) / 2)
        start, end = _along(corner, before, radius), _along(corner, after, radius)
        parts.append(f"L{_xy(start)} Q{_xy(corner)} {_xy(end)}")
    parts.append(f"L{_xy(points[-1])}")
    return " ".join(parts)


def _length(one: XY, two: XY) -> float:
    return abs(one[0] - two[0]) + abs(one[1] - two[1])


def _along(start: XY, end: XY, far: float) -> XY:
    length = _length(start, end) or 1.0
    return (
        start[0] + (end[0] - start[0]) * far / length,
        start[1] + (end[1] - start[1]) * far / length,
    )


def _xy(point: XY) -> str:
    return f"{point[0]:g} {point[1]:g}"
