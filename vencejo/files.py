"""Files that a user's file names, and files that are written whole or not at all."""

from __future__ import annotations

from pathlib import Path

from vencejo.errors import UserError
from vencejo.nodes import Scalar


def file_inside(folder: Path, word: Scalar, what: str) -> Path:
    """The resolved path of a file named by ``word``, inside ``folder``; it need not exist.

    ``what`` describes the file in the hint. Raises UserError (``no-such-file`` for an impossible
    name, ``outside-folder``).
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


def write_whole(path: Path, data: bytes | memoryview) -> None:
    """Write a file that has its name only when it is whole: the program may be killed any time.

    Raises OSError, and then leaves nothing behind.
    """
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(data)
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
