"""Kinds of option values that several commands take."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import inf, isfinite, pi
from pathlib import Path
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from hal import FlightModel
from hal.engines import engine_names
from hal.limits import DIMENSIONS, Limits
from hal.renderers import renderer_names
from runner.geometry import CLEARANCE, Terms
from vencejo.errors import UserError, Where, nearest
from vencejo.nodes import Mapping, Scalar, YamlNode
from vencejo.units import FREQUENCY, LENGTH, TIME, read_quantity
from worlds.wind import read_wind

F = TypeVar("F", bound=Callable[..., Any])


class _AsWritten(click.ParamType):  # type: ignore[type-arg]
    """A type whose name stands in the help as it is: what is typed small is small there too."""

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        return self.name


class Word(_AsWritten):
    """One of a few words; a mistyped one gets the nearest."""

    def __init__(self, words: list[str]) -> None:
        self.words = words
        self.name = "|".join(words)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        if value in self.words:
            return str(value)
        self.fail(f"'{value}' is none of {', '.join(self.words)}; {nearest(value, self.words)}")

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        return [CompletionItem(word) for word in self.words if word.startswith(incomplete)]


renderer_option = click.option(
    "--renderer",
    type=Word(renderer_names()),
    default="raster",
    show_default=True,
    help="What draws the simulator's pictures.",
)
engine_option = click.option(
    "--engine",
    type=Word(engine_names()),
    help="The simulator's physics engine.  [default: the first that is installed]",
)
physics_option = click.option(
    "--physics",
    metavar="real|ideal[,+EFFECT|,-EFFECT...]",
    default="real",
    show_default=True,
    help="What the simulator computes: rotors, drag, ground_effect, power, sag, crashes, downwash.",
)
shadows_option = click.option(
    "--shadows", is_flag=True, help="What stands on the ground darkens it in pictures."
)


class Speed(_AsWritten):
    """``max`` (None) or a factor above 0."""

    name = "FACTOR|max"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | None:
        if value is None or value == "max":
            return None
        try:
            factor = float(str(value).removesuffix("x"))
        except ValueError:
            factor = 0.0
        if not 0 < factor < 1e6:
            self.fail(f"'{value}' is neither a factor above 0 nor max; for instance --speed 2")
        return factor

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        return [
            CompletionItem(word) for word in ("max", "1", "2", "5") if word.startswith(incomplete)
        ]


class CallSeconds(_AsWritten):
    """A time above 0 in seconds; ``none`` and 0 are no limit (None)."""

    name = "TIME|none"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | None:
        if value is None or value == "none":
            return None
        try:
            seconds = read_quantity(str(value), TIME)
        except UserError as error:
            self.fail(f"{error.faults[0].message}; for instance --call-limit 10s, or none")
        if not 0 <= seconds < inf:
            self.fail(f"'{value}' is no time; for instance --call-limit 10s, or none")
        return max(seconds, SHORTEST_CALL_LIMIT) if seconds else None


class PictureRate(_AsWritten):
    """Pictures a second: a frequency above 0."""

    name = "RATE"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        try:
            rate = read_quantity(str(value), FREQUENCY)
        except UserError:
            rate = 0.0
        if not 0 < rate < inf:
            self.fail(f"'{value}' is no frequency above 0; for instance --picture-rate 10Hz")
        return rate


SHORTEST_CALL_LIMIT = 0.01
"""Seconds: shorter ones would end calls that do nothing wrong."""
call_limit_option = click.option(
    "--call-limit",
    type=CallSeconds(),
    default="5s",
    show_default=True,
    help="End a call into Python of missions or plug-ins that takes longer; none (or 0) for never.",
)


def paths(
    incomplete: str, endings: Iterable[str] = ("",), *, folders_only: bool = False
) -> list[CompletionItem[str]]:
    """The files with one of these endings, and the folders, whose paths begin so."""
    folder, slash, begun = incomplete.rpartition("/")
    found = []
    try:
        for entry in sorted(Path(folder + slash or ".").expanduser().iterdir()):
            hidden = entry.name.startswith(".") and not begun.startswith(".")
            if not entry.name.startswith(begun) or hidden:
                continue
            if entry.is_dir():
                found.append(CompletionItem(f"{folder}{slash}{entry.name}/"))
            elif not folders_only and entry.name.endswith(tuple(endings)):
                found.append(CompletionItem(f"{folder}{slash}{entry.name}"))
    except (OSError, RuntimeError):
        return []  # a folder that cannot be read, or a ~ of nobody
    return found


class Length(click.ParamType):  # type: ignore[type-arg]
    """A length of 0 or more, in metres."""

    name = "length"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        try:
            length = read_quantity(str(value), LENGTH)
        except UserError as error:
            self.fail(f"{error.faults[0].message}; for instance 50cm")
        if not 0 <= length < inf:
            self.fail(f"'{value}' is no distance; for instance 50cm")
        return length


class _Name(click.ParamType):  # type: ignore[type-arg]
    """A word that names one of several things, or a file."""

    endings: tuple[str, ...] = ()
    """Endings of the files that may be meant; empty: of none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        return str(value)

    def known(self, ctx: click.Context) -> Iterable[str]:
        """The names there are."""
        raise NotImplementedError

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        names = [CompletionItem(name) for name in self.known(ctx) if name.startswith(incomplete)]
        return names + (paths(incomplete, self.endings) if self.endings else [])


