"""drone-cli: the command line. Commands are imported when they are used, to start fast."""

from __future__ import annotations

import importlib
import os
import sys
from contextlib import redirect_stderr, redirect_stdout
from importlib.util import find_spec
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from cli.ending import not_kept_alive
from cli.output import Output, written_code
from vencejo.errors import Stopped, UserError, Where, cannot_write, nearest
from vencejo.version import __version__

COMMANDS = {
    "run": ("cli.run:run", "Fly a mission."),
    "check": ("cli.check:check", "Check missions without flying them."),
    "show": ("cli.show:show", "Show a mission's graph as text or as a picture."),
    "missions": ("cli.lists:missions", "List missions, show one, or copy one to change it."),
    "behaviors": ("cli.lists:behaviors", "List behaviours, or explain one."),
    "models": ("cli.models:models", "List models of vehicles, or show one."),
    "worlds": ("cli.lists:worlds", "List worlds, or show one."),
    "guide": ("cli.guide:guide", "Print language, behaviours and examples on one page."),
    "schema": ("cli.schemas:schema", "Print the JSON Schema of missions, for editors."),
    "new": ("cli.new:new", "Start a mission of your own, with a behaviour and a test."),
    "findings": ("cli.findings:findings", "Write what a run has found as GeoJSON and CSV."),
    "picture": ("cli.lists:picture", "Draw the picture of a run again."),
    "video": ("cli.video:video", "Make videos of what was seen in a run."),
    "tune": ("cli.tune:tune", "Find values for behaviours from a picture: the range of a colour."),
    "doctor": ("cli.doctor:doctor", "Tell what is installed, what works here, what is missing."),
    "completion": ("cli.completion:completion", "Print shell completion to source."),
}
PACKAGES = ("vencejo", "fsm", "behaviors", "hal", "worlds", "runner", "cli")
WELCOME = """\
drone-cli flies drone missions that are written as state graphs in YAML.

  drone-cli run first_flight     fly a first mission in the simulator
  drone-cli missions             see what else can be flown
  drone-cli new my_mission       start one of your own
  drone-cli --help               all commands
"""


class Commands(click.Group):
    """Finds commands by name and imports each when it is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module, _, name = COMMANDS[cmd_name][0].partition(":")
        command: click.Command = getattr(importlib.import_module(module), name)
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem[str]]:
        found = [
            (name, text) for name, (_, text) in COMMANDS.items() if name.startswith(incomplete)
        ]
        options = click.Command.shell_complete(self, ctx, incomplete)
        return [*(CompletionItem(name, help=text) for name, text in found), *options]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        wrong = args and args[0] not in COMMANDS and not args[0].startswith("-")
        if wrong and not ctx.resilient_parsing:
            raise UserError(
                "unknown-command",
                f"there is no command '{args[0]}'",
                hint=nearest(args[0], COMMANDS),
            )
        return super().resolve_command(ctx, args)


@click.group(
    cls=Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, prog_name="drone-cli")
@click.pass_context
def app(ctx: click.Context) -> None:
    """Write, check and fly drone missions: state graphs in YAML."""
    if ctx.invoked_subcommand is None:
        click.echo(WELCOME, nl=False)


def check_packages() -> None:
    """Refuse to start when another distribution's `hal` or `cli` is imported instead of ours."""
    here = Path(__file__).resolve().parent.parent
    for package in PACKAGES:
        spec = find_spec(package)
        origin = Path(spec.origin).resolve().parent.parent if spec and spec.origin else None
        if origin != here:
            raise UserError(
                "mixed-packages",
                f"the package '{package}' comes from {origin or 'nowhere'}, not from {here}",
                hint="install vencejo in an environment of its own (venv, pipx or uv tool)",
            )


@not_kept_alive()
def main() -> None:
    """The entry point: faults of a person are printed, never a traceback."""
    _open_descriptors()
    out, err = Output(sys.stdout), Output(sys.stderr)
    with redirect_stdout(out), redirect_stderr(err):
        code = written_code(_run(out), out, err)
    sys.exit(code)


def _open_descriptors() -> None:
    """Keep files of the run from becoming standard output where that was closed (``>&-``)."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one


def _run(out: Output) -> int:
    """Run the command of this process; its exit code."""
    try:
        check_packages()
        result = app(prog_name="drone-cli", standalone_mode=False, obj=out)
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    except (click.Abort, KeyboardInterrupt, Stopped):
        return 130
    except (UserError, click.ClickException, OSError) as error:
        fault = _fault(error)
        click.echo(str(fault), err=True)
        return fault.exit_code
    # Click gives the exit code of --help and its like as the result.
    return result if isinstance(result, int) else 0


def _fault(error: UserError | click.ClickException | OSError) -> UserError:
    """What a person reads of an error, in our form."""
    match error:
        case UserError():
            return error
        case OSError():
            where = Where(str(error.filename)) if error.filename else None
            return cannot_write(error, "no-access", "this cannot be read or written", where)
        case click.NoSuchOption():
            options = error.ctx.command.params if error.ctx else []
            names = [name for option in options for name in option.opts if name.startswith("--")]
            message = f"there is no option '{error.option_name}'"
            return UserError("unknown-option", message, hint=nearest(error.option_name, names))
        case _:
            context = error.ctx if isinstance(error, click.UsageError) else None
            command = context.command_path if context else "drone-cli"
            message = error.format_message().rstrip(".")
            return UserError("bad-usage", message, hint=f"{command} --help")
