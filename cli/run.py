"""drone-cli run: fly a mission and leave a run folder."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import IO

import click

from cli.options import (
    LimitSettings,
    MissionName,
    Speed,
    Word,
    assignments,
    call_limit_option,
    cameras,
    limits,
    renderer_option,
    shadows_option,
)
from cli.signals import Interrupts
from cli.user_code import user_code
from fsm import parse_parameters
from hal import backend_names
from runner import missions
from runner.appended_file import as_json as as_json_value
from runner.camera_file import joined, read_camera_file
from runner.loop import Plan, Watcher, fly
from runner.pace import Pace
from runner.preparation import prepare
from runner.recorder import Recorder, new_folder
from runner.run_folder import INTERRUPTED, Summary, summary_fields
from vencejo.errors import Stopped, UserError


@click.command()
@click.argument("mission", type=MissionName())
@click.option(
    "--backend", type=Word(backend_names()), default="sim", show_default=True, help="What flies it."
)
@click.option("--connect", metavar="ADDRESS", help="Where a real vehicle is reached.")
@click.option("--world", metavar="NAME|FILE", help="Fly in another world than the mission names.")
@click.option(
    "-p",
    "--parameter",
    "parameters",
    multiple=True,
    callback=assignments,
    metavar="NAME=VALUE",
    help="Set a parameter of the mission, for instance -p altitude=3m. Repeatable.",
)
@click.option(
    "--limit",
    "limit_settings",
    multiple=True,
    callback=limits,
    metavar="NAME=VALUE|PROFILE",
    help="Limit the flight, for instance --limit max_altitude=2.5m (above home), or by a profile "
    "of the vehicle: --limit indoor. Repeatable.",
)
@click.option(
    "--seed", type=int, default=0, show_default=True, help="Every random draw comes from it."
)
@click.option(
    "--speed",
    type=Speed(),
    default="max",
    show_default=True,
    help="Times real time, or max. For the simulator.",
)
@click.option(
    "--noise",
    type=click.FloatRange(0, 10),
    default=0.0,
    show_default=True,
    help="Disturb the commands in the simulator, as on a real AR.Drone; 1 is usual.",
)
@click.option(
    "--camera",
    "wanted_cameras",
    multiple=True,
    callback=cameras,
    metavar="NAME[:WxH][@RATE]",
    help="Set a camera of the simulator, for instance front:640x480@30, or front:off. Repeatable.",
)
@click.option(
    "--cameras",
    "camera_file",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Set the simulator's cameras by a YAML file: place, direction, lens, noise, blur.",
)
@renderer_option
@shadows_option
@click.option(
    "--runs-dir",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("runs"),
    show_default=True,
    help="Where the run folder is made.",
)
@click.option(
    "--no-frames",
    is_flag=True,
    help="Do not keep the camera pictures that behaviours read, to save space.",
)
@call_limit_option
@click.option(
    "--json", "as_json", is_flag=True, help="Print the summary as JSON, and nothing else."
)
def run(
    mission: str,
    backend: str,
    connect: str | None,
    world: str | None,
    parameters: dict[str, str],
    limit_settings: LimitSettings,
    seed: int,
    speed: float | None,
    noise: float,
    wanted_cameras: dict[str, dict[str, int | float] | None],
    camera_file: Path | None,
    renderer: str,
    shadows: bool,
    runs_dir: Path,
    no_frames: bool,
    call_limit: float | None,
    as_json: bool,
) -> None:
    """Fly MISSION: a file, or the name of one in ./missions or of a shipped one.

    Exit code: 0 the mission ended in `done`, 1 in another outcome, 2 it or its arguments are
    wrong, 3 the vehicle failed, 130 interrupted (and landed). Ctrl-C once asks the mission to
    stop, twice lands at once, thrice stops the program.
    """
    with user_code(call_limit) as limit:
        prepared = prepare(missions.find(mission), world, calls=limit.calls)
    values = parse_parameters(prepared.graph, parameters)
    for fault in prepared.graph.warnings:
        click.echo(str(fault), err=True)
    settings: dict[str, object] = {}
    if backend == "sim":
        settings = {
            "noise": noise,
            "cameras": joined(read_camera_file(camera_file), wanted_cameras)
            if camera_file
            else wanted_cameras,
            "renderer": renderer,
            "shadows": shadows,
        }
    plan = replace(
        Plan.alone(prepared, values, backend=backend, seed=seed, settings=settings),
        address=connect,
        profile=limit_settings.profile,
        limits=limit_settings.limits,
    )

    def record() -> Recorder:
        stamp = datetime.now().strftime("%Y%m%d-%H%M%S")
        folder = new_folder(runs_dir, stamp, prepared.graph.name)
        recorder = Recorder(folder, frames=not no_frames)
        if camera_file is not None:
            recorder.keep([camera_file], camera_file.parent)
        return recorder

    sys.exit(_fly(plan, speed, call_limit, record, as_json))


def _fly(
    plan: Plan,
    speed: float | None,
    call_limit: float | None,
    new_recorder: Callable[[], Recorder],
    as_json: bool,
) -> int:
    """Fly, show and record; the exit code."""
    made: list[Recorder] = []
    out = sys.stdout

    def record() -> Recorder:
        made.append(new_recorder())
        for assignment in plan.assignments.values():
            prepared = assignment.prepared
            made[0].keep(prepared.files, prepared.found.path.parent)
        made[0].keep_world(plan.world)
        return made[0]

    try:
        with ExitStack() as stack:

            def landed(summary: Summary) -> int:
                """The end of a flight in which a call did not end; the exit code."""
                stack.close()
                return _finish(summary, made[0], as_json)

            limit = stack.enter_context(user_code(call_limit, landed))
            stops = stack.enter_context(Interrupts())
            watchers = [] if as_json else [_watcher(plan, speed, stops, stack, out)]
            summary = fly(plan, record, watchers, Pace(speed), stops, limit)
    except Stopped:
        click.echo("stopped; the vehicle is left to its own failsafe", err=True)
        if made:
            click.echo(f"run folder: {made[0].folder}", err=True)
        sys.exit(INTERRUPTED)
    return _finish(summary, made[0], as_json)


def _finish(summary: Summary, recorder: Recorder, as_json: bool) -> int:
    """Write and show how a flight ended; the exit code."""
    folder = recorder.folder
    recorder.write_summary(summary)
    for name, flown in summary.vehicles.items():
        if flown.failure:
            click.echo(f"{name}: {flown.failure}", err=True)
    _draw(folder)
    fields = summary_fields(summary, folder)
    if as_json:
        click.echo(json.dumps(fields, ensure_ascii=False, default=as_json_value))
    else:
        from cli.view import show_summary

        show_summary(fields, sys.stdout)
    return summary.exit_code


def _watcher(
    plan: Plan, speed: float | None, stops: Interrupts, stack: ExitStack, out: IO[str]
) -> Watcher:
    """The live view on a terminal, plain lines elsewhere."""
    from rich.console import Console

    from cli.view import LiveView, PlainView

    console = Console(file=out)

    def closed() -> None:
        # Nobody is there any more (`| head`, a closed terminal): land and end.
        if stops.count < 2:
            stops.request(2)

    if not console.is_terminal:
        return PlainView(out, closed)
    (assignment,) = plan.assignments.values()
    return stack.enter_context(LiveView(assignment.prepared.graph, console, speed, closed))


def _draw(folder: Path) -> None:
    from cli.flight_plot import draw

    try:
        draw(folder)
    except (OSError, UserError) as error:
        click.echo(f"no picture: {error}", err=True)
