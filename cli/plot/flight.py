"""The picture of a run: the path from above in its world, and its figures over time.

Made from the run folder's files alone, so that a run that was killed has one too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from math import hypot
from pathlib import Path
from typing import NamedTuple, TypeVar

from cli.plot.axes import LABEL, axes_from_above, axes_over
from cli.plot.canvas import RED, WHITE, XY, Box, Canvas, Color, fitted, text_width
from cli.plot.distance import draw_distance
from cli.plot.ground import draw_world, mark_start
from cli.plot.lanes import Lane, lanes_of, states_of
from cli.vehicle_colors import vehicle_colors
from hal import PERIOD, Position, Velocity
from runner.run_folder import PICTURE, Flown, Run, read_run
from runner.telemetry import Sample
from vencejo.errors import UserError, Where, cannot_write
from vencejo.files import write_whole
from vencejo.geometry import Point
from worlds import World, load_world

Value = TypeVar("Value", float, Point)
_WIDTH = 1280
_MAP = Box(58, 62, 588, 592)
_LEFT, _RIGHT = 652, _WIDTH - 16
_ALTITUDE, _SPEED, _BATTERY = (
    Box(_LEFT, top, _RIGHT, bottom) for top, bottom in ((62, 262), (292, 412), (442, 502))
)
_LANES = 532
"""The top of the lanes of states."""
_LANE = 20
_ROW = 20
"""Height of a row of the legend."""
_DISTANCES = 130
"""Height of the panel of a referee."""
_SWATCH = 24
_MOST_POINTS = 3000
"""Of one line: more cannot be told apart."""
COLORS: Sequence[Color] = (
    *((31, 119, 180), (255, 127, 14), (44, 160, 44), (148, 103, 189), (140, 86, 75)),
    *((227, 119, 194), (23, 190, 207), (188, 189, 34), (0, 96, 100), (106, 90, 205)),
)
_TOLD: Color = (90, 90, 90)
_TOLD_NAME = "set-points"
_TOLD_STEP = 3.0
"""Pixels between points of a set-points' line: dashes that short take long to draw."""


@dataclass(frozen=True)
class Flight:
    """The flight of one vehicle while its mission ran, and the colours it is drawn in."""

    vehicle: str
    samples: Sequence[Sample]
    lanes: Sequence[Lane]
    collisions: Sequence[tuple[Sample, str]]
    """The vehicle's state at the beginning of each, and the name of the thing."""


def flights_of(run: Run) -> list[Flight]:
    """The flights of all vehicles that have flown."""
    found = []
    for vehicle, telemetry in run.telemetry.items():
        samples = [sample for sample in telemetry if sample.states]  # none: the mission has ended
        if samples:
            hits = _collisions(run, vehicle, telemetry)
            found.append(Flight(vehicle, samples, lanes_of(samples), hits))
    return found


def _collisions(run: Run, vehicle: str, telemetry: Sequence[Sample]) -> list[tuple[Sample, str]]:
    found = []
    for entry in run.events:
        fields = entry.fields
        if (entry.vehicle, entry.kind, fields.get("name")) == (vehicle, "event", _COLLISION):
            sample = min(telemetry, key=lambda sample: abs(sample.time - entry.time))
            found.append((sample, str(fields.get("fields", {}).get("thing", ""))))
    return found


_COLLISION = "vehicle.collision"


def draw(folder: Path) -> Path:
    """Draw a run into its folder; the picture's path. Raises UserError."""
    run = read_run(folder)
    flights = flights_of(run)
    if not flights:
        message = "nothing was flown: the mission ended at once"
        raise UserError("no-run", message, Where(str(folder)))
    path = folder / PICTURE
    try:
        write_whole(path, picture(run, flights, world_of(run)))
    except OSError as error:
        message = "this picture cannot be written"
        raise cannot_write(error, "cannot-write", message, Where(str(path))) from None
    return path


