"""Backends by name: each is an entry point ``vencejo.backends`` that opens a session."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import EntryPoint

from hal.flight_model import FlightModel, Models, VehicleModel
from hal.vehicle import Options, Session
from vencejo.errors import UserError, VehicleError, Where, nearest
from vencejo.plugins import plugins

GROUP = "vencejo.backends"


def backend_names() -> list[str]:
    """The backends that are installed."""
    return sorted(plugins(GROUP))


def backend_models(name: str) -> Models | None:
    """The models of a backend's vehicles, by ``MODELS`` of its module; opens nothing.

    None where all are of one kind. Raises UserError (``unknown-backend``).
    """
    models: Models | None = getattr(import_module(_point(name).module), "MODELS", None)
    return models


def vehicle_model(
    name: str, model: str | None = None, where: Where | None = None
) -> VehicleModel | None:
    """A model of a backend's vehicles, by name or path, None for its default; opens nothing.

    None where the backend has no models. Raises UserError (``unknown-backend``, ``no-models`` for
    a model that ``where`` names, and what reading its file raises).
    """
    models = backend_models(name)
    if models is not None:
        return models.find(model, where)
    if model is not None:
        message = f"the vehicles of the backend '{name}' have no models to choose from"
        raise UserError("no-models", message, where, "models are the simulator's: --backend sim")
    return None


def backend_capabilities(name: str, model: str | None = None) -> frozenset[str]:
    """The capabilities of a backend's vehicles of a model; opens nothing.

    Where there are no models, by ``CAPABILITIES`` of its module. Raises UserError
    (``unknown-backend``, ``unknown-capabilities``, and what :func:`vehicle_model` raises).
    """
    found = vehicle_model(name, model)
    if found is not None:
        return found.capabilities
    offered = getattr(import_module(_point(name).module), "CAPABILITIES", None)
    if offered is None:
        raise UserError(
            "unknown-capabilities",
            f"the backend '{name}' does not say what its vehicles can do",
            hint="its module declares CAPABILITIES; without it only a flight can tell",
        )
    return frozenset(offered)


def flight_model(name: str, model: str | None = None) -> FlightModel | None:
    """How a backend's vehicles of a model fly; opens nothing.

    Where there are no models, by ``FLIGHT_MODEL`` of its module; None where that is missing.
    Raises UserError (``unknown-backend``, and what :func:`vehicle_model` raises).
    """
    found = vehicle_model(name, model)
    if found is not None:
        return found.flight
    flight: FlightModel | None = getattr(import_module(_point(name).module), "FLIGHT_MODEL", None)
    return flight


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
