"""drone-cli run: fly a mission and leave a run folder."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import IO, TYPE_CHECKING, cast

import click
from click.core import ParameterSource

from behaviors import Calls, Pilot
from cli.options import (
    LimitSettings,
    MissionName,
    PictureRate,
    Speed,
    Word,
    WorldName,
    assignments,
    call_limit_option,
    cameras,
    complete_parameter,
    engine_option,
    limit_option,
    model_option,
    noise_option,
    physics_option,
    renderer_option,
    shadows_option,
    wind_option,
)
from cli.output import Output, echo_json
from cli.signals import Interrupts
from cli.user_code import user_code
from fsm import parse_parameters
from fsm.engine.instance import Record
from hal import backend_names
from runner import missions
from runner.again import Recorded
from runner.appended_file import as_json as as_json_value
from runner.by_vehicle import ALONE
from runner.camera_file import joined, read_camera_file
from runner.fleets import PreparedFleet, check_ways, prepare_any, with_parameters
from runner.loop import Watcher, fly
from runner.missions import Found
from runner.pace import Pace
from runner.plan import Assignment, Fleet, Plan, with_model
from runner.posts import parse_posts
from runner.recorder import PICTURE_RATE, Recorder, new_folder
from runner.run_folder import INTERRUPTED, NOT_RECORDED, Summary, summary_fields
from runner.vehicle_models import faults_of_models, flight_of, models_of
from vencejo.errors import Fault, OutputError, Stopped, UserError, Where

if TYPE_CHECKING:
    from rich.console import Console


@click.command()
@click.argument("mission", type=MissionName(), required=False)
@click.option(
    "--again",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Repeat a run from its run folder, with all its settings, instead of flying MISSION.",
)
@click.option(
    "--backend", type=Word(backend_names()), default="sim", show_default=True, help="What flies it."
)
@click.option("--connect", metavar="ADDRESS", help="Where a real vehicle is reached.")
@click.option(
    "--world",
    type=WorldName(),
    metavar="NAME|FILE",
    help="Fly in another world than the mission names.",
)
@model_option("Fly another model of vehicle than the fleet or the world names.")
@click.option(
    "-p",
    "--parameter",
    "parameters",
    multiple=True,
    callback=assignments,
    shell_complete=complete_parameter,
    metavar="NAME=VALUE",
    help="Set a parameter of the mission, for instance -p altitude=3m; of a fleet's vehicle: "
    "-p cat.altitude=3m. Repeatable.",
)
@limit_option(
    "Limit the flight, for instance --limit max_altitude=2.5m (above home), or by a profile of the "
    "vehicle: --limit indoor. Repeatable."
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
@engine_option
@physics_option
@noise_option("Disturb the commands in the simulator, as on a real AR.Drone; 1 is usual.")
@wind_option(
    "Let a wind blow in the simulator instead of the world's: speed and compass bearing it comes "
    "from, such as 5m/s@270deg, or 3m/s@90deg,gusts=6m/s,turbulence=light; or none."
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
    "--post",
    "posts",
    multiple=True,
    metavar="TIME:[VEHICLE:]EVENT",
    help="Tell the mission an event that long after its start, for instance --post 6s:battery.low "
    "or --post '6s:tag.seen{id: 3}'; of a fleet --post 6s:cat:battery.low tells one. Repeatable.",
)
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
    help="Do not keep the camera pictures that behaviours read or annotate, to save space.",
)
@click.option(
    "--picture-rate",
    type=PictureRate(),
    default=f"{PICTURE_RATE:g}Hz",
    show_default=True,
    help="The most annotated pictures of a behaviour to keep in a second.",
)
@call_limit_option
@click.option(
    "--no-picture",
    is_flag=True,
    help="Do not draw flight.png; `drone-cli picture FOLDER` does it later.",
)
@click.option(
    "--video",
    is_flag=True,
    help="Make videos of the annotated pictures, or else of what cameras saw, after the flight; "
    "`drone-cli video FOLDER` does it later.",
)
@click.option(
    "--json", "as_json", is_flag=True, help="Print the summary as JSON, and nothing else."
)
@click.pass_context
def run(
    context: click.Context,
    mission: str | None,
    again: Path | None,
    backend: str,
    connect: str | None,
    world: str | None,
    model: str | None,
    parameters: dict[str, str],
    limit_settings: LimitSettings,
    seed: int,
    speed: float | None,
    engine: str | None,
    physics: str,
    noise: float,
    wind: str | None,
    wanted_cameras: dict[str, dict[str, int | float] | None],
    camera_file: Path | None,
    renderer: str,
    shadows: bool,
    posts: tuple[str, ...],
    runs_dir: Path,
    no_frames: bool,
    picture_rate: float,
    no_picture: bool,
    video: bool,
    call_limit: float | None,
    as_json: bool,
) -> None:
    """Fly MISSION, or a fleet: a file, or the name of one in ./missions or of a shipped one.

    Exit code: 0 the mission ended in `done`, or what a fleet flies `until` came true, 1 in another
    outcome, 2 it or its arguments are wrong, 3 the vehicle failed, 4 it flew and landed, but record
    or output could not be written, 130 interrupted (and landed). Ctrl-C once asks the mission to
    stop, twice lands at once, thrice stops the program.
    """
    if video and no_frames:
        message = "--video is made of the pictures that --no-frames leaves out: give one of them"
        raise click.UsageError(message, context)
    if again is not None:
        _refuse_settings_beside_again(context)
        plan, call_limit = _plan_again(again)
    elif mission is None:
        raise click.MissingParameter(ctx=context, param_hint="'MISSION'", param_type="argument")
    else:
        own: dict[str, object] = {}
        if backend == "sim":
            in_file = read_camera_file(camera_file) if camera_file else {}
            own = {
                "engine": engine,
                "physics": physics,
                "noise": noise,
                "wind": wind,
                "cameras": joined(in_file, wanted_cameras),
                "renderer": renderer,
                "shadows": shadows,
            }
        with user_code(call_limit) as limit:
            doubtful: list[Fault] = []
            found = missions.find(mission)
            assignments, fleet = _assignments(found, world, parameters, limit.calls, doubtful)
            assignments = with_model(assignments, model, Where("--model"))
            flown = {name: each for name, each in assignments.items() if not each.stands}
            graphs = {name: each.prepared.graph for name, each in flown.items()}
            plan = Plan(
                assignments,
                backend=backend,
                seed=seed,
                settings=own,
                address=connect,
                profile=limit_settings.profile,
                limits=limit_settings.limits,
                camera_file=camera_file,
                posts=parse_posts(graphs, posts, doubtful),
                fleet=fleet,
            )
            for fault in doubtful:
                click.echo(str(fault), err=True)
            _warn_of_ways(plan, limit_settings, limit.calls)

    def record() -> Recorder:
        stamp = datetime.now().strftime("%Y%m%d-%H%M%S")
        folder = new_folder(runs_dir, stamp, plan.name)
        return Recorder(folder, frames=not no_frames, picture_rate=picture_rate)

    how = _Shown(None if as_json else context.obj, picture=not no_picture, video=video)
    sys.exit(_fly(plan, speed, call_limit, record, how))


_BESIDE_AGAIN = (
    *("again", "speed", "runs_dir", "no_frames", "picture_rate", "no_picture", "video"),
    "as_json",
)
"""Parameters that do not change a flight."""


def _refuse_settings_beside_again(context: click.Context) -> None:
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if source is ParameterSource.COMMANDLINE and parameter.name not in _BESIDE_AGAIN:
            name = max(parameter.opts, key=len)
            shown = name if name.startswith("-") else name.upper()
            message = f"--again repeats a run with its own settings: leave out {shown}"
            raise click.UsageError(message, context)


def _plan_again(folder: Path) -> tuple[Plan, float | None]:
    """The plan of a recorded run, and its limit on calls into people's code."""
    recorded = Recorded.read(folder)
    doubt = recorded.doubt()
    if doubt is not None:
        click.echo(str(doubt), err=True)
    call_limit = recorded.settings.call_limit
    with user_code(call_limit) as limit:
        return recorded.plan(limit.calls), call_limit


