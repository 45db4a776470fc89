"""drone-cli new: a mission to start from, with a behaviour of one's own and a test."""

from __future__ import annotations

import re
from pathlib import Path

import click

from vencejo.errors import UserError, Where, cannot_write
from vencejo.files import whole_folder

TEMPLATES = Path(__file__).parent / "templates"


@click.command()
@click.argument("name")
def new(name: str) -> None:
    """Make the folder NAME with a mission, a behaviour of its own and a test of both.

    All three work at once: as an example they fly a spiral. Change them bit by bit.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise UserError(
            "bad-name", f"'{name}' is no name for a mission", hint="small letters, digits and _"
        )
    folder = Path(name)
    if folder.exists():
        raise UserError("exists", f"'{name}' exists already", Where(name), "choose another name")
    files = {
        template.stem.replace("NAME", name): template.read_text("utf-8").replace("NAME", name)
        for template in sorted(TEMPLATES.glob("*.txt"))
    }
    try:
        with whole_folder(folder) as made:
            for file, text in files.items():
                (made / file).write_text(text, "utf-8")
    except OSError as error:
        message = "this folder cannot be made"
        raise cannot_write(error, "cannot-write", message, Where(name)) from None
    for file in files:
        click.echo(f"wrote {folder / file}")
    click.echo(
        f"\nan example, which flies a spiral; try:\n"
        f"  drone-cli check {folder}/{name}.yaml\n"
        f"  drone-cli run {folder}/{name}.yaml --speed 2\n"
        f"  python -m pytest {folder}          (pip install pytest)"
    )
