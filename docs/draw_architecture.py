"""Draws docs/images/architecture.svg from the imports: `python -m docs.draw_architecture`.

The packages stand in the rows of the import contract `layers` of pyproject.toml. Inside those of
:data:`OPENED` each part stands one row above the highest part that it imports.
"""

from __future__ import annotations

import ast
import html
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, permutations
from math import hypot
from pathlib import Path

import grimp

from fsm.drawing.svg import STYLE
from fsm.drawing.widths import text_width

ROOT = Path(__file__).parents[1]
IMAGE = ROOT / "docs" / "images" / "architecture.svg"
OPENED = ("fsm", "hal")
"""The packages whose parts are drawn too: the modules and packages in them."""
LEGEND = (
    "An arrow leads from what imports to what it imports; it is left out where a longer way of "
    "arrows leads there as well.",
    "Arrows inside fsm and hal are between their parts. Dashed: opened by name through an entry "
    "point, so that no other part imports it.",
)

Edges = Mapping[str, frozenset[str]]
"""What each name imports."""
Column = tuple[str, str]
"""What takes up a column of a row: ``(part, "")``, or the arrow from one part to another."""
Rows = Sequence[Sequence[Column]]
XY = tuple[float, float]

WIDTH, MARGIN, GAP = 980.0, 16.0, 32.0
"""Of the picture and between packages; in pixels, as are the following."""
NAME_SIZE, TEXT_SIZE, LINE, PAD = 13.0, 11.0, 15.0, 14.0
PART_HEIGHT, PART_PAD, ROW_HEIGHT = 26.0, 9.0, 64.0
HEAD, SPREAD = 8.0, 10.0
"""The length of an arrow's head, and the distance of arrows that meet at a box."""
_SHORT = 5
"""Columns of a row of which every order is tried."""
CROSSING = 3.0
"""What a crossing of two arrows costs, in columns that an arrow leads sideways."""


# -- the imports -----------------------------------------------------------------------------


@dataclass(frozen=True)
class House:
    """The packages of the repository, the parts of the opened ones, and what they import."""

    rows: Sequence[Sequence[str]]
    """The packages from top to bottom."""
    imports: Edges
    """By full names, of each part and package; of an opened package those of its own module."""
    descriptions: Mapping[str, str]
    """The first line of each package's docstring."""
    entry_points: frozenset[str]
    """The modules that entry points of our own groups name."""

    @property
    def packages(self) -> Edges:
        """The imports between packages."""
        return _joined(self.imports, _package_of)

    def parts(self, package: str) -> Edges:
        """The imports between the parts of an opened package."""
        inside = {name for name in self.imports if name.startswith(f"{package}.")}
        return {name: self.imports[name] & inside for name in sorted(inside)}


def read_house() -> House:
    """The house as it stands in the files."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (layers,) = (contract["layers"] for contract in contracts if contract["name"] == "layers")
    rows = [layer.split(" | ") for layer in layers]
    names = [name for row in rows for name in row]
    graph = grimp.build_graph(*names, cache_dir=None)
    imports = {
        module: frozenset(graph.find_modules_directly_imported_by(module))
        for module in sorted(graph.modules)
    }
    groups = settings["project"]["entry-points"].items()
    points = [points for group, points in groups if group.startswith("vencejo.")]
    return House(
        rows,
        _joined(imports, _part_of),
        {name: _description(ROOT / name / "__init__.py") for name in names},
        frozenset(target.split(":")[0] for each in points for target in each.values()),
    )


def _joined(imports: Edges, name_of: Callable[[str], str]) -> Edges:
    """The imports between larger things, by the name of what each module belongs to."""
    found: dict[str, set[str]] = {}
    for module, others in imports.items():
        found.setdefault(name_of(module), set()).update(map(name_of, others))
    return {name: frozenset(others - {name}) for name, others in found.items()}


def _package_of(module: str) -> str:
    return module.partition(".")[0]


def _part_of(module: str) -> str:
    package = _package_of(module)
    return ".".join(module.split(".")[:2]) if package in OPENED else package


def _description(path: Path) -> str:
    docstring = ast.get_docstring(ast.parse(path.read_text("utf-8"))) or ""
    return docstring.partition("\n")[0]


# -- the arrangement -------------------------------------------------------------------------


def reduced(edges: Edges) -> Edges:
    """The fewest edges from which all others follow: the graph's transitive reduction."""
    return {
        name: others - {further for other in others for further in reachable(edges, other)}
        for name, others in edges.items()
    }


def reachable(edges: Edges, name: str) -> frozenset[str]:
    """All that is reached from a name by one edge or more."""
    found: set[str] = set()
    pending = [name]
    while pending:
        new = edges[pending.pop()] - found
        found |= new
        pending += new
    return frozenset(found)


