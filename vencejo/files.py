"""Files that a user's file names, and files that are written whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from difflib import get_close_matches
from errno import ELOOP
from pathlib import Path, PurePath

from vencejo.errors import Correction, UserError, certain, nearest, reason_of
from vencejo.nodes import Scalar


def file_inside(folder: Path, word: Scalar, what: str) -> Path:
    """The resolved path of a file named by ``word``, inside ``folder``; it need not exist.

    ``what`` describes the file in the hint. Raises UserError (``no-such-file`` for an impossible
    name, ``outside-folder``).
    """
    try:
        path, around = (folder / word.text).resolve(), folder.resolve()
        path.is_file()
        if path.is_symlink():  # of links in a circle CPython 3.13 resolves none
            raise OSError(ELOOP, os.strerror(ELOOP))
    except FileNotFoundError as error:
        # Not the file, which need not be there: without a working directory no path is known.
        message = f"'{word.text}' cannot be found: {reason_of(error)}"
        raise UserError("no-such-file", message, word.where) from None
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


def nearest_file(word: str, files: Iterable[str], otherwise: str | None = None) -> str | None:
    """A hint as :func:`vencejo.errors.nearest` gives it, for files and what is named like one.

    Folders and endings do not count: no two names are similar by them. Of files that differ in
    nothing else the first is named.
    """
    stems = dict[str, str]()
    for file in files:
        stems.setdefault(PurePath(file).stem, file)
    stem = PurePath(word).stem
    meant = certain(stem, stems)
    if meant is not None:
        return Correction(word, stems[meant])
    close = get_close_matches(stem, stems, n=1, cutoff=0.6)
    if close:
        return f"did you mean '{stems[close[0]]}'?"
    return otherwise if otherwise is not None else nearest("", stems.values())


def write_whole(path: Path, data: bytes | memoryview) -> None:
    """Write a file that has its name only when it is whole: the program may be killed any time.

    What a link leads to is written, and a device or pipe as it is. Raises OSError, and then leaves
    nothing behind; a file of that name is then as it was.
    """
    path = Path(os.path.realpath(path)) if path.is_symlink() else path
    if path.exists() and not path.is_file():
        path.write_bytes(data)
        return
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(data)
        if path.exists():
            shutil.copymode(path, part)
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """A folder to write into, that gets the name ``path`` when the block has ended well.

    Otherwise nothing of it is left. Raises OSError, also where ``path`` is there already.
    """
    part = path.with_name(path.name + ".part")
    part.mkdir()
    try:
        yield part
        part.rename(path)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def is_file_word(word: str) -> bool:
    """Whether a word that names a thing is the path of a YAML file."""
    return word.endswith((".yaml", ".yml"))


def named_from(folder: Path, word: str) -> str:
    """A word that names a thing, seen from here: a file is named from the folder of what names it,
    not from where one happens to be.
    """
    return str(folder / word) if is_file_word(word) else word
