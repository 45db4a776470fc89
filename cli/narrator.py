"""The narrator: what happens to a vehicle, period by period, in lines for a person."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from behaviors import Pilot
from fsm import Graph
from fsm.engine.instance import Record
from runner.course import collisions, entered, in_words


class Line(NamedTuple):
    """One thing that happened."""

    kind: Literal["state", "note", "collision"]
    text: str
    state: str = ""
    """The path of the state that was entered; empty of other lines."""


class Narrator:
    """Tells what happens to one vehicle: states entered and why, collisions, notes."""

    def __init__(self) -> None:
        self._told_until = -1.0

    def tell(self, pilot: Pilot, records: Sequence[Record]) -> Iterator[Line]:
        """The lines of a period with these records, in the order in which things happened."""
        seen = pilot.channel.world
        # A period is shown once more when the backend fails after it.
        if seen.events and seen.time > self._told_until:
            for thing in collisions(seen):
                yield Line("collision", f"collision with {thing}")
        self._told_until = seen.time
        states = entered(pilot.instance, records) if records else []
        for kind, fields in records:
            if kind == "enter" and states and states[0].state == fields["state"]:
                _, state, why = states.pop(0)
                yield Line("state", f"→ {state}{_in_brackets(why)}", state)
            elif text := note(kind, fields):
                yield Line("note", text)


def note(kind: str, fields: Mapping[str, Any]) -> str | None:
    """A record as a text for a person, or None when it is not worth one."""
    text = None
    match kind:
        case "log":
            text = str(fields["text"])
        case "error":
            text = f"error: {fields['message']} ({fields['where']})"
        case "reaction":
            does = "landing" if fields["does"] == "land" else "the mission stands still"
            text = f"nobody handles {fields['event']}: {does}"
        case "landing":
            text = "landing past the mission"
        case "refused":
            text = f"the vehicle refuses a set-point{_in_brackets(fields['reason'])}"
        case "authority":
            text = f"commanded by: {fields['authority']}{_in_brackets(fields['reason'])}"
        case "link":
            text = f"the link is {fields['link']}"
        case "event" if fields["name"] == "failed" and not fields["taken"]:
            reason = in_words(fields.get("fields", {}))
            text = f"{fields['state']} failed" + (f": {reason}" if reason else "")
    return text


def _in_brackets(why: str | None) -> str:
    """A reason to stand behind what it explains; empty for none."""
    return f" ({why})" if why else ""


def clock(seconds: float) -> str:
    """Minutes and seconds: ``1:23.4``."""
    minutes, rest = divmod(seconds, 60)
    return f"{int(minutes)}:{rest:04.1f}"


def behavior_of(graph: Graph, state: str) -> str:
    """The name of a state's behaviour; empty for none, and where the state has the same name."""
    node = graph.by_path[state]
    name = node.invocation.behavior.name if node.invocation else ""
    return "" if name == node.local_name else name


def height_of(pilot: Pilot) -> str:
    """The height above home: ``2.0 m``."""
    # Adding zero turns the -0.0 of a vehicle at rest into 0.0.
    return f"{round(pilot.channel.observation.position.z, 1) + 0.0:.1f} m"
