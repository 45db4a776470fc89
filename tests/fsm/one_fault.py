"""The one fault of a mistake, in a line to compare with."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from vencejo.errors import UserError


def fault_of(call: Callable[..., object], *arguments: object, hint: bool = False) -> str:
    """The fault that a call raises: place, code, message, and with ``hint`` that in parentheses."""
    with pytest.raises(UserError) as raised:
        call(*arguments)
    (fault,) = raised.value.faults
    assert fault.where is not None
    cure = f" ({fault.hint})" if hint and fault.hint else ""
    return f"{fault.where.line}:{fault.where.column} {fault.code} {fault.message}{cure}"
