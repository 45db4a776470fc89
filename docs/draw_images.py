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
from cli.show import show
from docs.draw_responses import draw_responses
from docs.draw_vision import draw_vision
from fsm import parse_parameters
from fsm.drawing import write_svg
from fsm.engine.instance import Record
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from worlds import World, find_world

IMAGES = Path(__file__).parent / "images"
MOMENT = 11.0
"""Second of the flight that the live view is shown at."""
SPEED = 2.0
GRAPHS = ("beacon_route", "survey_square")
"""Missions whose states are shown."""
WORLDS = (
    *("beacons", "empty", "marker_yard", "meadow", "narrow_road", "pursuit", "road_town"),
    *("search_field", "slalom", "yard"),
)
"""Worlds that are shown; of others the pages of their missions show enough."""
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
    """The state graphs of some shipped missions."""
    for name in GRAPHS:
        graph = prepare(missions.find(name)).graph
        (IMAGES / f"graph_{name}.svg").write_text(write_svg(graph), encoding="utf-8")


def draw_plan_of(name: str) -> None:
    """Where a shipped mission may fly."""
    file = str(IMAGES / f"plan_{name}.png")
    show.main([name, "--plan", file], standalone_mode=False)


def draw_worlds() -> None:
    """Some shipped worlds, each in a file of at most 60 kB."""
    (IMAGES / "worlds").mkdir(exist_ok=True)
    for name in WORLDS:
        path = IMAGES / "worlds" / f"{name}.jpg"
        render(find_world(name), path, at=VIEWS.get(name), shadows=True)
        small = cv2.resize(cv2.imread(str(path)), (480, 360), interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(path), small, [cv2.IMWRITE_JPEG_QUALITY, 88])


def main() -> None:
    """Draw graphs, a plan and worlds; fly first_flight and what sees, and draw that."""
    IMAGES.mkdir(exist_ok=True)
    draw_graphs()
    draw_plan_of("survey_square")
    draw_worlds()
    draw_responses(IMAGES / "responses.png")
    draw_vision()
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
