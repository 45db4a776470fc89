"""The conformance cases in other engines; prints the errors by engine and case as JSON.

Run by :mod:`bench.conformance` in an environment of its own; imports nothing of ours.
python-statemachine reads SCXML itself; for the others each case is translated. When an engine
cannot express a case, or refuses to build it, the verdict begins with ``cannot``.
"""

from __future__ import annotations

import json
import logging
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
from conformance_chart import PYTHON, CannotError, Case, Data, Move, State, read_case


class Transitions:
    """`transitions` HierarchicalMachine, events in a queue."""

    def __init__(self, case: Case) -> None:
        from transitions.extensions import HierarchicalMachine
        from transitions.extensions.nesting import NestedState

        NestedState.separator = "/"
        states = case.states
        _exact(case)
        for state in states.values():
            if state.kind == "history":
                raise CannotError("no history")
            for move in state.moves:
                if not move.events:
                    raise CannotError("no transitions without an event")
                _whole(move)

        class Model:
            state: Any

        self.model: Any = Model()
        self.data = Data(case, self.is_active, self.say)
        self.machine = HierarchicalMachine(
            self.model,
            states=[self.config(case.root)],
            initial=case.root.id,
            auto_transitions=False,
            ignore_invalid_triggers=True,
            queued=True,
        )
        for state in states.values():
            for move in state.moves:
                for event in move.events:
                    self.machine.add_transition(
                        event,
                        "/".join(state.path),
                        "/".join(states[move.targets[0]].path) if move.targets else None,
                        conditions=[lambda guard=move.guard: self.data.test(guard)],
                        before=[lambda lines=move.action: self.data.run(lines)],
                    )

    def config(self, state: State) -> dict[str, Any]:
        found: dict[str, Any] = {
            "name": state.id,
            "on_enter": [lambda: self.data.run(state.entry)],
            "on_exit": [lambda: self.data.run(state.exit)],
        }
        children = [self.config(child) for child in state.children]
        if state.kind == "parallel":
            found["parallel"] = children
        elif children:
            found["children"] = children
            found["initial"] = _child(state)
        return found

    def is_active(self, name: str) -> bool:
        return any(name in path.split("/") for path in _flat(self.model.state))

    def say(self, event: str, delay: float = 0) -> None:
        if delay:
            raise CannotError("no delays without threads")
        if event in self.machine.events:
            self.model.trigger(event)

    def start(self) -> None:
        """Nothing to do: the machine starts when it is constructed."""

    def wait(self, milliseconds: float) -> None:
        """Nothing to do: the machine has no clock."""

    def active(self) -> list[str]:
        return [path.split("/")[-1] for path in _flat(self.model.state)]


class Sismic:
    def __init__(self, case: Case) -> None:
        from sismic import model
        from sismic.clock import SimulatedClock
        from sismic.interpreter import Interpreter

        _exact(case)
        chart = model.Statechart(case.root.id)
        self.blocks: list[list[str]] = []
        self.said: list[tuple[str, float]] = []
        for state in case.states.values():
            parent = state.path[-2] if len(state.path) > 1 else None
            chart.add_state(self.state(state, model), parent)
        for state in case.states.values():
            for place, move in enumerate(state.moves if state.kind != "history" else ()):
                _whole(move)
                for event in move.events or [None]:
                    chart.add_transition(
                        model.Transition(
                            state.id,
                            move.targets[0] if move.targets else None,
                            event,
                            f"test({move.guard!r})" if move.guard else None,
                            self.code(move.action),
                            priority=-place,
                        )
                    )
        chart.validate()
        self.clock = SimulatedClock()
        self.data = Data(
            case, self.is_active, lambda event, delay: self.said.append((event, delay))
        )
        context = {"run": self.run, "test": self.data.test}
        self.interpreter = Interpreter(chart, initial_context=context, clock=self.clock)
        self.leaves = {state.id for state in case.root.all() if not state.children}

    def start(self) -> None:
        self.interpreter.execute()

    def state(self, state: State, model: Any) -> Any:
        hooks = {"on_entry": self.code(state.entry), "on_exit": self.code(state.exit)}
        if state.kind == "history":
            _single(state.moves[0])
            kind = model.DeepHistoryState if state.deep else model.ShallowHistoryState
            return kind(state.id, memory=state.moves[0].targets[0])
        if state.kind == "final":
            return model.FinalState(state.id, **hooks)
        if state.kind == "parallel":
            return model.OrthogonalState(state.id, **hooks)
        if not state.children:
            return model.BasicState(state.id, **hooks)
        return model.CompoundState(state.id, initial=_child(state), **hooks)

    def code(self, lines: list[str]) -> str | None:
        if not lines:
            return None
        self.blocks.append(lines)
        return f"for e, d in run({len(self.blocks) - 1}): send(e, delay=d) if d else send(e)"

    def run(self, block: int) -> list[tuple[str, float]]:
        self.data.run(self.blocks[block])
        said, self.said = self.said, []
        return [(event, delay / 1000) for event, delay in said]

    def is_active(self, name: str) -> bool:
        return name in self.interpreter.configuration

    def say(self, event: str) -> None:
        self.interpreter.queue(event)
        self.interpreter.execute()

    def wait(self, milliseconds: float) -> None:
        self.clock.time += milliseconds / 1000
        self.interpreter.execute()

    def active(self) -> list[str]:
        return [name for name in self.interpreter.configuration if name in self.leaves]


