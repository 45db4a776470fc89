"""Draws the pictures of the README and the guides: `make images`."""

from __future__ import annotations

import io
from collections.abc import Sequence
from math import radians
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
from rich.console import Console

from behaviors import Pilot
from cli.live_view import LiveView
from cli.look import render
from cli.plot import draw
from cli.plot.plan import Planned, draw_plan
from docs.draw_landings import draw_landings
from docs.draw_pictures import draw_pictures
from docs.draw_pursuit import draw_pursuit
from docs.draw_responses import draw_responses
from docs.draw_roads import draw_roads
from docs.draw_sweep import draw_sweep
from docs.draw_tags import draw_tags
from fsm import parse_parameters
from fsm.drawing import write_svg
from fsm.engine.instance import Record
from runner import missions
from runner.by_vehicle import ALONE
from runner.fleets import plans_of
from runner.geometry import Terms
from runner.loop import fly
from runner.plan import Assignment, Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from runner.vehicle_models import flight_of, models_of
from worlds import World, find_world, world_names

IMAGES = Path(__file__).parent / "images"
MOMENT = 11.0
"""Second of the flight that the live view is shown at."""
SPEED = 2.0
VIEWS = {
    "beacons": (-4.5, -6.5, 3.2, radians(55)),
    "empty": (-1.0, -1.2, 0.5, radians(50)),
    "search_field": (8.5, 16.5, 1.9, radians(40)),
}
"""Places from which worlds are shown whose things are small, and the heading there, radians."""


class _Snapshot:
    """Prints the live view of one moment."""

    def __init__(self, console: Console, world: World) -> None:
        self.console = console
        self.wall = 0.0
        unseen = Console(file=io.StringIO(), force_terminal=True)
        self.view = LiveView(unseen, world, SPEED, lambda: self.wall)
        self.taken = False

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        self.wall = pilot.channel.now / SPEED
        self.view.show(pilot, records)
        if pilot.channel.now >= MOMENT and not self.taken:
            self.taken = True
            self.console.print(self.view.picture(*self.console.size), end="")


def draw_graphs() -> None:
    """The state graphs of the shipped missions."""
    for path in sorted(missions.SHIPPED.glob("*.yaml")):
        graph = prepare(missions.Found(path, path.name)).graph
        (IMAGES / f"graph_{path.stem}.svg").write_text(write_svg(graph), encoding="utf-8")


def draw_plan_of(name: str) -> None:
    """Where a shipped mission may fly."""
    prepared = prepare(missions.find(name))
    flown = {ALONE: Assignment(prepared, parse_parameters(prepared.graph, {}))}
    model = models_of("sim", flown)[ALONE]
    (each,) = plans_of(flown, {ALONE: Terms(flight_of("sim", model))}).values()
    title = f"{name} in {prepared.world.name}"
    data = draw_plan(title, prepared.world, [Planned("", prepared.graph, each)])
    (IMAGES / f"plan_{name}.png").write_bytes(data)


def draw_worlds() -> None:
    """The shipped worlds, each in a file of at most 60 kB."""
    (IMAGES / "worlds").mkdir(exist_ok=True)
    for name in world_names():
        path = IMAGES / "worlds" / f"{name}.jpg"
        render(find_world(name), path, at=VIEWS.get(name), shadows=True)
        small = cv2.resize(cv2.imread(str(path)), (480, 360), interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(path), small, [cv2.IMWRITE_JPEG_QUALITY, 88])


def main() -> None:
    """Draw the graph of every shipped mission, a plan and every world; fly first_flight and draw
    that.
    """
    IMAGES.mkdir(exist_ok=True)
    draw_graphs()
    draw_plan_of("survey_square")
    draw_worlds()
    draw_responses(IMAGES / "responses.png")
    draw_tags()
    draw_sweep(IMAGES / "vision" / "sweep_detect.jpg")
    draw_landings()
    draw_pictures()
    draw_roads()
    draw_pursuit(IMAGES / "vision" / "pursue.jpg")
    prepared = prepare(missions.find("first_flight"))
    plan = Plan.alone(prepared, parse_parameters(prepared.graph, {}))
    console = Console(record=True, width=96, height=28, file=io.StringIO(), force_terminal=True)
    snapshot = _Snapshot(console, plan.world)
    with TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder))
        recorder.write_summary(fly(plan, lambda: recorder, [snapshot]))
        draw(Path(folder)).replace(IMAGES / "first_flight.png")
    console.save_svg(str(IMAGES / "live.svg"), title="drone-cli run first_flight --speed 2")


if __name__ == "__main__":
    main()
