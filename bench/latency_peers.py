"""The latency chart in other engines; run by bench.latency with a Python that has them.

Every engine carries one no-op callback on each entered and left state and the same guard, as the
chart's comment asks; none records a trace. Prints JSON: engine → microseconds for each event.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from statistics import median
from time import process_time
from typing import Any

BATCHES, EVENTS = 40, 100
Fires = list[Callable[[], Any]]


def microseconds(fire: Callable[[], Any], batches: int = BATCHES) -> float:
    """CPU time of one event, microseconds: the median of batches."""
    times = []
    for _ in range(batches):
        began = process_time()
        for _ in range(EVENTS):
            fire()
        times.append((process_time() - began) / EVENTS * 1e6)
    return median(times)


def noop(*args: Any, **kwargs: Any) -> None:
    """Do nothing, in place of a user's callback."""


def transitions() -> Fires:
    from transitions.extensions import HierarchicalMachine
    from transitions.extensions.nesting import NestedState

    NestedState.separator = "."

    def state(name: str, **inside: Any) -> dict[str, Any]:
        return {"name": name, "on_enter": [noop], "on_exit": [noop], **inside}

    def side(name: str) -> dict[str, Any]:
        groups = [state(g, initial="x", children=[state("x"), state("y")]) for g in "pq"]
        return state(name, initial="p", children=groups)

    class Model:
        n = 0

    model = Model()

    def up() -> None:
        model.n += 1

    machine = HierarchicalMachine(
        model, states=[side("a"), side("b")], initial="a", auto_transitions=False
    )
    for here, there in (("a", "b"), ("b", "a")):
        for group in "pq":
            for leaf, other in (("x", "y"), ("y", "x")):
                machine.add_transition(
                    "leaf_next", f"{here}.{group}.{leaf}", f"{here}.{group}.{other}"
                )
        machine.add_transition("side_next", here, there, conditions=[lambda: model.n >= 0])
        machine.add_transition("count_up", here, None, after=[up])
    return [
        lambda e=event: model.trigger(e)  # type: ignore[attr-defined,misc]
        for event in ("leaf_next", "side_next", "count_up")
    ]


def sismic() -> Fires:
    from sismic.interpreter import Interpreter
    from sismic.io import import_from_yaml

    def state(name: str, pad: str, more: str) -> str:
        hooks = f"{pad}  on entry: noop()\n{pad}  on exit: noop()\n"
        return f"{pad}- name: {name}\n{hooks}{more}"

    text = "statechart:\n  name: c\n  preamble: |\n    n = 0\n    def noop(): pass\n"
    text += "  root state:\n    name: root\n    initial: a\n    states:\n"
    for here, there in (("a", "b"), ("b", "a")):
        groups = ""
        for group in "pq":
            leaves = ""
            for leaf, other in (("x", "y"), ("y", "x")):
                pad = " " * 16
                to = f"{{target: {here}{group}{other}, event: leaf_next}}"
                leaves += state(f"{here}{group}{leaf}", " " * 14, f"{pad}transitions: [{to}]\n")
            pad = " " * 12
            more = f"{pad}initial: {here}{group}x\n{pad}states:\n{leaves}"
            groups += state(here + group, " " * 10, more)
        pad = " " * 8
        moves = (
            f"{pad}transitions:\n{pad}- {{target: {there}, event: side_next, guard: n >= 0}}\n"
            f"{pad}- {{event: count_up, action: n += 1}}\n"
        )
        text += state(here, " " * 6, f"{pad}initial: {here}p\n{moves}{pad}states:\n{groups}")
    interpreter = Interpreter(import_from_yaml(text))
    interpreter.execute()

    def fire(event: str) -> None:
        interpreter.queue(event)
        interpreter.execute()

    return [lambda e=e: fire(e) for e in ("leaf_next", "side_next", "count_up")]  # type: ignore[misc]


def python_statemachine() -> Fires:
    from statemachine import State, StateChart

    class Chart(StateChart):
        n = 0

        class a(State.Compound):  # noqa: N801
            class ap(State.Compound):  # noqa: N801
                apx, apy = State(initial=True), State()
                leaf_next = apx.to(apy) | apy.to(apx)

            class aq(State.Compound):  # noqa: N801
                aqx, aqy = State(initial=True), State()
                leaf_next = aqx.to(aqy) | aqy.to(aqx)

            over = ap.to(aq)  # that engine refuses states that nothing leads to

        class b(State.Compound):  # noqa: N801
            class bp(State.Compound):  # noqa: N801
                bpx, bpy = State(initial=True), State()
                leaf_next = bpx.to(bpy) | bpy.to(bpx)

            class bq(State.Compound):  # noqa: N801
                bqx, bqy = State(initial=True), State()
                leaf_next = bqx.to(bqy) | bqy.to(bqx)

            over = bp.to(bq)

        side_next = a.to(b, cond="ok") | b.to(a, cond="ok")
        count_up = a.to.itself(internal=True, on="up") | b.to.itself(internal=True, on="up")

        def ok(self) -> bool:
            return self.n >= 0

        def up(self) -> None:
            self.n += 1

        def on_enter_state(self) -> None: ...

        def on_exit_state(self) -> None: ...

    chart = Chart()
    return [lambda e=e: chart.send(e) for e in ("leaf_next", "side_next", "count_up")]  # type: ignore[misc]


def xstate_statemachine() -> Fires:
    from xstate_statemachine import MachineLogic, SyncInterpreter, create_machine

    def state(**more: Any) -> dict[str, Any]:
        return {"entry": "noop", "exit": "noop", **more}

    def leaves() -> dict[str, Any]:
        return {
            "x": state(on={"leaf.next": "y"}),
            "y": state(on={"leaf.next": "x"}),
        }

    def side(other: str) -> dict[str, Any]:
        on = {"side.next": {"target": other, "guard": "ok"}, "count.up": {"actions": ["up"]}}
        groups = {group: state(initial="x", states=leaves()) for group in "pq"}
        return state(initial="p", on=on, states=groups)

    def up(interpreter: Any, context: dict[str, int], event: Any, action: Any) -> None:
        context["n"] += 1

    config = {
        "id": "c",
        "initial": "a",
        "context": {"n": 0},
        "states": {"a": side("b"), "b": side("a")},
    }
    logic = MachineLogic(
        actions={"noop": noop, "up": up}, guards={"ok": lambda context, event: context["n"] >= 0}
    )
    interpreter = SyncInterpreter(create_machine(config, logic=logic))
    interpreter.start()
    return [lambda e=e: interpreter.send(e) for e in ("leaf.next", "side.next", "count.up")]  # type: ignore[misc]


def py_trees() -> Fires:
    """The engine has no events: one tick of a tree of nine nodes stands for each."""
    import py_trees

    root = py_trees.composites.Sequence("root", memory=False)
    for side in "ab":
        branch = py_trees.composites.Sequence(side, memory=False)
        branch.add_children([py_trees.behaviours.Success(f"{side}{k}") for k in range(3)])
        root.add_child(branch)
    tree = py_trees.trees.BehaviourTree(root)
    return [tree.tick] * 3


if __name__ == "__main__":
    engines = (transitions, sismic, python_statemachine, xstate_statemachine, py_trees)
    print(json.dumps({e.__name__: [microseconds(f) for f in e()] for e in engines}))
    sys.exit(0)