def _assignments(
    found: Found,
    world: str | None,
    parameters: Mapping[str, str],
    calls: Calls,
    doubtful: list[Fault],
) -> tuple[Mapping[str, Assignment], Fleet | None]:
    """What each vehicle flies, and what joins those of a fleet; all warnings are added to
    ``doubtful``.
    """
    prepared = prepare_any(found, world, calls=calls)
    if isinstance(prepared, PreparedFleet):
        prepared.require()
        doubtful.extend(prepared.faults)
        return with_parameters(prepared.assignments, parameters, doubtful), prepared.fleet
    doubtful.extend(prepared.graph.warnings)
    values = parse_parameters(prepared.graph, parameters, doubtful)
    return {ALONE: Assignment(prepared, values)}, None


def _warn_of_ways(plan: Plan, limit_settings: LimitSettings, calls: Calls) -> None:
    """Show what the possible ways of missions meet in their world. Raises UserError for what
    cannot be flown.
    """
    models = models_of(plan.backend, plan.assignments)
    terms = {
        name: limit_settings.terms(flight_of(plan.backend, model)) for name, model in models.items()
    }
    faults = [
        *faults_of_models(plan.assignments, models),
        *check_ways(plan.assignments, terms, calls).faults,
    ]
    errors = [fault for fault in faults if fault.severity == "error"]
    if errors:
        raise UserError.of(errors)
    for fault in faults:
        click.echo(str(fault), err=True)


