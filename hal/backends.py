"""Backends by name: each is an entry point ``vencejo.backends`` that opens a session."""

from __future__ import annotations

from importlib.metadata import entry_points

from hal.vehicle import Options, Session
from vencejo.errors import UserError, nearest

GROUP = "vencejo.backends"


def backend_names() -> list[str]:
    """The backends that are installed."""
    return sorted({point.name for point in entry_points(group=GROUP)})


def open_backend(name: str, options: Options) -> Session:
    """Open a session of the backend; use it in a ``with``.

    Raises UserError (``unknown-backend``) and what the backend raises: UserError for a bad world,
    VehicleError when there is no vehicle to be had.
    """
    for point in entry_points(group=GROUP):
        if point.name == name:
            session: Session = point.load()(options)
            return session
    raise UserError(
        "unknown-backend", f"no backend is called '{name}'", hint=nearest(name, backend_names())
    )
