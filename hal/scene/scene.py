"""The things of a world and the vehicles in it, as a renderer shows them."""

from __future__ import annotations

from collections.abc import Mapping

from vencejo.geometry import Pose
from worlds.motion import pose_at
from worlds.things import Thing
from worlds.world import World


class Scene:
    """The visible things of a world by key, and the pose of each at a moment.

    A thing's key is its name. A vehicle may bear the name of a thing, so vehicles have keys of
    their own.
    """

    def __init__(self, world: World, vehicles: Mapping[str, Thing]) -> None:
        """``vehicles``: the appearance of each by its name, in its body frame."""
        self.world = world
        self._paths = {thing.name: thing for thing in world.things if thing.motion is not None}
        self._vehicles = {_vehicle_key(name): thing for name, thing in vehicles.items()}
        self.things = {thing.name: thing for thing in world.things} | self._vehicles
        """Everything there is to see, in the world's order and then the vehicles."""
        self.still = tuple(thing for thing in world.things if thing.motion is None)
        """The things that never move."""
        self.moving = self._paths | self._vehicles
        """The things that move, and then the vehicles."""

    def poses(self, time: float, vehicles: Mapping[str, Pose]) -> dict[str, Pose]:
        """World poses of what moves, by key, ``time`` seconds after the run began.

        ``vehicles``: the pose of each by its name; one without a pose is not to be seen.
        """
        poses = {key: pose_at(thing, time) for key, thing in self._paths.items()}
        for name, pose in vehicles.items():
            if (key := _vehicle_key(name)) in self._vehicles:
                poses[key] = pose
        return poses


def _vehicle_key(name: str) -> str:
    """No thing of a world has a space in its name."""
    return f" {name}"
