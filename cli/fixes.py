"""Fixes of faults: the text to put into a file in place of another one."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from vencejo.errors import Correction, Fault


@dataclass(frozen=True)
class Fix:
    """Write ``text`` between two places of a file; all count from 1, and the end is exclusive."""

    file: str
    line: int
    column: int
    end_line: int
    end_column: int
    text: str


def fix_of(fault: Fault) -> Fix | None:
    """The fix of a fault whose cure is certain and whose file still reads as it was checked."""
    hint, where = fault.hint, fault.where
    if not isinstance(hint, Correction) or where is None or not where.line:
        return None
    try:
        line = Path(where.file).read_text("utf-8-sig").split("\n")[where.line - 1]
    except (OSError, ValueError, IndexError):
        return None  # no file: a value of the command line, for instance
    begin = _found(hint.wrong, line, where.column - 1)
    if begin is None:
        return None
    end = begin + len(hint.wrong)
    return Fix(where.file, where.line, begin + 1, where.line, end + 1, hint.right)


def _found(wrong: str, line: str, place: int) -> int | None:
    """Where a text begins in a line: at the place of the fault, or else where it stands alone."""
    word = rf"(?<!\w){re.escape(wrong)}(?!\w)" if wrong[:1].isalnum() else re.escape(wrong)
    at = [match.start() for match in re.finditer(word, line)]
    if place in at:
        return place
    return at[0] if len(at) == 1 else None
