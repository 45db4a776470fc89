"""The live view on terminals of many sizes, read from their screens."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import struct
import sys
import termios
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import pyte
import pytest

from behaviors import Pilot
from cli.live_view import TWO_COLUMNS, LiveView
from cli.screen import Screen
from fsm.engine.instance import Record
from runner import Plan, fly, missions, prepare
from tests.cli.run_cli import WALL
from tests.cli.terminal import Terminal
from vencejo import VehicleError

SIZES = [(40, 15), (40, 24), (60, 20), (80, 24), (120, 40), (180, 50)]


class Watch:
    """Has a flight shown in the time of its own clock.

    Each of ``looks`` is called once, with the first picture after its time. A second of wall time
    is ``speed`` seconds of flight, and has ten pictures.
    """

    def __init__(self, terminal: Terminal, plan: Plan, speed: float = 20.0) -> None:
        self.speed = speed
        self.terminal = terminal
        self.wall = 0.0
        names = list(plan.assignments)
        self.view = LiveView(terminal.console, plan.world, speed, lambda: self.wall, vehicles=names)
        self.looks: dict[float, Callable[[], None]] = {}

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        now = pilot.channel.now
        self.wall = now / self.speed
        before = self.terminal.written
        self.view.show(pilot, records)
        if self.terminal.written > before:
            for moment in [moment for moment in self.looks if moment <= now]:
                self.looks.pop(moment)()


def plan_of(folder: Path, text: str, world: str | None = None) -> Plan:
    path = folder / "mission.yaml"
    path.write_text(text)
    return Plan.alone(prepare(missions.find(str(path)), world))


def watch(
    terminal: Terminal, plan: Plan, looks: Mapping[float, Callable[[], None]] | None = None
) -> None:
    """Fly to the end; ``looks`` are called at times of the flight."""
    watched = Watch(terminal, plan)
    watched.looks.update(looks or {})
    with watched.view:
        fly(plan, None, [watched])
    assert not watched.looks, "the flight was over before"


def first_flight() -> Plan:
    return Plan.alone(prepare(missions.find("first_flight")))


@pytest.mark.parametrize(("columns", "rows"), SIZES)
def test_everything_is_there_at_every_size(columns: int, rows: int) -> None:
    terminal = Terminal(columns, rows)

    def look() -> None:
        screen = "\n".join(terminal.lines)
        assert terminal.lines[0].startswith(" first_flight   0:0")
        assert "altitude  2.0 m" in screen
        assert re.search(r"speed  1\.\d m/s", screen)
        assert "battery  99%" in screen
        assert re.search(r"\b20(\.\d+)? × real time", screen)
        assert re.search(r"^▶ square.north [0-2]\.\d s$", screen, re.MULTILINE)
        assert re.search(r"^  ▶ north  goto  [0-2]\.\d s", screen, re.MULTILINE)
        assert terminal.colors_of("▶ north") == {"green"}
        assert " 0:05.7  → square.north (done)" in screen
        assert rows == 15 or terminal.lines.index("─" * columns) >= rows - 11, "it is filled"
        title = terminal.row_of("north up") if rows > 15 else None
        if title is not None:
            assert "┤ " in terminal.lines[title] and terminal.lines[title].endswith(" m")
            assert (title > terminal.row_of("▶ north")) == (columns < TWO_COLUMNS)
            map_ = terminal.lines[title:]
            assert any("◦gate" in line for line in map_)
            assert any("◦table_top" in line for line in map_)
            assert any("↑" in line or "↗" in line for line in map_), "it turns to the north"
            assert terminal.colors_of("◦gate") == {"brown"}
            braille = {c for line in map_ for c in line if 0x2800 < ord(c) < 0x2900}
            assert len(braille) > 5, "the outlines of the world, and the path"

    watch(terminal, first_flight(), {7.0: look})


def test_the_map_takes_the_room_there_is() -> None:
    terminal = Terminal(180, 50)

    def look() -> None:
        title = terminal.lines[terminal.row_of("north up")]
        assert title.index("from above") == 62
        wall = terminal.row_of("⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀")
        assert terminal.row_of("table_top") - wall > 24

    watch(terminal, first_flight(), {6.0: look})


def test_no_debris_after_resizing() -> None:
    """What is on the screen is what a new terminal of that size would show."""
    terminal = Terminal(120, 40)
    plan = first_flight()
    watched = Watch(terminal, plan, speed=8.0)

    def look() -> None:
        fresh = Terminal(terminal.screen.columns, terminal.screen.lines)
        size = fresh.screen.columns, fresh.screen.lines
        Screen(fresh.console).paint(watched.view.picture(*size))
        assert fresh.row_of("first_flight") == 0
        assert terminal.lines == fresh.lines

    def resize(columns: int, rows: int) -> None:
        terminal.resize(columns, rows)
        watched.looks[watched.wall] = look  # with the next picture

    for number, size in enumerate([(40, 15), (100, 20), (60, 50), (41, 15), (150, 45), (80, 24)]):
        watched.looks[1.0 + 2.5 * number] = partial(resize, *size)
    with watched.view:
        fly(plan, None, [watched])
    assert not watched.looks
    assert "✔ ended in 'done'" in "\n".join(terminal.lines)


@pytest.mark.parametrize(("columns", "rows"), SIZES)
def test_reasons_collisions_and_how_it_ended(columns: int, rows: int, tmp_path: Path) -> None:
    terminal = Terminal(columns, rows)

    def after_collision() -> None:
        assert terminal.colors_of("collision with shed") == {"red"}

    def on_the_way_home() -> None:
        if rows > 15:
            first, rule = terminal.row_of("north up"), terminal.row_of("─" * columns)
            assert "x" in "".join(terminal.lines[first + 1 : rule]), "the place of the collision"
        told = " ".join(" ".join(terminal.lines[-8:]).split())
        assert "→ home (blocked: came no nearer for 15 s)" in told

    watch(terminal, plan_of(tmp_path, WALL), {9.0: after_collision, 22.5: on_the_way_home})
    screen = "\n".join(terminal.lines)
    assert screen.count("wall   0:2") == 1, "one picture, and nothing left of those before"
    assert terminal.row_of("wall   0:2") == 0
    assert screen.count("✘ ended in 'gave_up'") == 1
    assert terminal.colors_of("✘ ended in 'gave_up'") == {"red"}
    assert "(done)" in screen
    assert terminal.lines[-5:] == [""] * 5, "room for the summary"
    assert not terminal.screen.cursor.hidden
    assert terminal.screen.cursor.x == 0


@pytest.mark.parametrize(("columns", "rows"), SIZES)
def test_a_flight_that_never_left_the_ground_is_not_praised(
    columns: int, rows: int, tmp_path: Path
) -> None:
    terminal = Terminal(columns, rows)
    watch(terminal, plan_of(tmp_path, "states: {a: {after: {1 s: b}}, b: {type: final}}\n"))
    assert terminal.lines.count("– ended in 'done', never left the ground") == 1
    assert "✔" not in "\n".join(terminal.lines)


def many_states(groups: int = 19, states: int = 19) -> str:
    """A mission of some four hundred states; the vehicle stands on the ground."""
    lines = ["mission: many", "states:"]
    for group in range(groups):
        lines += [f"  g{group}:", f"    on: {{done: {_next(group)}}}", "    states:"]
        lines += [f"      s{n}: {{after: {{25 ms: s{n + 1}}}}}" for n in range(states)]
        lines.append(f"      s{states}: {{type: final}}")
    return "\n".join([*lines, "  over: {type: final}\n"])


def _next(group: int) -> str:
    return f"g{group + 1}" if group < 18 else "over"


@pytest.mark.parametrize(("columns", "rows"), SIZES)
def test_of_four_hundred_states_the_active_one_is_in_sight(
    columns: int, rows: int, tmp_path: Path
) -> None:
    terminal = Terminal(columns, rows)
    plan = plan_of(tmp_path, many_states(), "empty")
    seen: set[str] = set()

    def look() -> None:
        (status,) = [line for line in terminal.lines if line.startswith("▶ g")]
        group, _, state = status.split()[1].partition(".")
        tree = [line for line in terminal.lines if line.startswith(("▾", "  ▶"))]
        assert [line.split()[1] for line in tree[:2]] == [group, state]
        assert sum("▶" in line for line in terminal.lines) == 2
        seen.add(group)

    watch(terminal, plan, {1.0 + 2 * n: look for n in range(4)})
    assert len(seen) == 4
    assert any(line.startswith("■ over") for line in terminal.lines) or rows == 15


def test_what_a_persons_code_prints_is_shown_and_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "own.py").write_text(
        "import sys\nfrom behaviors import action\n\n@action\ndef chat() -> None:\n"
        "    print('hello')\n    print('oh', file=sys.stderr, end='')\n"
    )
    text = """\
