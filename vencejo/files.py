"""Files that a person's file names."""

from __future__ import annotations

from pathlib import Path

from vencejo.errors import UserError
from vencejo.nodes import Scalar


def file_inside(folder: Path, word: Scalar, what: str) -> Path:
    """The file that a word names, which must lie in ``folder``; it need not be there.

    ``what`` it is, for the hint. Raises UserError.
    """
    try:
        path, around = (folder / word.text).resolve(), folder.resolve()
        path.is_file()
    except (OSError, ValueError, RuntimeError):
        # Too long a name, one with a zero byte, or links that lead in a circle.
        message = f"'{word.text[:60]}' cannot be the name of a file"
        raise UserError("no-such-file", message, word.where) from None
    if not path.is_relative_to(around):
        raise UserError(
            "outside-folder",
            f"'{word.text}' lies outside the folder of the file that names it",
            word.where,
            f"{what} lies beside that file or further inside",
        )
    return path
