"""The plan of a run: who flies what, where, on which backend, and with which settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from hal import Limits
from runner.by_vehicle import ALONE
from runner.posts import Post
from runner.preparation import Prepared
from worlds import World


@dataclass(frozen=True)
class Assignment:
    """The mission of one vehicle, with its parameters."""

    prepared: Prepared
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """Values of the mission's parameters, as ``fsm.parse_parameters`` gives them."""

    @property
    def all_parameters(self) -> dict[str, Any]:
        """Their values, with the defaults of those that are not given."""
        known = self.prepared.graph.parameters
        return {name: self.parameters.get(name, known[name].default) for name in known}


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
    """Events that every mission is told, in the order of their times."""

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
    def mission_name(self) -> str:
        """The name of the first vehicle's mission."""
        return self._any.graph.name

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