def arrange(edges: Edges) -> Rows:
    """The rows of parts, the lowest first; an arrow through a row has a column of its own there.

    The order in the rows is changed, one row at a time, as long as that makes arrows shorter or
    takes crossings away.
    """
    height = {name: _height(edges, name) for name in edges}
    rows: list[list[Column]] = [[] for _ in range(max(height.values()) + 1)]
    ways: list[tuple[int, list[Column]]] = []
    for name in sorted(edges):
        rows[height[name]].append((name, ""))
        for other in sorted(edges[name]):
            between = range(height[other] + 1, height[name])
            for row in between:
                rows[row].append((name, other))
            way = [(other, ""), *((name, other) for _ in between), (name, "")]
            ways.append((height[other], way))
    while True:
        tried = [
            [*rows[:row], list(order), *rows[row + 1 :]]
            for row in range(len(rows))
            for order in _orders(rows[row])
        ]
        best = min(tried, key=lambda rows: _cost(rows, ways))
        if _cost(best, ways) >= _cost(rows, ways):
            return rows
        rows = best


def _orders(row: Sequence[Column]) -> Iterator[Sequence[Column]]:
    """Orders of a row to be tried: all of a short one, else those with one column elsewhere."""
    if len(row) <= _SHORT:
        yield from permutations(row)
        return
    for column in row:
        rest = [each for each in row if each != column]
        yield from ([*rest[:k], column, *rest[k:]] for k in range(len(row)))


def _height(edges: Edges, name: str) -> int:
    """The number of edges of the longest way down."""
    return max((_height(edges, other) + 1 for other in edges[name]), default=0)


def _cost(rows: Rows, ways: Sequence[tuple[int, Sequence[Column]]]) -> float:
    """How far arrows lead sideways, in columns, and how often they cross.

    ``ways``: for each arrow its lowest row, and its columns from there upwards.
    """
    places = [
        {column: index - (len(columns) - 1) / 2 for index, column in enumerate(columns)}
        for columns in rows
    ]
    steps: list[list[XY]] = [[] for _ in rows]
    for lowest, way in ways:
        for row, (one, two) in enumerate(pairwise(way), lowest):
            steps[row].append((places[row][one], places[row + 1][two]))
    sideways = sum(abs(one - two) for row in steps for one, two in row)
    pairs = (pair for row in steps for pair in combinations(row, 2))
    return sideways + CROSSING * sum((a[0] - b[0]) * (a[1] - b[1]) < 0 for a, b in pairs)


# -- the picture -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Box:
    """The box of a package or part, from the picture's upper left corner."""

    x: float
    y: float
    width: float
    height: float

    @property
    def right(self) -> float:
        return self.x + self.width

    @property
    def bottom(self) -> float:
        return self.y + self.height

    @property
    def middle(self) -> float:
        return self.x + self.width / 2


def draw(house: House) -> str:
    """The picture of a house, as SVG."""
    arrows = reduced(house.packages)
    inner = {package: reduced(house.parts(package)) for package in OPENED}
    rows = {package: arrange(edges) for package, edges in inner.items()}
    boxes = _packages_placed(house, arrows, rows)
    bottom = max(box.bottom for box in boxes.values()) + GAP
    width, height = f"{WIDTH:g}", f"{bottom + LINE * len(LEGEND):g}"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" role="img">',
        "<title>The packages of Vencejo, and what they import</title>",
        f"<style>{html.escape(STYLE, quote=False)}</style>",
        '<rect class="page" width="100%" height="100%"/>',
    ]
    for name, box in boxes.items():
        lines += _package(name, box, house)
    for name in OPENED:
        head = _head(house.descriptions[name], boxes[name].width)
        lines += _parts(boxes[name], head, rows[name], inner[name], house)
    for name, others in arrows.items():
        lines += [_between(boxes[name], boxes[other]) for other in sorted(others)]
    lines += [_text("more", MARGIN, bottom + LINE * n, line) for n, line in enumerate(LEGEND)]
    return "\n".join([*lines, "</svg>\n"])


def _packages_placed(house: House, arrows: Edges, opened: Mapping[str, Rows]) -> dict[str, Box]:
    """The boxes of the packages.

    A row is as wide as what imports it, so that arrows are vertical, and shared by the number of
    columns that its packages have inside.
    """
    boxes: dict[str, Box] = {}
    y = MARGIN
    for row in house.rows:
        users = [box for name, box in boxes.items() if arrows[name] & {*row}]
        x = min((box.x for box in users), default=MARGIN)
        right = max((box.right for box in users), default=WIDTH - MARGIN)
        columns = [max(map(len, opened[name])) if name in opened else 1 for name in row]
        column = (right - x - GAP * (len(row) - 1)) / sum(columns)
        widths = [column * count for count in columns]
        height = max(
            _head(house.descriptions[name], width) + ROW_HEIGHT * len(opened.get(name, ()))
            for name, width in zip(row, widths, strict=True)
        )
        for name, width in zip(row, widths, strict=True):
            boxes[name] = Box(x, y, width, height)
            x += width + GAP
        y += height + GAP
    return boxes


