"""One chart in both: what differs between our engine and the interpreter of appendix D."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from bench.no_host import NoHost
from fsm import Graph, Instance, Vocabulary, compile_mission, read_mission_text
from fsm.scxml import load_document, parse_document
from tests.fsm.appendix_d.charts import State
from tests.fsm.appendix_d.interpreter import EndlessError, Interpreter
from tests.fsm.appendix_d.writers import mission_of, scxml_of


class MissionInterpreter(Interpreter):
    """Appendix D, but as missions want it: the outcome of a state left meanwhile is dropped."""

    def leave(self, state: State) -> None:
        super().leave(state)
        self.queue = deque(event for event in self.queue if event[1] is not state)


def difference(root: State, events: list[str], mission: bool) -> str:
    """The first differing line of the traces with what came before it; empty when all are equal."""
    expected = trace_of_appendix_d(root, events, mission)
    found = [*trace_of_engine(root, events, len(expected), mission)]
    for step, (right, line) in enumerate(zip(expected, found, strict=True)):
        for place, pair in enumerate(zip([*right, "nothing"], [*line, "nothing"], strict=False)):
            if pair[0] != pair[1]:
                before = "".join(f"  {each}\n" for each in right[:place])
                return f"step {step}\n{before}  appendix D: {pair[0]}\n  engine: {pair[1]}"
    return ""


def trace_of_appendix_d(root: State, events: list[str], mission: bool) -> list[list[str]]:
    """What happens at the start, at each event and in the end. It stops where a step is endless."""
    running = (MissionInterpreter if mission else Interpreter)(root)
    found = []
    moves: list[Callable[[], None]] = [running.start]
    moves += [lambda event=event: running.hear(event) for event in events]  # type: ignore[misc]
    for move in moves:
        try:
            move()
        except EndlessError:
            return found
        active = running.in_entry_order(running.configuration)
        found.append([*running.trace, f"active: {' '.join(state.id for state in active)}"])
        running.trace = []
        if not running.running:
            break
    running.exit()
    return [*found, running.trace]


def trace_of_engine(
    root: State, events: list[str], steps: int, mission: bool
) -> Iterator[list[str]]:
    instance = Instance(graph_of(root, mission), NoHost())
    for step in range(steps):
        if step > len(events) or instance.ended:
            instance.stop()
            yield [_line(*record) for record in instance.records]
            return
        if step:
            instance.post(events[step - 1])
        instance.period(float(step))
        active = f"active: {' '.join(_id(node.path) for node in instance.active)}"
        yield [*(_line(*record) for record in instance.records), active]
        instance.records = []


def graph_of(root: State, mission: bool) -> Graph:
    if mission:
        return compile_mission(read_mission_text(mission_of(root), "chart.yaml"), Vocabulary())
    return load_document(parse_document(scxml_of(root), "chart.scxml"), "chart")


def _id(path: str) -> str:
    return path.rpartition(".")[2] or "root"


def _line(what: str, fields: Mapping[str, Any]) -> str:
    match what:
        case "event":
            name = f"done.state.{_id(fields['state'])}" if "state" in fields else fields["name"]
            return f"event {name}{'' if fields['taken'] else ' unheard'}"
        case "transition":
            source, targets = _id(fields["from"]), " ".join(map(_id, fields["to"]))
            by = fields["by"].removeprefix("on ")
            return f"{source} -> {targets} by {f'done.state.{source}' if by == 'done' else by}"
        case "log":
            return f"log {fields['text']}"
        case _:
            return f"{what} {_id(fields.get('state', '')) or fields}"