def world_of(run: Run) -> World | None:
    """The world of a run as its folder keeps it; None where it is not there or not readable."""
    kept = run.header.settings
    paths = [run.folder / kept.world] if kept else sorted(run.folder.glob("*.yaml"))
    for path in paths:
        with suppress(UserError, OSError):
            world = load_world(path)
            if world.sha256 == run.header.world_sha256:
                return world
    return None


def picture(run: Run, flights: Sequence[Flight], world: World | None) -> bytes:
    """The picture as PNG."""
    # What is told apart by colour: the states of one vehicle, or the vehicles.
    alone = len(flights) == 1
    if alone:
        told = states_of(flights[0].lanes)
        colors = {name: COLORS[number % len(COLORS)] for number, name in enumerate(told)}
    else:
        told = [flight.vehicle for flight in flights]
        hulls = {vehicle: run.header.missions[vehicle].color for vehicle in told}
        colors = vehicle_colors(hulls, COLORS)
    lanes = [lane for flight in flights for lane in flight.lanes]
    lanes_end = _LANES + _LANE * len(lanes)
    has_setpoints = any(sample.setpoint for flight in flights for sample in flight.samples)
    legend = _legend_rows([*told, _TOLD_NAME] if has_setpoints else told)
    contest = run.header.settings.referee if run.header.settings else None
    top = max(_MAP.bottom, lanes_end) + 44
    if contest is not None:
        distances = Box(_MAP.left, top + 22, _RIGHT, top + 22 + _DISTANCES)
        top = distances.bottom + 44
    canvas = Canvas(_WIDTH, round(top + _ROW * len(legend) + 8))
    _draw_map(canvas, flights, world, colors)
    _draw_figures(canvas, flights, colors)
    _draw_lanes(canvas, flights, colors)
    if contest is not None:
        draw_distance(canvas, distances, run, contest)
    for number, row in enumerate(legend):
        for left, name in row:
            middle = top + _ROW * number + _ROW / 2
            if name in colors:
                swatch = Box(left, middle - 5, left + 16, middle + 5)
                canvas.rectangle(swatch, colors[name])
            else:
                canvas.dashes([(left - 2, middle), (left + 18, middle)], _TOLD, 1.5)
            canvas.text((left + _SWATCH, middle), name)
    _draw_title(canvas, run)
    return canvas.png()


def _draw_title(canvas: Canvas, run: Run) -> None:
    flown = dict.fromkeys(mission.name for mission in run.header.missions.values() if mission.name)
    title = f"{run.header.fleet or ', '.join(flown)} in {run.header.world}"
    canvas.text((_MAP.left, 22), title, 18)
    left = _MAP.left + text_width(title, 18) + 16
    if run.summary is None:
        canvas.text((left, 23), "cut off", 14, RED)
        return
    vehicles = run.summary.vehicles
    color = LABEL if all(each.outcome == "done" for each in vehicles.values()) else RED
    canvas.text((left, 23), fitted(_ends(vehicles), _RIGHT - left, 14), 14, color)


def _ends(vehicles: Mapping[str, Flown]) -> str:
    """How the vehicles ended; said once, where all ended alike."""
    ends = {
        name: f"{flown.outcome}{f' ({flown.reason})' if flown.reason else ''}"
        for name, flown in vehicles.items()
    }
    if len(set(ends.values())) == 1:
        return next(iter(ends.values()))
    return ", ".join(f"{name}: {end}" for name, end in ends.items())


def _legend_rows(names: Iterable[str]) -> list[list[tuple[float, str]]]:
    """Names by rows, each with its left end; a row is as wide as the picture."""
    rows: list[list[tuple[float, str]]] = [[]]
    left = _MAP.left
    for name in names:
        width = _SWATCH + text_width(name) + 18
        if rows[-1] and left + width > _RIGHT:
            rows.append([])
            left = _MAP.left
        rows[-1].append((left, name))
        left += width
    return rows


# -- the map ---------------------------------------------------------------------------------------