class XState:
    """`xstate-statemachine`; its transitions re-enter as SCXML's do."""

    def __init__(self, case: Case) -> None:
        from xstate_statemachine import MachineLogic, SyncInterpreter, create_machine
        from xstate_statemachine.clock import SimulatedClock

        self.actions: dict[str, Callable[..., Any]] = {}
        self.guards: dict[str, Callable[..., Any]] = {}
        self.ids = {state.id.replace(".", "_"): state.id for state in case.root.all()}
        self.paths = {
            state.id: ".".join(("m", *(name.replace(".", "_") for name in state.path)))
            for state in case.root.all()
        }
        self.by_prefix = case.by_prefix
        root = case.root.id.replace(".", "_")
        config = {"id": "m", "initial": root, "states": {root: self.config(case.root)}}
        logic = MachineLogic(actions=self.actions, guards=self.guards)
        machine = create_machine(config, logic=logic)
        self.data = Data(case, self.is_active, self.nested)
        self.clock = SimulatedClock()
        self.interpreter = SyncInterpreter(machine, clock=self.clock)
        self.leaves = {self.paths[state.id] for state in case.root.all() if not state.children}

    def start(self) -> None:
        self.interpreter.start()

    def config(self, state: State) -> dict[str, Any]:
        if state.kind == "history":
            _single(state.moves[0])
            depth = "deep" if state.deep else "shallow"
            target = f"#{self.paths[state.moves[0].targets[0]]}"
            return {"type": "history", "history": depth, "target": target}
        found: dict[str, Any] = {"entry": self.run(state.entry), "exit": self.run(state.exit)}
        if state.kind != "state":
            found["type"] = state.kind
        elif state.children:
            found["initial"] = _child(state).replace(".", "_")
        if state.children:
            found["states"] = {c.id.replace(".", "_"): self.config(c) for c in state.children}
        for move in state.moves:
            _single(move)
            if not move.events:
                found.setdefault("always", []).append(self.move(move))
            for event in move.events:
                name = event if "*" in event or not self.by_prefix else event + ".*"
                found.setdefault("on", {}).setdefault(name, []).append(self.move(move))
        return found

    def move(self, move: Move) -> dict[str, Any]:
        found: dict[str, Any] = {"actions": self.run(move.action)}
        if move.targets:
            found["target"] = f"#{self.paths[move.targets[0]]}"
            if not move.internal:
                found["reenter"] = True
        if move.guard:
            name = f"guard{len(self.guards)}"
            self.guards[name] = lambda context, event: self.data.test(move.guard)
            found["guard"] = name
        return found

    def run(self, lines: list[str]) -> list[Any]:
        """The actions of a block; raising an event is an action of its own in this engine."""
        found: list[Any] = []
        for line in lines:
            if line.startswith(("Raise(", "Send(")):
                event, delay = eval(
                    line, {"Raise": lambda e: (e, None), "Send": lambda e, d: (e, d)}
                )
                found.append({"type": "xstate.raise", "params": {"event": event, "delay": delay}})
        plain = [line for line in lines if not line.startswith(("Raise(", "Send("))]
        if plain:
            name = f"action{len(self.actions)}"
            self.actions[name] = lambda *_: self.data.run(plain)
            found.insert(0, name)
        return found

    def nested(self, event: str, delay: float) -> None:
        raise CannotError("events are raised only by actions of their own")

    def is_active(self, name: str) -> bool:
        path = self.paths[name]
        return any(f"{active}.".startswith(f"{path}.") for active in self.ids_active())

    def ids_active(self) -> set[str]:
        return set(self.interpreter.current_state_ids)

    def say(self, event: str) -> None:
        self.interpreter.send(event)

    def wait(self, milliseconds: float) -> None:
        self.clock.increment(milliseconds)

    def active(self) -> list[str]:
        return [self.ids[path.split(".")[-1]] for path in self.ids_active() if path in self.leaves]


