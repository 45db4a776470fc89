"""The models of a plan's vehicles, and what missions ask of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

from fsm import Graph
from fsm.chart.graph import Node
from hal import FlightModel, VehicleModel, backend_models, flight_model, vehicle_model
from runner.plan import Assignment
from vencejo.errors import Fault, Severity, UserError, Where

_CAMERA = "camera."


def models_of(
    backend: str, assignments: Mapping[str, Assignment]
) -> dict[str, VehicleModel | None]:
    """The model of each vehicle: its own, its world's, or the backend's default.

    None for a backend without models. Raises UserError (``unknown-model``, ``no-models``, and every
    fault of a model's file).
    """
    found, faults = dict[str, VehicleModel | None](), list[Fault]()
    for name, flown in assignments.items():
        try:
            found[name] = _model_of(backend, flown)
        except UserError as error:
            faults += error.faults
    if faults:
        raise UserError.of(dict.fromkeys(faults))
    return found


def _model_of(backend: str, flown: Assignment) -> VehicleModel | None:
    if flown.model is not None:
        return vehicle_model(backend, flown.model, flown.model_where)
    world = flown.prepared.world
    if backend_models(backend) is None:
        return None
    return vehicle_model(backend, world.model, Where(str(world.source)) if world.model else None)


def flight_of(backend: str, model: VehicleModel | None) -> FlightModel | None:
    """How the vehicles of a backend and model fly; None where that is not known."""
    return model.flight if model else flight_model(backend)


def faults_of_models(
    assignments: Mapping[str, Assignment], models: Mapping[str, VehicleModel | None]
) -> Iterator[Fault]:
    """Faults for missions that ask two things at once of which their vehicle's model has one."""
    told = set[Fault]()
    for name, model in models.items():
        if model is not None and model.one_active_camera:
            for fault in _camera_conflicts(assignments[name].prepared.graph, model):
                if fault not in told:
                    told.add(fault)
                    yield fault


def _camera_conflicts(graph: Graph, model: VehicleModel) -> Iterator[Fault]:
    users = [node for node in graph.nodes if _cameras(node)]
    for node in users:
        if len(_cameras(node)) > 1:
            yield _conflict(node, node, model, "error")
    for one, other in combinations(users, 2):
        if _cameras(one) != _cameras(other) and _together(one, other):
            yield _conflict(one, other, model, "warning")


def _cameras(node: Node) -> frozenset[str]:
    """The cameras that a state's behaviour needs."""
    if node.invocation is None:
        return frozenset()
    return frozenset(
        word.removeprefix(_CAMERA)
        for word in node.invocation.required()
        if word.startswith(_CAMERA)
    )


def _together(one: Node, other: Node) -> bool:
    """Whether two states can be active at the same time."""
    if one in other.ancestors or other in one.ancestors:
        return True
    common = next(node for node in one.ancestors if node in other.ancestors)
    return common.type == "parallel"


def _conflict(one: Node, other: Node, model: VehicleModel, severity: Severity) -> Fault:
    needed = " and ".join(f"'{name}'" for name in sorted(_cameras(one) | _cameras(other)))
    who = f"'{_name(other)}' needs"
    if one is not other:
        who = f"'{_name(one)}' and '{_name(other)}' can be active together and need"
    return Fault(
        "two-cameras",
        f"{who} the cameras {needed}, of which the model '{model.name}' has one active at a time",
        other.where,
        "let one state follow the other, or fly a model whose cameras are all active",
        severity,
    )


def _name(node: Node) -> str:
    return node.invocation.behavior.name if node.invocation else node.path


def missing_capabilities(graph: Graph, offered: frozenset[str], who: str) -> Iterator[Fault]:
    """Faults for the capabilities that a mission needs and ``who`` does not offer."""
    for capability, needed in graph.required().items():
        if capability not in offered:
            yield Fault(
                "missing-capability",
                f"'{needed.by}' needs '{capability}', which {who} does not offer",
                needed.where,
                f"it offers: {', '.join(sorted(offered))}",
            )