def _draw_map(
    canvas: Canvas, flights: Sequence[Flight], world: World | None, colors: dict[str, Color]
) -> None:
    paths = [[_from_above(sample) for sample in flight.samples] for flight in flights]
    axes = axes_from_above(_MAP, [place for path in paths for place in path], 0.18, 8.0)
    axes.grid(canvas, y_spacing=60)
    if world is not None:
        draw_world(canvas, axes, world)
    for flight, path in zip(flights, paths, strict=True):
        for color, part in _colored(flight, colors):
            canvas.line(_thinned(axes.places(map(_from_above, part))), color, 2.2)
        for told in _runs_of(flight, _told_place):
            places = axes.near(((x, y) for _, (x, y, _) in told), 20)
            canvas.dashes(_apart(places, _TOLD_STEP), _TOLD)
        mark_start(canvas, axes.place(*path[0]))
        for sample, thing in flight.collisions:
            place = axes.place(*_from_above(sample))
            _mark_collision(canvas, place)
            canvas.text((place[0] + 9, place[1] - 8), thing, 12, RED)
    canvas.erase_outside(_MAP)
    axes.frame(canvas, "path from above, north up; metres")
    axes.label_x(canvas)
    axes.label_y(canvas, 60)


def _mark_collision(canvas: Canvas, place: XY) -> None:
    x, y = place
    for turn in (1, -1):
        canvas.line([(x - 5, y - 5 * turn), (x + 5, y + 5 * turn)], RED, 2.5)


def _from_above(sample: Sample) -> XY:
    return sample.position.x, sample.position.y


# -- set-points ------------------------------------------------------------------------------------


def _runs_of(
    flight: Flight, value: Callable[[Sample], Value | None]
) -> Iterator[list[tuple[float, Value]]]:
    """Time and value of a set-point, by the stretches of the flight in which there is one."""
    stretch: list[tuple[float, Value]] = []
    for sample in flight.samples:
        told = value(sample)
        if told is not None:
            stretch.append((sample.time, told))
        elif stretch:
            yield stretch
            stretch = []
    if stretch:
        yield stretch


def _told_place(sample: Sample) -> Point | None:
    return sample.setpoint.xyz if isinstance(sample.setpoint, Position) else None


def _told_altitude(sample: Sample) -> float | None:
    return sample.setpoint.xyz.z if isinstance(sample.setpoint, Position) else None


def _told_speed(sample: Sample) -> float | None:
    told = sample.setpoint
    if isinstance(told, Velocity):
        return Point(told.x, told.y, told.z).norm()
    if isinstance(told, Position) and told.velocity is not None:
        return told.velocity.norm()
    return None


def _told_nothing(sample: Sample) -> None:
    return None


# -- figures over time -----------------------------------------------------------------------------


class _Panel(NamedTuple):
    """Figures over time: what was flown, and what was commanded."""

    box: Box
    title: str
    range_: tuple[float, float]
    flown: Callable[[Sample], float]
    told: Callable[[Sample], float | None]
    spacing: int = 34
    """Pixels between the ticks of its scale, at least."""


def _draw_figures(canvas: Canvas, flights: Sequence[Flight], colors: dict[str, Color]) -> None:
    samples = [sample for flight in flights for sample in flight.samples]
    span = _span(samples)
    heights = [sample.position.z for sample in samples]
    margin = 0.08 * max(1.0, max(heights) - min(heights))
    low = 0.0 if min(heights) > -margin else min(heights) - margin
    top = 1.1 * max(1.0, *map(_speed, samples))
    panels = (
        _Panel(_ALTITUDE, "altitude, m", (low, max(heights) + margin), _altitude, _told_altitude),
        _Panel(_SPEED, "speed, m/s", (0.0, top), _speed, _told_speed),
        _Panel(_BATTERY, "battery, %", (0.0, 104.0), _battery, _told_nothing, 24),
    )
    for box, title, range_, value, told_value, spacing in panels:
        axes = axes_over(box, span, range_)
        axes.grid(canvas, y_spacing=spacing)
        for flight in flights:
            for color, part in _colored(flight, colors):
                line = [(sample.time, value(sample)) for sample in part]
                canvas.line(_thinned(axes.places(line)), color, 1.8)
            for told in _runs_of(flight, told_value):
                canvas.dashes(_apart(axes.near(told, 0), _TOLD_STEP), _TOLD)
            for sample, _ in flight.collisions:
                x = axes.x.pixel(sample.time)
                canvas.line([(x, box.top), (x, box.bottom)], RED, 1.2)
        axes.frame(canvas, title)
        axes.label_y(canvas, spacing)


