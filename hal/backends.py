"""Backends by name: each is an entry point ``vencejo.backends`` that opens a session."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import EntryPoint

from hal.flight_model import FlightModel
from hal.vehicle import Options, Session
from vencejo.errors import UserError, VehicleError, nearest
from vencejo.plugins import plugins

GROUP = "vencejo.backends"


def backend_names() -> list[str]:
    """The backends that are installed."""
    return sorted(plugins(GROUP))


def backend_capabilities(name: str) -> frozenset[str]:
    """The capabilities of a backend's vehicles, by ``CAPABILITIES`` of its module; opens nothing.

    Raises UserError (``unknown-backend``, ``unknown-capabilities``).
    """
    offered = getattr(import_module(_point(name).module), "CAPABILITIES", None)
    if offered is None:
        raise UserError(
            "unknown-capabilities",
            f"the backend '{name}' does not say what its vehicles can do",
            hint="its module declares CAPABILITIES; without it only a flight can tell",
        )
    return frozenset(offered)


def flight_model(name: str) -> FlightModel | None:
    """How a backend's vehicles fly, by ``FLIGHT_MODEL`` of its module; opens nothing.

    None where it does not say. Raises UserError (``unknown-backend``).
    """
    model: FlightModel | None = getattr(import_module(_point(name).module), "FLIGHT_MODEL", None)
    return model


def open_backend(name: str, options: Options) -> Session:
    """Open a session of the backend; use it in a ``with``.

    Raises UserError (``unknown-backend``) and what the backend raises: UserError for a bad world,
    VehicleError when there is no vehicle to be had.
    """
    session: Session = _point(name).load()(options)
    return session


def not_heard(vehicle: str, options: Options) -> VehicleError:
    """The error of a vehicle that was not heard before the connection timed out."""
    where = f" at '{options.address}'" if options.address else ""
    return VehicleError(
        "not-heard",
        f"nothing was heard of '{vehicle}'{where} within {options.connect_timeout:g} s",
        hint="is it switched on, and is --connect its address? For a start: --backend sim",
    )


def _point(name: str) -> EntryPoint:
    if name not in plugins(GROUP):
        hint = nearest(name, backend_names())
        raise UserError("unknown-backend", f"no backend is called '{name}'", hint=hint)
    return plugins(GROUP)[name]