@dataclass(frozen=True)
class _Shown:
    """How a flight is shown."""

    out: Output | None
    """Shows it while it goes on, and its end; without it the end is printed as JSON."""
    picture: bool
    """Whether its picture is drawn."""
    video: bool
    """Whether videos are made of it."""


def _fly(
    plan: Plan,
    speed: float | None,
    call_limit: float | None,
    new_recorder: Callable[[], Recorder],
    how: _Shown,
) -> int:
    """Fly, record and show; the exit code."""
    made: list[Recorder] = []

    def record() -> Recorder:
        made.append(new_recorder())
        return made[0]

    try:
        with ExitStack() as stack:

            def landed(summary: Summary) -> int:
                """The end of a flight in which a call did not end; the exit code."""
                stack.close()
                return _finish(summary, made[0], how)

            limit = stack.enter_context(user_code(call_limit, landed))
            stops = stack.enter_context(Interrupts())
            watchers = _watchers(plan, speed, how.out, stops, made, stack) if how.out else ()
            summary = fly(plan, record, watchers, Pace(speed), stops, limit)
    except Stopped:
        click.echo("stopped; the vehicle is left to its own failsafe", err=True)
        if made:
            click.echo(f"run folder: {made[0].folder}", err=True)
        sys.exit(INTERRUPTED)
    return _finish(summary, made[0], how)


def _finish(summary: Summary, recorder: Recorder, how: _Shown) -> int:
    """Write and show how a flight ended; the exit code."""
    with Interrupts():  # one Ctrl-C more than the flight needed must not hide how it ended
        folder = recorder.folder
        summary = _summarized(recorder, summary)
        for name, flown in summary.vehicles.items():
            if flown.failure:
                click.echo(f"{name}: {flown.failure}", err=True)
        if summary.unrecorded:
            click.echo(summary.unrecorded, err=True)
        for post in summary.header.settings.post if summary.header.settings else ():
            if post.time > summary.mission_time:
                to = f"{post.to}:" if post.to else ""
                late = f"--post {post.time:g}s:{to}{post.event}: the flight was over before"
                click.echo(late, err=True)
        files = [f"pictures: {each}" for each in recorder.picture_folders]
        no_room = _keep_findings(folder, files)
        no_room = (how.picture and _draw(folder)) or no_room
        no_room = (how.video and _film(folder, files)) or no_room
        fields = summary_fields(summary, folder)
        if how.out is None:
            echo_json(fields, default=as_json_value)
        else:
            from cli.view import show_summary

            show_summary(fields, files, colored=_is_colored(_console(how.out)))
        return NOT_RECORDED if no_room and summary.exit_code in (0, 1) else summary.exit_code