class MissionName(_Name):
    """A mission by path or name."""

    name = "mission"
    endings = (".yaml", ".yml", ".scxml")

    def known(self, ctx: click.Context) -> Iterable[str]:
        from runner.missions import names

        return names()


class WorldName(_Name):
    """A world by path or name, or a generated one by its family and number."""

    name = "world"
    endings = (".yaml", ".yml")

    def known(self, ctx: click.Context) -> Iterable[str]:
        from worlds import world_families, world_names

        return [*world_names(), *(f"{family}:" for family in world_families())]


class ModelName(_Name):
    """A model of the simulator's vehicles, by path or name."""

    name = "model"
    endings = (".yaml", ".yml")

    def known(self, ctx: click.Context) -> Iterable[str]:
        from hal import backend_models

        models = backend_models(SIMULATOR)
        return models.names() if models else []


SIMULATOR = "sim"
"""The backend whose vehicles have models."""


def model_option(text: str) -> Callable[[F], F]:
    """The option ``--model``, with its help."""
    return click.option("--model", type=ModelName(), metavar="NAME|FILE", help=text)


class BehaviorName(_Name):
    """A behaviour by name; ``--uses FILE`` before it adds those of a file, which is not run."""

    name = "behaviour"

    def known(self, ctx: click.Context) -> Iterable[str]:
        from behaviors import Registry, trusted

        file = ctx.params.get("uses")
        return [*(trusted([as_used(file)], []) if file else ()), *Registry()]


def as_used(file: Path) -> tuple[Scalar, Path]:
    """A Python file as a mission beside it names it under ``uses``, and its folder."""
    return Scalar(file.name, Where(str(file))), file.parent


