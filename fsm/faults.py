"""A list that collects faults, so that one check of a mission reports them all."""

from __future__ import annotations

from dataclasses import dataclass
from types import TracebackType

from vencejo.errors import Fault, UserError, Where


class Faults(list[Fault]):
    """The faults found so far."""

    def fail(self, code: str, message: str, where: Where | None, hint: str | None = None) -> None:
        """Add an error."""
        self.append(Fault(code, message, where, hint))

    def warn(self, code: str, message: str, where: Where, hint: str) -> None:
        """Add a warning."""
        self.append(Fault(code, message, where, hint, "warning"))

    @property
    def errors(self) -> int:
        """The number of faults that are errors, not warnings."""
        return sum(fault.severity == "error" for fault in self)

    def collecting(self) -> _Collecting:
        """A context manager that adds the faults of a UserError, and goes on after the block."""
        return _Collecting(self)

    def raise_any(self) -> None:
        """Raise UserError with all of them, if there are any."""
        if self:
            raise UserError.of(self)


@dataclass(slots=True)
class _Collecting:
    """A context manager entered for nearly every line of a mission: ``contextlib`` is too slow."""

    faults: Faults

    def __enter__(self) -> None:
        """Nothing to prepare."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> bool:
        if not isinstance(error, UserError):
            return False
        self.faults.extend(error.faults)
        return True
