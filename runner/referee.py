"""The referee of a fleet: how long one vehicle stays near another, and how often it loses it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from fsm.engine.instance import Record
from vencejo.errors import UserError
from vencejo.geometry import Point, distance
from vencejo.nodes import Scalar, YamlNode
from vencejo.nodes import Sequence as ListNode
from worlds.values import SIZE, Field, Value, record

LOST = "target.lost"
"""The event that a pursuer raises when its target is out of sight."""
NEAR = 4.0
"""Distance that counts as near unless the fleet says another, metres."""


class Contest(NamedTuple):
    """What the referee looks at."""

    between: tuple[str, str]
    """The names of the pursuer and of whom it pursues."""
    near: float = NEAR
    """Distance up to which it counts as near, metres."""


class Verdict(NamedTuple):
    """How a contest went, while both vehicles were in the air."""

    contest: Contest
    time: float = 0.0
    """For how long they were, seconds."""
    time_near: float = 0.0
    """For how long of that they were near each other, seconds."""
    mean_distance: float = 0.0
    """Metres, between the vehicles' own places."""
    losses: int = 0
    """How often the pursuer raised ``target.lost``."""


class Referee:
    """Keeps the figures of one contest during a flight."""

    def __init__(self, contest: Contest) -> None:
        self.contest = contest
        self._time = self._near = self._sum = 0.0
        self._losses = 0

    def update(self, places: Sequence[Point], flying: bool, dt: float) -> None:
        """The pursuer and the other are at these places, both in the air or not, for ``dt``
        seconds.
        """
        if flying:
            far = distance(*places)
            self._time += dt
            self._sum += far * dt
            self._near += dt if far <= self.contest.near else 0.0

    def hear(self, records: Sequence[Record]) -> None:
        """Take what happened to the pursuer in a period."""
        self._losses += sum(
            kind == "event" and fields.get("name") == LOST for kind, fields in records
        )

    def verdict(self) -> Verdict:
        mean = self._sum / self._time if self._time > 0 else 0.0
        return Verdict(self.contest, self._time, self._near, mean, self._losses)


def _pair(node: YamlNode) -> tuple[Scalar, Scalar]:
    items = node.items if isinstance(node, ListNode) else []
    names = [item for item in items if isinstance(item, Scalar)]
    if len(items) != 2 or len(names) != 2 or names[0].text == names[1].text:
        message, hint = "a referee looks at two vehicles", "between: [cat, mouse]"
        raise UserError("wrong-type", message, node.where, hint)
    return names[0], names[1]


_PAIR = Value(_pair, {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2})
REFEREE: Value[tuple[tuple[Scalar, Scalar], float]] = record(
    "a referee",
    {"between": Field(_PAIR), "near": Field(SIZE, NEAR)},
    lambda between, near: (between, near),
)
"""The referee that a fleet asks for: the names of two vehicles, and what is near."""


def contest_fields(contest: Contest) -> dict[str, Any]:
    """A contest as an object for JSON."""
    return {"between": list(contest.between), "near": contest.near}


def contest_of(fields: Mapping[str, Any]) -> Contest:
    """The contest in that object."""
    first, second = fields["between"]
    return Contest((first, second), fields["near"])


def verdict_fields(verdict: Verdict) -> dict[str, Any]:
    """A verdict as an object for JSON, rounded."""
    return {
        "between": list(verdict.contest.between),
        "near_m": verdict.contest.near,
        "time_s": round(verdict.time, 3),
        "time_near_s": round(verdict.time_near, 3),
        "mean_distance_m": round(verdict.mean_distance, 3),
        "losses": verdict.losses,
    }


def verdict_of(fields: Mapping[str, Any]) -> Verdict:
    """The verdict in that object."""
    first, second = fields["between"]
    return Verdict(
        Contest((first, second), fields["near_m"]),
        fields["time_s"],
        fields["time_near_s"],
        fields["mean_distance_m"],
        fields["losses"],
    )
