"""Small commands, most of them lists: missions, behaviors, worlds, picture."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from behaviors.detector import OwnDetector
from cli.look import VIEWS
from cli.options import (
    BehaviorName,
    MissionName,
    Viewpoint,
    Word,
    WorldName,
    as_used,
    call_limit_option,
    renderer_option,
    shadows_option,
)
from cli.output import echo_json
from cli.user_code import user_code
from fsm import BehaviorInfo, Graph, Parameter
from fsm.host import Function
from hal.renderers import show_window
from runner import missions as known
from vencejo.errors import UserError, Where, cannot_write, nearest
from vencejo.files import write_whole
from vencejo.units import UNITS, format_quantity
from worlds import World, find_world, world_families, world_names
from worlds.world import Fence

if TYPE_CHECKING:
    from runner.fleets import PreparedFleet

_NOTHING: Mapping[str, Any] = {}


def plain(docstring: str) -> str:
    """A docstring as a terminal shows it."""
    return docstring.replace("``", "`")


def _table(rows: list[tuple[str, str]]) -> None:
    width = max((len(name) for name, _ in rows), default=0)
    for name, text in rows:
        click.echo(f"{name:<{width}}  {text}".rstrip())


@click.command()
@click.argument("name", required=False, type=MissionName())
@click.option("--copy", is_flag=True, help="Copy it into ./missions, to change it.")
@call_limit_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def missions(name: str | None, copy: bool, call_limit: float | None, as_json: bool) -> None:
    """List the missions that can be run by name, or show what NAME does and takes."""
    if name is None:
        _list_missions(as_json)
        return
    found = known.find(name)
    if copy and not _about(found.path)[1]:
        _copy([found.path], found.path.parent)
        return
    from runner.fleets import PreparedFleet, prepare_any

    with user_code(call_limit) as limit:
        prepared = prepare_any(found, calls=limit.calls)
    if isinstance(prepared, PreparedFleet):
        prepared.require()
        if copy:
            _copy(prepared.files, found.path.resolve().parent)
        else:
            _show_fleet(prepared, found, as_json)
        return
    graph = prepared.graph
    if as_json:
        facts = {"mission": graph.name, "description": graph.description, "world": graph.world}
        echo_json({**facts, "file": str(found.path), "parameters": _parameters(graph)})
        return
    click.echo(f"{graph.name}: {graph.description}\n  file   {found.shown_as}")
    click.echo(f"  world  {graph.world or 'empty'}")
    if graph.parameters:
        click.echo("\nparameters (set with -p NAME=VALUE):")
        _table([(f"  {p.name}", described(p)) for p in graph.parameters.values()])


def _parameters(graph: Graph) -> dict[str, Any]:
    return {p.name: _parameter(p) for p in graph.parameters.values()}


def _show_fleet(prepared: PreparedFleet, found: known.Found, as_json: bool) -> None:
    """Show what the vehicles of a fleet fly, and what can be set of each."""
    spec, world = prepared.spec, prepared.spec.world.text if prepared.spec.world else "empty"
    graphs = {
        name: None if each.stands else each.prepared.graph
        for name, each in prepared.assignments.items()
    }
    if as_json:
        facts = {"fleet": spec.name, "description": spec.description, "world": world}
        vehicles = {
            name: {"mission": graph.name, "parameters": _parameters(graph)} if graph else {}
            for name, graph in graphs.items()
        }
        echo_json({**facts, "file": str(found.path), "vehicles": vehicles})
        return
    click.echo(f"{spec.name}: {spec.description}\n  file   {found.shown_as}\n  world  {world}")
    if spec.until is not None:
        click.echo(f"  until  {spec.until.text}")
    click.echo("\nvehicles:")
    _table([(f"  {name}", graph.name if graph else "stands") for name, graph in graphs.items()])
    rows = [
        (f"  {name}.{p.name}", described(p, prepared.assignments[name].parameters))
        for name, graph in graphs.items()
        for p in (graph.parameters.values() if graph else ())
    ]
    if rows:
        click.echo("\nparameters (set with -p VEHICLE.NAME=VALUE):")
        _table(rows)


def _list_missions(as_json: bool) -> None:
    rows = [(name, *_about(path)) for name, path in known.names().items()]
    if as_json:
        facts = [{"mission": n, "description": text, "fleet": fleet} for n, text, fleet in rows]
        echo_json(facts)
    else:
        _table([(name, f"(fleet) {text}" if fleet else text) for name, text, fleet in rows])
        click.echo("\ndrone-cli run NAME flies one, drone-cli missions NAME tells more.")


def _about(path: Path) -> tuple[str, bool]:
    """The description in a mission's file, and whether it is a fleet's."""
    from fsm import read_mission
    from fsm.fleet import read_fleet
    from fsm.language.reader import FLEET

    try:
        return read_mission(path).description, False
    except UserError as error:
        if error.code != FLEET:
            return _mistake(error), False
    try:
        fleet, faults = read_fleet(path)
        faults.raise_any()
        return fleet.description, True
    except UserError as error:
        return _mistake(error), True


def _mistake(error: UserError) -> str:
    return f"(has a mistake: {error.faults[0].message})"


def _copy(files: Sequence[Path], folder: Path) -> None:
    """Copy a mission's or a fleet's files, the one that is run first, from about ``folder``."""
    own = known.own_folder()
    targets = {path: own / path.relative_to(folder) for path in files}
    for target in targets.values():
        if target.exists():
            raise UserError("exists", f"'{target}' exists already", Where(str(target)))
    begun = not own.exists()
    for path, target in targets.items():
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            write_whole(target, path.read_bytes())
        except OSError as error:
            if begun:
                with suppress(OSError):
                    own.rmdir()
            message = "the copy cannot be written"
            raise cannot_write(error, "cannot-write", message, Where(str(target))) from None
    first = files[0]
    click.echo(f"copied to {targets[first]}; `drone-cli run {first.stem}` now flies your copy")


def _parameter(parameter: Parameter) -> dict[str, Any]:
    return {
        "type": str(parameter.type),
        "required": parameter.required,
        "default": parameter.default,
        "live": parameter.live,
        "help": parameter.help,
    }


def described(parameter: Parameter, given: Mapping[str, Any] = _NOTHING) -> str:
    """Type, default and help of a parameter, as people read them; ``given`` are the values that a
    fleet gives.
    """
    if parameter.name in given:
        parameter = replace(parameter, default=given[parameter.name], required=False)
    if parameter.required:
        default = "required"
    elif parameter.default is None:
        default = "default: none"
    elif isinstance(parameter.default, (int, float)) and not isinstance(parameter.default, bool):
        default = f"default: {_in_its_unit(parameter, parameter.default)}"
    else:
        default = f"default: {json.dumps(parameter.default)}"
    live = ", live" if parameter.live else ""
    return f"{parameter.type} ({default}{live})  {parameter.help}".rstrip()


def _in_its_unit(parameter: Parameter, number: float) -> str:
    """A number in the unit that the parameter is declared in, if it is."""
    if parameter.unit:
        return f"{number / UNITS[parameter.unit][0]:g} {parameter.unit}"
    return format_quantity(number, getattr(parameter.type, "dimension", None))


@click.command()
@click.argument("name", required=False, type=BehaviorName())
@click.option(
    "--uses",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Those of a Python file too, as a mission names it under `uses`.",
)
@call_limit_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def behaviors(name: str | None, uses: Path | None, call_limit: float | None, as_json: bool) -> None:
    """List the behaviours that missions are composed of, or explain NAME.

    With --uses FILE and no NAME those of that file alone are listed, and its functions.
    """
    from behaviors import Registry, load_all

    with user_code(call_limit) as limit:
        installed = Registry(calls=limit.calls)
        own = load_all([as_used(uses)], limit.calls) if uses else {}
        listed = own or installed if name is None else [name]
        found = {
            each: own.get(each) or installed[each]
            for each in listed
            if each in own or each in installed
        }
    if name is None:
        rows = [(key, plain(info.help).partition("\n")[0]) for key, info in found.items()]
        if as_json:
            echo_json([{_kind(found[key]): key, "help": text} for key, text in rows])
        else:
            _table(rows)
            click.echo("\ndrone-cli behaviors NAME tells its parameters and outcomes.")
        return
    if name not in found:
        raise UserError(
            "unknown-behaviour",
            f"there is no behaviour '{name}'",
            hint=nearest(name, [*own, *installed]),
        )
    if as_json:
        echo_json(_behavior_facts(found[name]))
    else:
        _explain(found[name])


_Listed = BehaviorInfo | Function | OwnDetector


def _kind(info: _Listed) -> str:
    if isinstance(info, OwnDetector):
        return "detector"
    return "behavior" if isinstance(info, BehaviorInfo) else "function"


def _behavior_facts(behavior: _Listed) -> dict[str, Any]:
    def names(fields: Any) -> dict[str, str]:
        return {name: str(type_) for name, type_ in fields.items()}

    facts = {
        _kind(behavior): behavior.name,
        "help": plain(behavior.help),
        "parameters": {p.name: _parameter(p) for p in behavior.parameters.values()},
    }
    if not isinstance(behavior, BehaviorInfo):
        return facts
    return {
        **facts,
        "outcomes": {word: names(fields) for word, fields in behavior.outcomes.items()},
        "events": {event: names(fields) for event, fields in behavior.events.items()},
        "publishes": names(behavior.publishes),
        "controls": list(behavior.controls),
        "requires": list(behavior.requires),
        "ends_landed": behavior.ends_landed,
    }


def _explain(behavior: _Listed) -> None:
    click.echo(f"{behavior.name}\n\n{plain(behavior.help)}\n")
    if isinstance(behavior, Function):
        click.echo("a function: `call` it in actions; its arguments:")
    elif isinstance(behavior, OwnDetector):
        click.echo("a detector: name it under `detect`; its settings:")
    elif behavior.parameters:
        click.echo("parameters (`live` ones may also stand under `live:`):")
    _table([(f"  {p.name}", described(p)) for p in behavior.parameters.values()])
    if isinstance(behavior, BehaviorInfo):
        _explain_ends(behavior)


def _explain_ends(behavior: BehaviorInfo) -> None:
    outcomes = [
        (f"  {word}", f"event: {', '.join(fields)}" if fields else "")
        for word, fields in behavior.outcomes.items()
    ]
    click.echo("\noutcomes:" + ("" if outcomes else " it never ends by itself"))
    _table([*outcomes, ("  failed", "event: reason")])
    if behavior.events:
        click.echo("\nevents it raises:")
        _table([(f"  {name}", ", ".join(fields)) for name, fields in behavior.events.items()])
    if behavior.publishes:
        click.echo("\nvalues it publishes:")
        _table([(f"  {behavior.name}.{n}", str(type_)) for n, type_ in behavior.publishes.items()])
    if behavior.controls:
        click.echo(f"\ncontrols: {', '.join(behavior.controls)}")


@click.command()
@click.argument("name", required=False, type=WorldName())
@click.option(
    "--render",
    "picture_file",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Write a picture of it, PNG or JPEG.",
)
@click.option(
    "--camera",
    type=Word(list(VIEWS)),
    default="front",
    show_default=True,
    help="How that picture looks at it.",
)
@click.option("--at", type=Viewpoint(), help="From where: metres, and degrees from east.")
@renderer_option
@shadows_option
@click.option("--gui", is_flag=True, help="Show it in a window.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.pass_context
def worlds(
    ctx: click.Context,
    name: str | None,
    picture_file: Path | None,
    camera: str,
    at: tuple[float, float, float, float] | None,
    renderer: str,
    shadows: bool,
    gui: bool,
    as_json: bool,
) -> None:
    """List the worlds there are, or show NAME (a shipped one, roads:17, or a file)."""
    if bool(picture_file) + gui + as_json > 1:
        raise UserError("bad-usage", "--render, --gui and --json exclude one another")
    for option in ("camera", "at", "renderer", "shadows"):
        given = ctx.get_parameter_source(option) == click.core.ParameterSource.COMMANDLINE
        if given and not picture_file:
            hint = "drone-cli worlds yard --camera top --render yard.png"
            raise UserError("bad-usage", f"--{option} is for a picture: --render FILE", hint=hint)
    if name is None:
        if picture_file or gui:
            raise UserError(
                "no-world", "which world?", hint="drone-cli worlds road_town --render …"
            )
        _list_worlds(as_json)
        return
    world = find_world(name)
    if picture_file:
        from cli.look import hidden_by, render

        for fault in hidden_by(world, at) if at else ():
            click.echo(str(fault), err=True)
        render(world, picture_file, camera, at, renderer, shadows)
        click.echo(picture_file)
    elif gui:
        show_window(world)
    elif as_json:
        echo_json(_world_facts(world))
    else:
        _describe_world(world)


def _list_worlds(as_json: bool) -> None:
    rows = [(key, find_world(key).description) for key in world_names()]
    if as_json:
        echo_json([{"world": key, "description": text} for key, text in rows])
        return
    _table(rows)
    click.echo("\ngenerated, by number (roads:17):")
    _table([(f"  {family}", plain(text)) for family, text in world_families().items()])


def _world_facts(world: World) -> dict[str, Any]:
    return {
        "world": world.name,
        "description": world.description,
        "file": str(world.source),
        "origin": asdict(world.origin) if world.origin else None,
        "battery": world.battery,
        "fence": _fence_facts(world.fence) if world.fence else None,
        "wind": asdict(world.wind) if world.wind else None,
        "start": list(world.starts[0].at),
        "things": _contents(world),
        "places": {place: list(point) for place, point in world.places.items()},
    }


def _fence_facts(fence: Fence) -> dict[str, Any]:
    heights = {"floor": fence.floor, "ceiling": fence.ceiling}
    known = {key: height for key, height in heights.items() if isfinite(height)}
    return {"through": [list(corner) for corner in fence.corners], **known}


def _describe_world(world: World) -> None:
    start = world.starts[0].at
    click.echo(f"{world.name}: {world.description}\n  file     {world.source}")
    if world.origin:
        origin = world.origin
        click.echo(f"  origin   {origin.lat:.5f}, {origin.lon:.5f}, {origin.alt:g} m")
    click.echo(f"  start    {start.x:g}, {start.y:g}; battery {world.battery:.0%}")
    if world.fence:
        fence = _fence_facts(world.fence)
        corners = ", ".join(f"[{x:g}, {y:g}]" for x, y in fence["through"])
        heights = (f"; {key} {fence[key]:g} m" for key in ("floor", "ceiling") if key in fence)
        click.echo(f"  fence    {corners}{''.join(heights)}")
    if world.wind:
        click.echo(f"  wind     {world.wind}")
    contents = _contents(world)
    if contents:
        click.echo("  contents:")
        _table([(f"    {kind}", _some(names)) for kind, names in contents.items()])
    if world.places:
        click.echo("  places:")
        _table(
            [(f"    {place}", f"{p.x:g}, {p.y:g}, {p.z:g}") for place, p in world.places.items()]
        )


def _contents(world: World) -> dict[str, list[str]]:
    """Names of a world's things by kind, and of its roads."""
    contents: dict[str, list[str]] = {}
    for thing in world.things:
        contents.setdefault(thing.kind, []).append(thing.name)
    return contents | ({"road": [road.name for road in world.roads]} if world.roads else {})


def _some(names: list[str]) -> str:
    """A few names, and how many more there are."""
    shown = ", ".join(names[:8])
    return f"{shown} and {len(names) - 8} more" if len(names) > 8 else shown


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
def picture(folder: Path) -> None:
    """Draw the picture of the run in FOLDER, also of one that was killed."""
    from cli.plot import draw

    click.echo(draw(folder))
