"""drone-cli tune: find the values that behaviours are given, from what a camera saw."""

from __future__ import annotations

from math import dist
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cli.output import write_file
from vencejo.errors import UserError, Where

if TYPE_CHECKING:
    from behaviors.perception import ColorRange
    from hal.scene.arrays import Box, Pixels

_REACH = 3
"""Pixels on each side of a clicked one that count."""
_NAMED = 0.8
"""Least share of the box that a named colour has if it is told."""
_ENDINGS = (".png", ".jpg", ".jpeg")


class _Pixels(click.ParamType):  # type: ignore[type-arg]
    """Whole numbers with commas between them."""

    def __init__(self, name: str) -> None:
        self.name = name

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, ...]:
        count = self.name.count(",") + 1
        try:
            numbers = tuple(int(part) for part in str(value).split(","))
        except ValueError:
            numbers = ()
        if len(numbers) != count:
            option = max(param.opts, key=len) if param else ""
            example = ",".join(("160", "120", "180", "140")[:count])
            self.fail(
                f"'{value}' is not {self.name} in whole pixels; for instance {option} {example}"
            )
        return numbers


@click.group(invoke_without_command=True)
@click.pass_context
def tune(context: click.Context) -> None:
    """Find values for behaviours from a picture, such as one of `frames/` in a run folder."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@tune.command(short_help="The range of a colour in a picture.")
@click.argument("picture", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--at", type=_Pixels("x,y"), help="A pixel of that colour, and those around it.")
@click.option(
    "--box", type=_Pixels("x1,y1,x2,y2"), help="A box of that colour, by two of its corners."
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Write the mask of the first range: white where the picture has that colour.",
)
def color(
    picture: Path,
    at: tuple[int, int] | None,
    box: tuple[int, int, int, int] | None,
    output: Path | None,
) -> None:
    """Print the range of a colour in PICTURE, as HSV and as RGB, to be pasted into a mission.

    Behind each stands the share of the picture that it takes: if that is much more than the thing
    itself, take a box further inside of it. Pixels count from the upper left, from 0.
    """
    from behaviors.perception import range_of  # late: only this needs OpenCV

    if at is not None and box is None:
        chosen = _around(at)
    elif box is not None and at is None:
        chosen = _between(box)
    else:
        raise UserError("bad-usage", "say where the colour is: --at x,y or --box x1,y1,x2,y2")
    if output is not None and output.suffix.lower() not in _ENDINGS:
        hint = f"-o {output.with_suffix('.png')}"
        raise UserError("bad-usage", f"'{output}' does not end in .png or .jpg", hint=hint)
    image = _read(picture)
    try:
        ranges = [range_of(image, chosen, space) for space in ("hsv", "rgb")]
    except ValueError as error:
        raise UserError("bad-usage", str(error), Where("--at" if at else "--box")) from None
    for found in ranges:
        low, high = list(found.low), list(found.high)
        click.echo(f"color: {{{found.space}: [{low}, {high}]}}  # {_share(image, found)}")
    for name, named in _names_of(image, chosen)[:1]:
        click.echo(f"color: {name}  # {_share(image, named)}")
    if output is not None:
        _write_mask(output, image, ranges[0])


def _around(at: tuple[int, int]) -> Box:
    x, y = at
    return x - _REACH, y - _REACH, x + _REACH + 1, y + _REACH + 1


def _between(corners: tuple[int, int, int, int]) -> Box:
    """The box with two corners in it."""
    ax, ay, bx, by = corners
    return min(ax, bx), min(ay, by), max(ax, bx) + 1, max(ay, by) + 1


def _read(picture: Path) -> Pixels:
    """The picture of a file. Raises UserError (``no-picture``)."""
    import cv2
    import numpy as np

    try:
        data = np.frombuffer(picture.read_bytes(), np.uint8)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        message = f"this picture cannot be read: {reason}"
        raise UserError("no-picture", message, Where(str(picture))) from None
    image = cv2.imdecode(data, cv2.IMREAD_COLOR) if data.size else None
    if image is None:
        hint = "take a .jpg or .png, for instance one of frames/ in a run folder"
        raise UserError("no-picture", "this is no picture", Where(str(picture)), hint)
    return np.asarray(image, np.uint8)


def _share(image: Pixels, found: ColorRange) -> str:
    from behaviors.perception import mask

    return f"{100 * (mask(image, found) > 0).mean():.2f} % of the picture"


def _names_of(image: Pixels, box: Box) -> list[tuple[str, ColorRange]]:
    """The named colours that most of a box has, the one nearest to its mean first."""
    from behaviors.perception import mask, read_color
    from worlds.colors import COLORS

    left, top, right, bottom = box
    part = image[max(0, top) : bottom, max(0, left) : right]
    mean = part.reshape(-1, 3).mean(0)[::-1].tolist()
    nearest = sorted(COLORS, key=lambda each: dist(mean, COLORS[each]))
    found = [(name, read_color(name)) for name in nearest]
    return [(name, each) for name, each in found if (mask(part, each) > 0).mean() >= _NAMED]


def _write_mask(file: Path, image: Pixels, found: ColorRange) -> None:
    import cv2

    from behaviors.perception import mask

    _, data = cv2.imencode(file.suffix.lower(), mask(image, found))
    write_file(file, data.data)
