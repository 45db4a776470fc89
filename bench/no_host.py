"""A host for charts without behaviours and without calls of functions."""

from __future__ import annotations

from typing import Any


class NoHost:
    """Refuses everything that a graph may ask its host for (see :class:`fsm.Host`)."""

    def begin(self, *_: Any) -> Any:
        raise NotImplementedError

    def call(self, *_: Any) -> None:
        raise NotImplementedError
