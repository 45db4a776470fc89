"""The plan of a run: who flies what, where, on which backend, and with which settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

from fsm.fleet import Until
from hal import Limits, VehicleSpec
from hal.lights import Rgb
from runner.by_vehicle import ALONE
from runner.posts import Post
from runner.preparation import Prepared
from runner.referee import Contest
from vencejo.errors import Where
from worlds import Start, World
from worlds.starts import starts_for


@dataclass(frozen=True)
class Assignment:
    """The mission of one vehicle with its parameters, and what is asked of the vehicle."""

    prepared: Prepared
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """Values of the mission's parameters, as ``fsm.parse_parameters`` gives them."""
    stands: bool = False
    """Whether it has no mission of its own: it stands until all others are down."""
    model: str | None = None
    """The name of its model, or the path of its file; None for the world's, or the default."""
    model_where: Where | None = None
    """The place that names it, for messages."""
    start: Start | None = None
    """Its start, world frame; None for one of the world's."""
    color: Rgb | None = None
    """The colour of its hull; None for its start's, its model's, or one that its name decides."""

    @property
    def model_word(self) -> str | None:
        """The word for its model: its own, or else its world's; None for the default."""
        return self.model or self.prepared.world.model

    @property
    def all_parameters(self) -> dict[str, Any]:
        """Their values, with the defaults of those that are not given."""
        known = self.prepared.graph.parameters
        return {name: self.parameters.get(name, known[name].default) for name in known}


def with_model(
    assignments: Mapping[str, Assignment], model: str | None, where: Where
) -> dict[str, Assignment]:
    """The same with another model for all vehicles, which ``where`` names; None for their own."""
    if model is None:
        return dict(assignments)
    return {
        name: replace(each, model=model, model_where=where) for name, each in assignments.items()
    }


def starts_of(assignments: Mapping[str, Assignment]) -> dict[str, Start]:
    """The start of each vehicle of a run, world frame: its own, or one of the world's."""
    if not assignments:
        return {}
    world = next(iter(assignments.values())).prepared.world
    found = starts_for(world, [each.start for each in assignments.values()])
    return dict(zip(assignments, found, strict=True))


@dataclass(frozen=True)
class Fleet:
    """What holds for the vehicles of a fleet together."""

    name: str
    until: Until | None = None
    """The condition that ends the flight of all."""
    file: Path | None = None
    """The fleet's own file, to be kept with the run."""
    contest: Contest | None = None
    """What its referee looks at; None for none."""


@dataclass(frozen=True)
class Plan:
    """The plan of a run: the missions of its vehicles, all in one world.

    Raises ValueError for no vehicle, and for missions that were prepared for different worlds.
    """

    assignments: Mapping[str, Assignment]
    """Name of a vehicle → its mission, in the order of the start places and of each period."""
    backend: str = "sim"
    seed: int = 0
    settings: Mapping[str, object] = field(default_factory=dict)
    """Settings of that backend only, such as the simulator's ``noise``."""
    address: str | None = None
    """Address of a real vehicle; None for the simulator."""
    profile: str | None = None
    """Named limits of flight of the vehicles, such as ``indoor``."""
    limits: Limits = field(default_factory=Limits)
    """Limits of flight that override the profile's, altitudes above home."""
    camera_file: Path | None = None
    """The file from which its cameras were set, to be kept with the run."""
    posts: tuple[Post, ...] = ()
    """Events that missions are told, in the order of their times."""
    fleet: Fleet | None = None
    """None for missions that no fleet joins."""

    def __post_init__(self) -> None:
        worlds = {assignment.prepared.world.sha256 for assignment in self.assignments.values()}
        if len(worlds) != 1:
            raise ValueError("a plan needs at least one vehicle, and all missions in one world")

    @classmethod
    def alone(
        cls,
        prepared: Prepared,
        parameters: Mapping[str, Any] | None = None,
        *,
        backend: str = "sim",
        seed: int = 0,
        settings: Mapping[str, object] | None = None,
    ) -> Self:
        """A plan for a single vehicle."""
        return cls({ALONE: Assignment(prepared, parameters or {})}, backend, seed, settings or {})

    @property
    def vehicles(self) -> tuple[VehicleSpec, ...]:
        """The vehicles that a session is asked for."""
        return tuple(
            VehicleSpec(name, each.model, each.start, each.color)
            for name, each in self.assignments.items()
        )

    @property
    def starts(self) -> dict[str, Start]:
        """The start of each vehicle, world frame."""
        return starts_of(self.assignments)

    @property
    def name(self) -> str:
        """The name of the fleet, or of the first vehicle's mission."""
        return self.fleet.name if self.fleet else self._any.graph.name

    @property
    def world(self) -> World:
        return self._any.world

    @property
    def world_word(self) -> str:
        """The name or path by which a backend finds that world."""
        return self._any.world_word

    @property
    def _any(self) -> Prepared:
        return next(iter(self.assignments.values())).prepared