def complete_parameter(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """``name=`` of the parameters of the mission that the command line names; ``vehicle.name=`` of
    a fleet.
    """
    # Click leaves the arguments where they are while the value of an option is missing.
    mission = ctx.params.get("mission") or next(iter(ctx.args), "")
    try:
        parameters = _parameters_of(mission)
    except UserError:
        return []
    return [
        CompletionItem(f"{name}=", help=_told_of(node))
        for name, node in parameters.items()
        if name.startswith(incomplete)
    ]


def _parameters_of(mission: str) -> dict[str, YamlNode]:
    """The parameters of a mission, or of a fleet's vehicles, as they are declared. Raises UserError
    where it cannot be read; it may have mistakes elsewhere.
    """
    from fsm import read_mission
    from fsm.faults import Faults
    from fsm.fleet import read_fleet
    from fsm.language.reader import FLEET
    from runner.missions import find

    found = find(mission)
    try:
        spec = read_mission(found.path, found.shown_as, Faults())
    except UserError as error:
        if error.code != FLEET:
            raise
    else:
        return {parameter.name.text: parameter.node for parameter in spec.parameters}
    fleet, _ = read_fleet(found.path, found.shown_as)
    return {
        f"{member.name.text}.{parameter.name.text}": parameter.node
        for member in fleet.members
        for parameter in (member.spec.parameters if member.spec else ())
    }


def _told_of(node: YamlNode) -> str:
    """The help of a parameter as written, or its default where that is all there is."""
    told = node.get("help") if isinstance(node, Mapping) else node
    return told.text if isinstance(told, Scalar) else ""


def assignments(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> dict[str, str]:
    """``name=value`` pairs of a repeated option, each name once."""
    found = {}
    for value in values:
        name, equals, text = value.partition("=")
        if not equals or not name:
            raise click.BadParameter(f"'{value}' is not name=value", ctx=ctx, param=param)
        if name.strip() in found:
            raise click.BadParameter(f"'{name.strip()}' is set twice", ctx=ctx, param=param)
        found[name.strip()] = text
    return found


@dataclass(frozen=True)
class LimitSettings:
    """The values of ``--limit``: a profile of the vehicle, and limits that override it."""

    profile: str | None
    limits: Limits

    def on(self, model: FlightModel | None) -> Limits:
        """The limits completed by those of the profile, where the vehicles' are known.

        Raises UserError (``bad-limit``) for limits that cannot be, or a profile they do not have.
        """
        wanted = Limits(**self.limits.given())
        if self.profile is None or model is None:
            return wanted
        if self.profile not in model.profiles:
            hint = nearest(self.profile, model.profiles, "this vehicle has none")
            message = f"there is no profile '{self.profile}'"
            raise UserError("bad-limit", message, Where("--limit"), hint)
        return wanted.over(model.profiles[self.profile])

    def terms(self, model: FlightModel | None, clearance: float = CLEARANCE) -> Terms:
        """What the ways of such vehicles are checked on. Raises UserError (``bad-limit``)."""
        return Terms(model, self.on(model), clearance)


def limits(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> LimitSettings:
    """Read the repeated option ``--limit``: ``name=quantity``, or the name of a profile."""
    profile, found = None, dict[str, float]()
    for value in values:
        name, equals, text = value.partition("=")
        if name in found or (profile is not None and not equals):
            what = f"'{name}'" if equals else "a profile"
            raise click.BadParameter(f"{what} is set twice", ctx=ctx, param=param)
        if not equals:
            profile = name
            continue
        if name not in DIMENSIONS:
            message = f"there is no limit '{name}'; {nearest(name, DIMENSIONS)}"
            raise click.BadParameter(message, ctx=ctx, param=param)
        try:
            found[name] = read_quantity(text, DIMENSIONS[name], Where(f"--limit {name}"))
        except UserError as error:
            message = f"{name}: {error.faults[0].message}"
            raise click.BadParameter(message, ctx=ctx, param=param) from None
    return LimitSettings(profile, Limits(**found))


_CAMERA = re.compile(r"([a-z_]\w*)(?::(\d+)x(\d+))?(?:@(\d+(?:\.\d+)?))?")


def limit_option(text: str) -> Callable[[F], F]:
    """The option ``--limit``, with its help."""
    return click.option(
        "--limit",
        "limit_settings",
        multiple=True,
        callback=limits,
        metavar="NAME=VALUE|PROFILE",
        help=text,
    )


def noise_option(text: str) -> Callable[[F], F]:
    """The option ``--noise``, with its help."""
    return click.option(
        "--noise", type=click.FloatRange(0, 10), default=0.0, show_default=True, help=text
    )


def wind_option(text: str) -> Callable[[F], F]:
    """The option ``--wind``, with its help."""
    return click.option("--wind", callback=_wind, metavar="SPEED@FROM[,KEY=VALUE...]", help=text)


def _wind(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    """Check a wind, and leave it as it is written: so the backend takes it."""
    try:
        if value is not None:
            read_wind(value, "--wind")
    except UserError as error:
        lines = (f"{f.message}; {f.hint}" if f.hint else f.message for f in error.faults)
        raise click.BadParameter("; ".join(lines), ctx=ctx, param=param) from None
    return value


def cameras(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> dict[str, dict[str, int | float] | None]:
    """``name:640x480@30`` of a repeated option: resolution and rate by camera, or ``name:off``.

    A camera may be named twice for two different settings.
    """
    found: dict[str, dict[str, int | float] | None] = {}
    for value in values:
        name, settings = _camera(ctx, param, value)
        before = found.get(name, {})
        if name in found and (before is None or settings is None or before.keys() & settings):
            raise click.BadParameter(f"the camera '{name}' is set twice", ctx=ctx, param=param)
        found[name] = None if settings is None else {**(before or {}), **settings}
    return found


def _camera(
    ctx: click.Context, param: click.Parameter, value: str
) -> tuple[str, dict[str, int | float] | None]:
    """The name of a camera, and its settings; None for ``off``."""
    if value.endswith(":off"):
        return value.removesuffix(":off"), None
    match = _CAMERA.fullmatch(value)
    if match is None:
        raise click.BadParameter(
            f"'{value}' is not NAME:WIDTHxHEIGHT@RATE; for instance front:640x480@30",
            ctx=ctx,
            param=param,
        )
    name, width, height, rate = match.groups()
    settings: dict[str, int | float] = {}
    if width:
        settings |= {"width": int(width), "height": int(height)}
    if rate:
        settings["rate"] = float(rate)
    return name, settings


class Viewpoint(_AsWritten):
    """``x,y,z`` or ``x,y,z,yaw``: metres of the world frame, and degrees from east."""

    name = "x,y,z[,yaw]"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float, float, float]:
        parts = str(value).split(",")
        try:
            numbers = [float(part.strip().removesuffix("deg")) for part in parts]
        except ValueError:
            numbers = []
        if len(numbers) not in (3, 4) or not all(map(isfinite, numbers)):
            self.fail(f"'{value}' is not x,y,z or x,y,z,yaw; for instance --at 0,-10,3,90")
        x, y, z, yaw = [*numbers, 0.0][:4]
        return x, y, z, yaw * pi / 180
