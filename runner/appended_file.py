"""Files that only grow, JSON as their lines, and the error of a file that cannot be written."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, is_dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

from vencejo.errors import UserError, Where, reason_of


def as_json(value: Any) -> Any:
    """Convert for ``json`` what it cannot write: dataclasses, sets, members of enumerations."""
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    if isinstance(value, (set, frozenset)):
        return sorted(value)
    if isinstance(value, Enum):
        return value.value
    return str(value)


encode = json.JSONEncoder(
    ensure_ascii=False, allow_nan=False, separators=(",", ":"), default=as_json
).encode
"""One line of a log, without its end."""


_HINT = "make room, or choose another --runs-dir"


@contextmanager
def writing(path: Path, hint: str = _HINT) -> Iterator[None]:
    """Turn an OSError of writing (a full disk, for instance) into UserError (``cannot-record``)."""
    try:
        yield
    except OSError as error:
        message = f"cannot write into the run folder: {reason_of(error)}"
        raise UserError("cannot-record", message, Where(str(path)), hint) from None


class AppendedFile:
    """A text file that only grows, always by whole lines. Raises what ``writing`` does."""

    def __init__(self, path: Path, hint: str = _HINT) -> None:
        self._writing = partial(writing, path, hint)
        with self._writing():
            self._file = path.open("w", encoding="utf-8", newline="\n")

    def append(self, lines: Iterable[str]) -> None:
        """Add lines and hand them over to the system: they outlive this program."""
        with self._writing():
            self._file.write("".join([line + "\n" for line in lines]))
            self._file.flush()

    def close(self) -> None:
        with self._writing():
            self._file.close()


class JsonLines:
    """A file of one JSON object a line below a first one, which is there from the first line on."""

    def __init__(self, path: Path, header: Mapping[str, Any], hint: str = _HINT) -> None:
        self._path, self._header, self._hint = path, header, hint
        self._file: AppendedFile | None = None

    def append(self, line: Mapping[str, Any]) -> None:
        if self._file is None:
            self._file = AppendedFile(self._path, self._hint)
            self._file.append([encode(self._header)])
        self._file.append([encode(line)])

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
