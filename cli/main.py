"""drone-cli: the command line. Commands are imported when they are used, to start fast."""

from __future__ import annotations

import importlib
import sys
from importlib.util import find_spec
from pathlib import Path

import click

from cli.ending import not_kept_alive
from vencejo.errors import Stopped, UserError, nearest
from vencejo.version import __version__

COMMANDS = {
    "run": ("cli.run:run", "Fly a mission."),
    "check": ("cli.check:check", "Check missions without flying them."),
    "show": ("cli.show:show", "Show a mission's graph as text or as a picture."),
    "missions": ("cli.lists:missions", "List missions, show one, or copy one to change it."),
    "behaviors": ("cli.lists:behaviors", "List behaviours, or explain one."),
    "worlds": ("cli.lists:worlds", "List worlds, or show one."),
    "schema": ("cli.schemas:schema", "Print the JSON Schema of missions, for editors."),
    "new": ("cli.new:new", "Start a mission of your own, with a behaviour and a test."),
    "picture": ("cli.lists:picture", "Draw the picture of a run again."),
    "completion": ("cli.lists:completion", "Print shell completion to source."),
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

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
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
    try:
        check_packages()
        app(prog_name="drone-cli", standalone_mode=False)
    except UserError as error:
        click.echo(str(error), err=True)
        sys.exit(error.exit_code)
    except click.exceptions.Exit as stop:
        sys.exit(stop.exit_code)
    except click.UsageError as error:
        click.echo(_usage(error), err=True)
        sys.exit(2)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except (click.Abort, KeyboardInterrupt, Stopped):
        sys.exit(130)
    except BrokenPipeError:
        from cli.view import silence

        silence(sys.stdout)
        sys.exit(0)


def _usage(error: click.UsageError) -> str:
    """Click's complaint in our form, with what is near to a mistyped option or value."""
    if isinstance(error, click.NoSuchOption):
        options = [name for p in (error.ctx.command.params if error.ctx else ()) for name in p.opts]
        hint = nearest(error.option_name, [o for o in options if o.startswith("--")])
        fault = UserError("unknown-option", f"there is no option '{error.option_name}'", hint=hint)
        return str(fault)
    command = error.ctx.command_path if error.ctx else "drone-cli"
    message = error.format_message().rstrip(".")
    return str(UserError("bad-usage", message, hint=f"{command} --help"))
