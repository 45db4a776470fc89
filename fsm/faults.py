"""Collects faults, so that one look at a mission shows them all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from vencejo.errors import Fault, UserError, Where


class Faults(list[Fault]):
    """The faults found so far."""

    def fail(self, code: str, message: str, where: Where | None, hint: str | None = None) -> None:
        self.append(Fault(code, message, where, hint))

    def warn(self, code: str, message: str, where: Where, hint: str) -> None:
        self.append(Fault(code, message, where, hint, "warning"))

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """Keep what a UserError says, and go on after the block."""
        try:
            yield
        except UserError as error:
            self.extend(error.faults)

    def raise_any(self) -> None:
        """Raise UserError with all of them, if there are any."""
        if self:
            raise UserError.of(self)