def python_statemachine(path: Path) -> str:
    """The verdict of python-statemachine, which reads SCXML and delays by the wall clock."""
    from statemachine.io.scxml.processor import SCXMLProcessor

    expected = json.loads(path.with_suffix(".json").read_text())
    text = path.read_text()
    for word, python in {**PYTHON, "&amp;&amp;": "and"}.items():
        text = text.replace(word, python)
    processor = SCXMLProcessor(trusted=True)
    processor.parse_scxml(path.stem, text)
    chart = processor.start()

    def active() -> list[str]:
        return [state.id for state in chart.configuration if not state.states]

    wrong = _difference(active(), "the start", expected["initialConfiguration"])
    for step in expected["events"]:
        time.sleep(step.get("after", 0) / 1000)
        chart.send(step["event"]["name"])
        wrong = wrong or _difference(active(), step["event"]["name"], step["nextConfiguration"])
    return wrong


def played(engine: Callable[[Case], Any]) -> Callable[[Path], str]:
    """The function that gives the verdict of an engine, by its adapter, on the case at a path."""

    def verdict(path: Path) -> str:
        case = read_case(path)
        try:
            running = engine(case)
        except CannotError:
            raise
        except Exception as error:
            raise CannotError(f"refused, {error}") from error
        running.start()
        wrong = _difference(running.active(), "the start", case.initial)
        for step in case.events:
            running.wait(step.get("after", 0))
            running.say(step["event"]["name"])
            after = step["event"]["name"]
            wrong = wrong or _difference(running.active(), after, step["nextConfiguration"])
        return wrong

    return verdict


def _exact(case: Case) -> None:
    if case.by_prefix:
        raise CannotError("events only by their whole names")


def _child(state: State) -> str:
    (initial, *more) = state.initial
    if more or initial not in [child.id for child in state.children]:
        raise CannotError("an initial state is a child")
    return initial


def _single(move: Move) -> None:
    if len(move.targets) > 1:
        raise CannotError("no several targets")


def _whole(move: Move) -> None:
    _single(move)
    if move.internal and move.targets:
        raise CannotError("no internal transition with a target")


def _flat(state: Any) -> list[str]:
    return [path for part in state for path in _flat(part)] if isinstance(state, list) else [state]


def _difference(active: list[str], after: str, expected: list[str]) -> str:
    found = sorted(active)
    return "" if found == sorted(expected) else f"after {after}: {found}, not {sorted(expected)}"


ENGINES: dict[str, Callable[[Path], str]] = {
    "python-statemachine": python_statemachine,
    "xstate-statemachine": played(XState),
    "transitions": played(Transitions),
    "sismic": played(Sismic),
}


def main() -> None:
    warnings.simplefilter("ignore")
    logging.disable()
    folder, cases = Path(sys.argv[1]), sys.stdin.read().split()
    found: dict[str, dict[str, str]] = {}
    for name, verdict in ENGINES.items():
        found[name] = {}
        for case in cases:
            try:
                found[name][case] = verdict(folder / "scion" / f"{case}.scxml")
            except CannotError as error:
                found[name][case] = f"cannot: {error}"
            except Exception as error:  # whatever a peer does is a result
                found[name][case] = f"{type(error).__name__}: {error}"
    print()  # ends the charts' own output
    print(json.dumps(found))


if __name__ == "__main__":
    main()