def _head(description: str, width: float) -> float:
    """The height of a package's name and description."""
    return PAD / 2 + NAME_SIZE + LINE * len(_lines(description, width)) + PAD / 2


def _lines(text: str, width: float) -> list[str]:
    """A text in lines that fit into a box of that width."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".lstrip()
        if text_width(longer, TEXT_SIZE) <= width - 2 * PAD:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def _package(name: str, box: Box, house: House) -> Iterator[str]:
    x, y = box.x + PAD, box.y + PAD / 2 + NAME_SIZE
    imports = house.packages[name] if name in OPENED else house.imports[name]
    yield f"<g>{_title(name, imports)}{_rect('box', box)}{_text('name', x, y, name)}"
    for index, line in enumerate(_lines(house.descriptions[name], box.width), 1):
        yield _text("more", x, y + LINE * index, line)
    yield "</g>"


def _parts(package: Box, head: float, rows: Rows, arrows: Edges, house: House) -> Iterator[str]:
    """The parts of an opened package, its lowest row at the bottom, and the arrows between them."""
    across = (package.width - PAD) / max(map(len, rows))
    down = (package.height - head) / len(rows)
    boxes: dict[str, Box] = {}
    passed: dict[Column, list[XY]] = {}
    for row, columns in enumerate(rows):
        y = package.bottom - PAD - PART_HEIGHT - down * row
        for index, (part, other) in enumerate(columns):
            x = package.middle + across * (index - (len(columns) - 1) / 2)
            if other:
                passed[part, other] = [(x, y), (x, y + PART_HEIGHT), *passed.get((part, other), ())]
            else:
                width = text_width(_short(part), TEXT_SIZE) + 2 * PART_PAD
                boxes[part] = Box(x - width / 2, y, width, PART_HEIGHT)
    for part, box in boxes.items():
        by_name = any(f"{point}.".startswith(f"{part}.") for point in house.entry_points)
        rect = _rect("leaf apart" if by_name else "leaf", box)
        text = _text("label", box.middle, box.y + 17, _short(part), ' text-anchor="middle"')
        yield f"<g>{_title(part, house.imports[part])}{rect}{text}</g>"
    ways = []
    for part, others in arrows.items():
        for other in sorted(others):
            start, end = boxes[part], boxes[other]
            between = passed.get((part, other), ())
            ways.append([(start.middle, start.bottom), *between, (end.middle, end.y)])
    yield from map(_arrow, _spread(ways))


def _short(part: str) -> str:
    return part.rpartition(".")[2]


def _spread(ways: Sequence[Sequence[XY]]) -> Iterator[list[XY]]:
    """The ways of arrows, those that meet at a box a little apart, in the order they come from."""
    meeting: dict[XY, list[XY]] = {}
    for way in ways:
        meeting.setdefault(way[0], []).append(way[1])
        meeting.setdefault(way[-1], []).append(way[-2])
    for others in meeting.values():
        others.sort()

    def apart(end: XY, next_: XY) -> XY:
        others = meeting[end]
        return end[0] + SPREAD * (others.index(next_) - (len(others) - 1) / 2), end[1]

    for way in ways:
        yield [apart(way[0], way[1]), *way[1:-1], apart(way[-1], way[-2])]


def _between(one: Box, two: Box) -> str:
    """The vertical arrow from one package to one below it, in the middle of where both are."""
    x = (max(one.x, two.x) + min(one.right, two.right)) / 2
    return _arrow([(x, one.bottom), (x, two.y)])


def _arrow(way: Sequence[XY]) -> str:
    (x, y), tip = way[-2:]
    length = hypot(tip[0] - x, tip[1] - y)
    dx, dy = HEAD * (tip[0] - x) / length, HEAD * (tip[1] - y) / length
    x, y = tip[0] - dx, tip[1] - dy
    line = " L".join(map(_xy, [*way[:-1], (x, y)]))
    left, right = (x + dy / 2, y - dx / 2), (x - dy / 2, y + dx / 2)
    head = " L".join(map(_xy, [tip, left, right]))
    return f'<path class="line" d="M{line}"/><path class="head" d="M{head} Z"/>'


def _title(name: str, imports: frozenset[str]) -> str:
    """What a browser shows when the pointer rests on a box: all that it imports."""
    return f"<title>{name} imports {', '.join(sorted(imports)) or 'nothing of ours'}</title>"


def _rect(kind: str, box: Box) -> str:
    x, y = _xy((box.x, box.y)).split()
    size = f'width="{box.width:.1f}" height="{box.height:.1f}"'
    return f'<rect class="{kind}" x="{x}" y="{y}" {size} rx="6"/>'


def _text(kind: str, x: float, y: float, text: str, more: str = "") -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}"{more}>{html.escape(text)}</text>'


def _xy(point: XY) -> str:
    return f"{point[0]:.1f} {point[1]:.1f}"


def main() -> None:
    """Draw the house as it stands."""
    IMAGE.write_text(draw(read_house()), encoding="utf-8")


if __name__ == "__main__":
    main()