mission: chat
uses: [own.py]
states:
  up: {do: takeoff, entry: {call: chat}, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
    terminal = Terminal(80, 24)
    during: list[str] = []
    plan = plan_of(tmp_path, text, "empty")
    watch(terminal, plan, {1.0: lambda: during.extend(terminal.lines)})
    assert "         hello" in during
    printed = capsys.readouterr()
    assert (printed.out, printed.err) == ("hello\n", "oh\n")


def test_texts_of_others_cannot_draw_on_the_screen(tmp_path: Path) -> None:
    text = WALL.replace("do: takeoff,", 'do: takeoff, entry: {log: "a\\e[2Jb\\nc\\rd\\te"},')
    terminal = Terminal(80, 24)
    watch(terminal, plan_of(tmp_path, text), {1.0: lambda: _assert_line(terminal, "a [2Jb c d e")})


def _assert_line(terminal: Terminal, text: str) -> None:
    assert any(line.endswith(f"  {text}") for line in terminal.lines)


def test_a_flight_that_fails_leaves_the_terminal_as_it_was(tmp_path: Path) -> None:
    terminal = Terminal(80, 24)
    plan = plan_of(tmp_path, WALL)
    watched = Watch(terminal, plan)

    def fail() -> None:
        raise VehicleError("gone", "it is gone")

    watched.looks[2.0] = fail
    with pytest.raises(VehicleError), watched.view:
        fly(plan, None, [watched])
    assert not terminal.screen.cursor.hidden
    assert "▶ shed" in terminal.lines[1]


@pytest.mark.parametrize(("columns", "rows"), SIZES)
def test_several_vehicles_have_a_row_each_and_are_on_the_map(columns: int, rows: int) -> None:
    (assignment,) = first_flight().assignments.values()
    plan = Plan({"cat": assignment, "mouse": assignment})
    terminal = Terminal(columns, rows)

    def look() -> None:
        screen = "\n".join(terminal.lines)
        assert terminal.lines[0].startswith(" fleet   0:0") and "in the air 2 of 2" in screen
        head = terminal.row_of("cat  ")
        for number, name in enumerate(("cat  ", "mouse")):
            row = terminal.lines[head + number]
            assert re.match(rf"{name}  ▶ (square|….*)\.north [0-9.]+ s", row)
            figures = re.search(r"2\.0 m  [01]\.\d m/s  99%", row)
            assert (figures is not None) == (columns not in (40, 80)), "there is room for them"
        assert " 0:05.7  mouse → square.north (done)" in screen
        if rows > 20:
            map_ = terminal.lines[terminal.row_of("north up") :]
            assert "\n".join(map_).count("H") == 2

    watch(terminal, plan, {7.0: look})


def test_of_more_vehicles_than_rows_the_last_row_tells(tmp_path: Path) -> None:
    (assignment,) = first_flight().assignments.values()
    plan = Plan({f"v{number:02}": assignment for number in range(20)})
    terminal = Terminal(60, 20)

    def look() -> None:
        rows = [line for line in terminal.lines if re.match(r"v\d\d  ▶", line)]
        assert [row[:3] for row in rows] == [f"v{number:02}" for number in range(len(rows))]
        assert f"⋮ {20 - len(rows)} more" in "\n".join(terminal.lines)

    watch(terminal, plan, {3.0: look})


@pytest.mark.slow
def test_a_real_terminal_that_is_resized(tmp_path: Path) -> None:
    screen = pyte.Screen(100, 30)
    stream = pyte.ByteStream(screen)
    process, terminal = pty.fork()
    if process == 0:
        os.environ.update(TERM="xterm-256color", PYTHONPATH=str(Path(__file__).parents[2]))
        for name in ("COLUMNS", "LINES", "NO_COLOR"):
            os.environ.pop(name, None)
        os.chdir(tmp_path)
        time.sleep(0.3)
        command = [sys.executable, "-m", "tests.cli.drone_cli", "run", "first_flight"]
        os.execv(sys.executable, [*command, "--speed", "3"])

    def resize(columns: int, rows: int) -> None:
        screen.resize(rows, columns)
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    resize(100, 30)
    sizes = {5: (50, 20), 8: (40, 15), 12: (130, 40)}
    """Seconds of flight, and the size from then on."""
    try:
        while data := os.read(terminal, 65536):
            stream.feed(data)
            clock = re.search(r"first_flight   0:(\d\d)\.\d", screen.display[0])
            if clock and sizes and int(clock[1]) >= min(sizes):
                resize(*sizes.pop(min(sizes)))
    except OSError:
        pass  # the end, on Linux
    _, status = os.waitpid(process, 0)
    os.close(terminal)
    assert os.waitstatus_to_exitcode(status) == 0
    assert not sizes
    text = "\n".join(screen.display)
    assert text.count("first_flight   0:20.5") == 1
    assert text.count("✔ ended in 'done'") == 1
    assert "✔ first_flight ended in 'done'" in text
    assert "run folder: runs/" in text
