"""Kinds of option values that several commands take."""

from __future__ import annotations

from typing import Any

import click
from click.shell_completion import CompletionItem

from vencejo.errors import nearest


class Word(click.ParamType):  # type: ignore[type-arg]
    """One of a few words; a mistyped one gets the nearest."""

    def __init__(self, words: list[str]) -> None:
        self.words = words
        self.name = "|".join(words)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        if value in self.words:
            return str(value)
        self.fail(f"'{value}' is none of {', '.join(self.words)}; {nearest(value, self.words)}")

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        return [CompletionItem(word) for word in self.words if word.startswith(incomplete)]


class Speed(click.ParamType):  # type: ignore[type-arg]
    """``max`` (None) or a factor above 0."""

    name = "factor|max"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | None:
        if value is None or value == "max":
            return None
        try:
            factor = float(str(value).removesuffix("x"))
        except ValueError:
            factor = 0.0
        if not 0 < factor < 1e6:
            self.fail(f"'{value}' is neither a factor above 0 nor max; for instance --speed 2")
        return factor

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        return [
            CompletionItem(word) for word in ("max", "1", "2", "5") if word.startswith(incomplete)
        ]


class MissionName(click.ParamType):  # type: ignore[type-arg]
    """A mission by path or name."""

    name = "mission"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        return str(value)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from cli.missions import names

        known = [CompletionItem(name) for name in names() if name.startswith(incomplete)]
        return [*known, CompletionItem(incomplete, type="file")]


def assignments(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> dict[str, str]:
    """``name=value`` pairs of a repeated option."""
    found = {}
    for value in values:
        name, equals, text = value.partition("=")
        if not equals or not name:
            raise click.BadParameter(f"'{value}' is not name=value", ctx=ctx, param=param)
        found[name.strip()] = text
    return found
