"""The models of a plan's vehicles, and what missions ask of them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from fsm import Graph
from fsm.chart.graph import Node
from hal import VehicleModel, backend_models, vehicle_model
from runner.plan import Assignment
from vencejo.errors import Fault, Severity, Where

_CAMERA = "camera."


def model_of(backend: str, flown: Assignment) -> VehicleModel | None:
    """The model of a vehicle: its own, its world's, or the backend's default.

    None for a backend without models. Raises UserError (``unknown-model``, ``no-models``, and every
    fault of a model's file).
    """
    if flown.model is not None:
        return vehicle_model(backend, flown.model, flown.model_where)
    world = flown.prepared.world
    if backend_models(backend) is None:
        return None
    return vehicle_model(backend, world.model, Where(str(world.source)) if world.model else None)


def camera_conflicts(graph: Graph, model: VehicleModel) -> Iterator[Fault]:
    """Faults for what needs two cameras at once, on a model with one active camera."""
    if not model.one_active_camera:
        return
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
        for word in node.invocation.behavior.requires
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
    """Faults for the capabilities that behaviours need and ``who`` does not offer."""
    for capability, node in graph.required().items():
        if capability not in offered:
            yield Fault(
                "missing-capability",
                f"'{_name(node)}' needs '{capability}', which {who} does not offer",
                node.where,
                f"it offers: {', '.join(sorted(offered))}",
            )
