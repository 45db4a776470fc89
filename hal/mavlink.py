"""The backend for PX4 and ArduPilot over MAVLink: not implemented yet."""

from __future__ import annotations

from hal.vehicle import Options, Session
from vencejo.errors import UserError


def open_session(options: Options) -> Session:
    """Raises UserError: this version flies the simulator only."""
    raise UserError(
        "backend-not-built",
        "the backend 'mavlink' is not there yet; this version flies in the simulator only",
        hint="fly the same file with --backend sim",
    )
