"""Fields of a run of one vehicle or several, as the files of a run folder have them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

ALONE = "drone"
"""The name of a vehicle that flies alone: the fields of its run need not name it."""


def are_alone(vehicles: Collection[str]) -> bool:
    """Whether these are all vehicles of a run of one that flies alone."""
    return list(vehicles) == [ALONE]


def joined(
    vehicles: Mapping[str, Mapping[str, Any]], run: Mapping[str, Any], order: Sequence[str]
) -> dict[str, Any]:
    """The fields of a run and its vehicles; those of one that flies alone stand among the run's."""
    fields = {**(vehicles[ALONE] if are_alone(vehicles) else {"vehicles": vehicles}), **run}
    return {name: fields[name] for name in order if name in fields}


def vehicles_of(fields: Mapping[str, Any]) -> Mapping[str, Mapping[str, Any]]:
    """The fields of each vehicle, from those of a run."""
    vehicles: Mapping[str, Mapping[str, Any]] = fields.get("vehicles", {ALONE: fields})
    return vehicles
