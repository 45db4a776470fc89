"""drone-cli doctor: what is installed, what works on this machine, and how to get the rest."""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, requires, version

import click

from cli.output import echo_json
from hal import Intrinsics, Options, open_backend
from hal.engines import ENGINES, default_engine
from hal.renderers import open_renderer, renderer_names
from vencejo.errors import UserError
from vencejo.geometry import OPTICAL, Point
from vencejo.version import __version__
from worlds import find_world

_LENS = Intrinsics(32, 24, 16.0, 16.0, 15.5, 11.5)


@dataclass(frozen=True)
class _Tried:
    """What became of a trial of an engine or a renderer."""

    works: bool
    version: str = ""
    """The package of an engine, and its version."""
    reason: str = ""
    """Why it does not work."""
    hint: str = ""
    """What helps."""

    def __str__(self) -> str:
        if self.works:
            return self.version or "works"
        return f"{self.reason}\n    {self.hint}" if self.hint else self.reason


@dataclass(frozen=True)
class _Report:
    """What was found on this machine."""

    vencejo: str
    python: str
    platform: str
    engine: str
    """The name of the one that is used where none is asked for."""
    engines: Mapping[str, _Tried]
    renderers: Mapping[str, _Tried]
    packages: Mapping[str, str | None]
    """Version of each package that is needed; None for one that is missing."""

    @property
    def can_fly(self) -> bool:
        """Whether a mission can fly here."""
        return self.engines[self.engine].works and None not in self.packages.values()


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def doctor(as_json: bool) -> None:
    """Tell what is installed, what works on this machine, and how to get what is missing.

    Every physics engine and renderer is tried. Exit code: 0 a mission can fly here, 1 it cannot.
    """
    report = _examined()
    if as_json:
        echo_json({**asdict(report), "can_fly": report.can_fly})
    else:
        _print(report)
    sys.exit(int(not report.can_fly))


def _examined() -> _Report:
    engines = {name: _tried(partial(_try_engine, name)) for name in ENGINES}
    renderers = {name: _tried(partial(_try_renderer, name)) for name in renderer_names()}
    return _Report(
        vencejo=__version__,
        python=f"{platform.python_implementation()} {platform.python_version()}",
        platform=f"{platform.system()} {platform.machine()}",
        engine=default_engine(),
        engines=engines,
        renderers=renderers,
        packages={name: _version(name) for name in sorted(_needed(), key=str.lower)},
    )


def _tried(attempt: Callable[[], str]) -> _Tried:
    try:
        return _Tried(True, attempt())
    except UserError as error:
        fault = error.faults[0]
        return _Tried(False, reason=fault.message, hint=fault.hint or "")
    except Exception as error:  # whatever is wrong with somebody else's package is what we look for
        return _Tried(False, reason=f"{type(error).__name__}: {error}")


def _try_engine(name: str) -> str:
    """Simulate one mission period; the package of the engine and its version."""
    with open_backend("sim", Options(settings={"engine": name})) as session:
        session.wait()
        return session.engine


def _try_renderer(name: str) -> str:
    """Render one small image."""
    renderer = open_renderer(name, find_world("empty"), {})
    renderer.render((Point(0.0, 0.0, 1.0), OPTICAL), _LENS, 0.0, {})
    renderer.close()
    return ""


def _needed() -> list[str]:
    """The packages that vencejo needs everywhere; engines are told apart."""
    lines = requires("vencejo") or []
    names = [re.match(r"[\w.-]+", line) for line in lines if ";" not in line]
    return [found[0] for found in names if found]


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _print(report: _Report) -> None:
    rows = [("vencejo", report.vencejo), ("Python", report.python), ("machine", report.platform)]
    _section("", rows)
    default = {report.engine: " (the default)" if report.engines[report.engine].works else ""}
    _section("engines", [(n, f"{each}{default.get(n, '')}") for n, each in report.engines.items()])
    _section("renderers", [(name, str(each)) for name, each in report.renderers.items()])
    missing = 'missing\n    run: pip install "{}"'
    _section("packages", [(n, v or missing.format(n)) for n, v in report.packages.items()])
    click.echo("✔ missions can fly here" if report.can_fly else "✘ no mission can fly here")


def _section(title: str, rows: list[tuple[str, str]]) -> None:
    if title:
        click.echo(title)
    for name, text in rows:
        click.echo(f"  {name:<22}  {text}")