def _draw_lanes(canvas: Canvas, flights: Sequence[Flight], colors: dict[str, Color]) -> None:
    """The states over time, named where a bar has room for its name."""
    lanes = [(flight, lane) for flight in flights for lane in flight.lanes]
    box = Box(_LEFT, _LANES, _RIGHT, _LANES + _LANE * len(lanes))
    span = _span([sample for flight in flights for sample in flight.samples])
    axes = axes_over(box, span, (0.0, 1.0))
    for number, (flight, lane) in enumerate(lanes):
        top = box.top + _LANE * number
        if len(flights) > 1:
            canvas.text((box.left - 5, top + _LANE / 2), flight.vehicle, 11, LABEL, "rm")
        for bar in lane:
            ends = axes.x.pixel(bar.begin), axes.x.pixel(bar.end)
            color = colors[bar.state if len(flights) == 1 else flight.vehicle]
            canvas.rectangle(Box(ends[0], top, ends[1], top + _LANE), _light(color), WHITE)
            name = _fitting(bar.state, ends[1] - ends[0] - 6)
            canvas.text((ends[0] + 4, top + _LANE / 2), name, 11)
    axes.frame(canvas, "states; time, s")
    axes.label_x(canvas)


def _fitting(state: str, width: float) -> str:
    """A state's path, or the end of it, as far as there is room; else nothing."""
    names = state.split(".")
    shown = (".".join(names[first:]) for first in range(len(names)))
    return next((name for name in shown if text_width(name, 11) <= width), "")


def _light(color: Color) -> Color:
    red, green, blue = (255 - (255 - part) * 2 // 5 for part in color)
    return red, green, blue


def _altitude(sample: Sample) -> float:
    return sample.position.z


def _speed(sample: Sample) -> float:
    return sample.velocity.norm()


def _battery(sample: Sample) -> float:
    return 100 * sample.battery


def _span(samples: Sequence[Sample]) -> tuple[float, float]:
    first = min(sample.time for sample in samples)
    return first, max(first + 0.1, *(sample.time + PERIOD for sample in samples))


def _colored(flight: Flight, colors: dict[str, Color]) -> Iterator[tuple[Color, Sequence[Sample]]]:
    """The parts of a flight in one colour; each begins where the last one ends."""
    if flight.vehicle in colors:
        yield colors[flight.vehicle], flight.samples
        return
    last: list[Sample] = []
    bars = iter(flight.lanes[0])
    bar = next(bars)

    def state(sample: Sample) -> str:
        nonlocal bar
        while sample.time >= bar.end and (following := next(bars, None)) is not None:
            bar = following
        return bar.state

    for name, group in groupby(flight.samples, state):
        part = list(group)
        yield colors[name], [*last, *part]
        last = part[-1:]


def _thinned(places: Sequence[XY]) -> Sequence[XY]:
    """The places of a line without those that change nothing to be seen."""
    return places if len(places) <= _MOST_POINTS else _apart(places, 0.5)


def _apart(places: Sequence[XY], least: float) -> Sequence[XY]:
    """The first and last place, and of those between some that are ``least`` pixels apart."""
    kept = [places[0]]
    for place in places:
        if hypot(place[0] - kept[-1][0], place[1] - kept[-1][1]) >= least:
            kept.append(place)
    return [*kept, places[-1]]
