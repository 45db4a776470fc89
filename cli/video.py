"""drone-cli video: make videos of a run from the pictures in its folder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from runner.run_folder import read_run
from vencejo.errors import UserError, Where, nearest

if TYPE_CHECKING:
    from runner.video import Reel


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
@click.option("--vehicle", metavar="NAME", help="Of this vehicle only.")
@click.option("--camera", metavar="NAME", help="What this camera saw.")
@click.option("--picture", metavar="NAME", help="The annotated pictures of this name.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Where one video goes, FILE.webm. [default: beside the folder of its pictures]",
)
def video(
    folder: Path, vehicle: str | None, camera: str | None, picture: str | None, output: Path | None
) -> None:
    """Make videos of the run in FOLDER, also of one that was killed: WebM, which browsers play.

    Without --camera and --picture there is one for each name of annotated pictures; where there
    are none, for each camera.
    """
    if camera and picture:
        hint = "drone-cli video --help"
        raise UserError(
            "bad-usage", "--camera and --picture are of two videos: give one", hint=hint
        )
    if output is not None and output.suffix != ".webm":
        message = f"'{output}' does not end in .webm, the one format of videos"
        raise UserError("bad-usage", message, hint=f"-o {output.with_suffix('.webm')}")
    for file in videos(folder, (vehicle, camera, picture), output):
        click.echo(file)


def videos(
    folder: Path,
    wanted: tuple[str | None, str | None, str | None] = (None, None, None),
    output: Path | None = None,
) -> Iterator[Path]:
    """Make the videos of a run, of a vehicle, camera or picture if ``wanted``; their files.

    Raises UserError.
    """
    from runner.video import film, reels_of  # late: only what makes videos loads OpenCV

    reels = _wanted(folder, reels_of(read_run(folder)), *wanted)
    if output is not None and len(reels) > 1:
        names = ", ".join(f"--vehicle {reel.vehicle} {_option(reel)}" for reel in reels)
        message = f"there are {len(reels)} videos, and one name for them"
        raise UserError("bad-usage", message, hint=f"name one: {names}")
    for reel in reels:
        file = output or reel.file
        film(reel, file)
        yield file


def _option(reel: Reel) -> str:
    return f"--{reel.kind} {reel.name}"


def _wanted(
    folder: Path,
    reels: Sequence[Reel],
    vehicle: str | None,
    camera: str | None,
    picture: str | None,
) -> list[Reel]:
    """The reels that are asked for. Raises UserError (``no-video``) where there are none."""
    where = Where(str(folder))
    if not reels:
        hint = "behaviours that read a camera leave some, unless it was flown with --no-frames"
        raise UserError("no-video", "there are no pictures in this run", where, hint)
    known = {reel.vehicle for reel in reels}
    if vehicle is not None and vehicle not in known:
        message = f"there are no pictures of the vehicle '{vehicle}' in this run"
        raise UserError("no-video", message, where, nearest(vehicle, known))
    of_it = [reel for reel in reels if vehicle in (None, reel.vehicle)]
    for kind, name in (("camera", camera), ("picture", picture)):
        if name is not None:
            names = {reel.name for reel in of_it if reel.kind == kind}
            if name not in names:
                message = f"there are no pictures of the {kind} '{name}' in this run"
                others = ", ".join(map(_option, of_it))
                raise UserError("no-video", message, where, nearest(name, names, others))
            return [reel for reel in of_it if (reel.kind, reel.name) == (kind, name)]
    return [reel for reel in of_it if reel.kind == of_it[0].kind]