def _keep_findings(folder: Path, files: list[str]) -> bool:
    """Write what the run has found, and add it to ``files``; True when the disk had no room."""
    from runner.findings import write_findings

    def make() -> None:
        files.extend(f"findings: {file}" for file in write_findings(folder))

    return _is_without_room(make, "findings", f"drone-cli findings {folder}")


def _summarized(recorder: Recorder, summary: Summary) -> Summary:
    """The summary, written down, and that it could not be where it could not."""
    try:
        recorder.write_summary(summary)
    except UserError as error:
        return replace(summary, unrecorded=summary.unrecorded or str(error))
    return summary


def _watchers(
    plan: Plan,
    speed: float | None,
    out: Output,
    stops: Interrupts,
    made: Sequence[Recorder],
    stack: ExitStack,
) -> list[Watcher]:
    """The live view on a terminal that can draw it, plain lines elsewhere.

    ``made``: the recorder, once the flight has begun.
    """
    console = _console(out)
    drawable = out.isatty() and console.is_terminal and not console.is_dumb_terminal
    if not (drawable and out.unicode):
        from cli.view import PlainView

        view = PlainView(out, list(plan.assignments), colored=_is_colored(console))
        return [view, _PictureNews(made, view.note), _Reader(out, stops)]
    from cli.live_view import LiveView

    # Elsewhere the world's things do not stand where its file says.
    world = plan.world if plan.backend == "sim" else None
    fleet, vehicles = plan.fleet.name if plan.fleet else "", list(plan.assignments)
    live = LiveView(console, world, speed, fleet=fleet, vehicles=vehicles)
    return [stack.enter_context(live), _PictureNews(made, live.note), _Reader(out, stops)]


def _console(out: Output) -> Console:
    from rich.console import Console

    return Console(file=cast(IO[str], out))


def _is_colored(console: Console) -> bool:
    """Whether colours are wanted: on a terminal, or by FORCE_COLOR, but never with NO_COLOR."""
    return console.color_system is not None and not console.no_color


@dataclass
class _PictureNews:
    """Tells where annotated pictures are, when the first one of a name is there."""

    made: Sequence[Recorder]
    tell: Callable[[str], None]
    told: int = 0

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        folders = self.made[0].picture_folders
        for folder in folders[self.told :]:
            self.tell(f"pictures: {folder}")
        self.told = len(folders)


@dataclass(frozen=True)
class _Reader:
    """Lands the vehicle when nobody is there to read any more: `| head`, a closed terminal."""

    out: Output
    stops: Interrupts

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        if self.out.gone and self.stops.count < 2:
            self.stops.request(2)


def _draw(folder: Path) -> bool:
    """Draw the run's picture; True when the disk had no room for it."""
    from cli.plot import draw

    return _is_without_room(lambda: draw(folder), "picture", f"drone-cli picture {folder}")


def _film(folder: Path, files: list[str]) -> bool:
    """Make the run's videos, and add them to ``files``; True when the disk had no room for one."""
    from cli.video import videos

    def make() -> None:
        for file in videos(folder):
            files.append(f"video: {file}")

    return _is_without_room(make, "video", f"drone-cli video {folder}")


def _is_without_room(make: Callable[[], object], what: str, command: str) -> bool:
    """Make something of a run; True when the disk had no room for it.

    ``command`` makes it later, where it was interrupted.
    """
    try:
        with Interrupts(last=1):
            make()
    except UserError as error:
        click.echo(f"no {what}: {error}", err=True)
        return isinstance(error, OutputError)
    except Stopped:
        made = "drawn" if what == "picture" else "made"
        click.echo(f"no {what}: interrupted; {made} by `{command}`", err=True)
    return False
