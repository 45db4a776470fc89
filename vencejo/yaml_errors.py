"""What is wrong with a text that is no YAML: the place of the cause, and a hint to the remedy.

libyaml reports the place where it cannot go on. The cause often lies before it: a quote or bracket
that is not closed, a line that begins in another column than those beside it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import yaml

from vencejo.errors import Correction, UserError, Where

_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""The characters that YAML 1.2 allows nowhere (production 1, c-printable)."""
_QUOTED = re.compile(r"""(?<![^\s\[{(,:])(?:"(?:[^"\\]|\\.)*"|'(?:[^']|'')*')""", re.DOTALL)
"""A quoted text where one may begin."""
_DOLLAR = '`${…}` inside `{ }` or `[ ]` needs quotes: "${…}"'
_STAR = 'an event that takes all is written "*", with quotes'
_FLOW = "inside `{ }` a key or text with `[`, `{` or `,` needs quotes, or use block style"
_ESCAPE = "in double quotes a backslash begins an escape; use single quotes"
_SPECIAL = "a text that begins with a special character needs quotes"
_NO_COLON = "is a colon with a blank after it missing in the line above?"
_COLON = "a text that contains `: ` needs quotes"
_INDENT = (
    "mind the indentation: the keys of one map begin in one column, and those inside it further "
    "right"
)


def place_in(text: str, position: int, file: str) -> Where:
    """The place of a character of a file's text."""
    before = text[:position]
    return Where(file, before.count("\n") + 1, position - before.rfind("\n"))


def control_character(text: str, file: str) -> UserError | None:
    """The error of the first character that YAML does not allow; None where all may stand."""
    found = _UNPRINTABLE.search(text)
    if found is None:
        return None
    letter = ord(found[0])
    hint = f'remove it; in a text in double quotes it is written "\\x{letter:02x}"'
    return UserError(
        "bad-yaml",
        f"this is no YAML: the control character U+{letter:04X} may not stand in it",
        place_in(text, found.start(), file),
        hint if letter else "save the file as UTF-8: UTF-16 has such characters",
    )


def syntax_error(error: yaml.MarkedYAMLError, file: str, text: str) -> UserError:
    """The error of the YAML parser, at its cause and with a hint where that is known."""
    found = _Mistake.of(error, text)
    tab = _tab(found)
    if tab is not None:
        message, hint = "a tab stands in the indentation", "indent with spaces; YAML allows no tabs"
        return UserError("tab-indent", message, Where(file, *tab), hint)
    cause = _open_quote(found) or _open_bracket(found)
    mark = error.problem_mark or error.context_mark
    if cause is not None:
        where = place_in(text, cause[0], file)
    else:
        where = Where(file, mark.line + 1, mark.column + 1) if mark else Where(file, 1, 1)
    problem = error.problem or "the text cannot be read"
    context = f" {error.context}" if error.context else ""
    message = f"this is no YAML: {problem}{context}"
    return UserError("bad-yaml", message, where, cause[1] if cause else found.hint)


@dataclass(frozen=True)
class _Mistake:
    """The words of the parser, and the two places that it gives: counted from the text's begin."""

    problem: str
    context: str
    position: int
    begun: int
    """Where the collection or text begins in which it is."""
    text: str

    @classmethod
    def of(cls, error: yaml.MarkedYAMLError, text: str) -> _Mistake:
        mark = error.problem_mark or error.context_mark
        position = _position(mark, text)
        begun = _position(error.context_mark, text) if error.context_mark else position
        return cls(error.problem or "", error.context or "", position, begun, text)

    @property
    def line(self) -> str:
        """The line of the problem."""
        begin = self.text.rfind("\n", 0, self.position) + 1
        return self.text[begin:].partition("\n")[0]

    @property
    def begins_line(self) -> bool:
        """Whether nothing stands before the problem in its line."""
        return not self.text[: self.position].rpartition("\n")[2].strip()

    @property
    def hint(self) -> str | None:
        """The remedy, by what stands in the line."""
        line, letter = self.line, self.text[self.position : self.position + 1]
        signs = {
            _quoted(r"\$\{[^{}\"']*\}", line, _DOLLAR): re.search(r"[{,\[:]\s*\$\{", line),
            _quoted(r"\*(?=\s*:)", line, _STAR): re.search(r"(^|[\s{,])\*\s*:", line),
            _ESCAPE: "escape" in self.problem,
            _SPECIAL: "any token" in self.problem or "block scalar" in self.context,
            _NO_COLON: "expected ':'" in self.problem,
            _INDENT: self.begins_line or "document start" in self.problem or self.first_key,
            _FLOW: "flow" in self.context,
            f"one `{letter}` is too many": letter in ("}", "]"),
            _COLON: "mapping values" in self.problem,
        }
        return next((hint for hint, sign in signs.items() if sign), None)

    @property
    def first_key(self) -> bool:
        """Whether the first key of a line is where none may stand."""
        before = self.text[: self.position].rpartition("\n")[2]
        return "mapping values" in self.problem and ": " not in before


def _quoted(pattern: str, line: str, hint: str) -> str:
    """A hint to put quotes around what a pattern finds; a correction where it finds one thing."""
    found = re.findall(pattern, line)
    return Correction(found[0], f'"{found[0]}"', hint) if len(found) == 1 else hint


def _position(mark: yaml.Mark | None, text: str) -> int:
    """The position of a mark of the parser."""
    position = 0
    for _ in range(mark.line if mark else 0):
        position = text.find("\n", position) + 1 or len(text)
    return min(position + (mark.column if mark else 0), len(text))


def _tab(found: _Mistake) -> tuple[int, int] | None:
    """Line and column of a tab in the indentation, here or in the line before."""
    number = found.text.count("\n", 0, found.position)
    lines = found.text.split("\n")
    for index in (number, number - 1):
        line = lines[index] if 0 <= index < len(lines) else ""
        tab = line[: len(line) - len(line.lstrip())].find("\t")
        if tab >= 0:
            return index + 1, tab + 1
    return None


def _open_quote(found: _Mistake) -> tuple[int, str] | None:
    """The quote that was never closed, or only by one that was meant to open another text."""
    if "scanning a quoted scalar" in found.context:
        return found.begun, "the quote that opens here is not closed"
    for quoted in _QUOTED.finditer(found.text):
        between = found.text[quoted.end() : found.position]
        if quoted.end() <= found.position and not between.strip(" "):
            if "\n" in quoted[0]:
                return quoted.start(), "the quote that opens here is not closed in its line"
            return found.position, "a text in quotes ends with its quote: put all of it in quotes"
    return None


def _open_bracket(found: _Mistake) -> tuple[int, str] | None:
    """The bracket that is not closed where the next line begins."""
    across = "\n" in found.text[found.begun : found.position]
    if "flow" not in found.context or not across or "expected ','" not in found.problem:
        return None
    bracket = found.text[found.begun]
    return found.begun, f"the `{bracket}` that opens here is not closed"
