"""Latency of one event on `bench_chart.yaml`, hooks and trace on, beside other engines.

    python -m bench.latency [--json] [--alone]

CPU time, the median of batches. Local: a sibling leaf; crossing: three levels up and down with a
guard; internal: handled at the top without leaving anything. Ours carries one no-op callback on
every entered and left state and records a full trace. The other engines are installed into an
environment that is thrown away; `--alone` leaves them out.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

from bench.latency_peers import microseconds
from bench.machine import machine
from fsm import Graph, Instance, Vocabulary, compile_mission, read_mission, read_mission_text

CHART = Path(__file__).parent / "bench_chart.yaml"
PEERS = ("transitions", "sismic", "python-statemachine", "xstate-statemachine", "py_trees")
GOAL = 12.0


class NoHost:
    """The charts here fly nothing."""

    def begin(self, *args: Any) -> Any:
        raise AssertionError

    def call(self, *args: Any) -> None:
        raise AssertionError


def started(graph: Graph) -> Instance:
    instance = Instance(graph, NoHost())
    instance.period(0.0)
    return instance


def ours() -> list[float]:
    """Local, crossing and internal event, microseconds."""
    graph = compile_mission(read_mission(CHART), Vocabulary())
    for node in graph.nodes:
        node.add_callback("enter", lambda data: None)
        node.add_callback("exit", lambda data: None)
    instance = started(graph)

    def fire(event: str) -> None:
        instance.trigger(event)
        if len(instance.records) > 1000:
            instance.records.clear()

    return [
        microseconds(lambda event=event: fire(event))  # type: ignore[misc]
        for event in ("leaf.next", "side.next", "count.up")
    ]


def wide(states: int) -> float:
    """A local event among that many states."""
    # The root's own transition leaves every state: that takes the fewest of a file's 10,000 values.
    text = "events: {leaf.next: {}, side.next: {}}\non: {side.next: a}\nstates:\n"
    text += "  a: {on: {leaf.next: b}}\n  b: {on: {leaf.next: a}}\n"
    return local(text + "".join(f"  s{n}:\n" for n in range(states - 2)))


def deep(levels: int) -> float:
    """A local event at that depth."""
    lines = ["events: {leaf.next: {}}"]
    for level in range(levels):
        pad = "    " * level
        lines += [f"{pad}states:", f"{pad}  d{level}:" if level < levels - 1 else ""]
    pad = "    " * (levels - 1) + "  "
    lines += [f"{pad}a: {{on: {{leaf.next: b}}}}", f"{pad}b: {{on: {{leaf.next: a}}}}"]
    return local("\n".join(line for line in lines if line) + "\n")


def local(text: str) -> float:
    instance = started(compile_mission(read_mission_text(text), Vocabulary()))
    return microseconds(lambda: (instance.trigger("leaf.next"), instance.records.clear()))


def compiling(states: int) -> tuple[float, float]:
    """Milliseconds to compile a spec of that many states, and from file to graph."""
    groups = "".join(
        f"  g{n}:\n    on: {{side.next: g{(n + 1) % (states // 5)}}}\n    states:\n"
        + "".join(f"      s{k}: {{on: {{leaf.next: s{(k + 1) % 4}}}}}\n" for k in range(4))
        for n in range(states // 5)
    )
    text = "events: {leaf.next: {}, side.next: {}}\nstates:\n" + groups
    compiled, whole = [], []
    for _ in range(7):
        began = process_time()
        spec = read_mission_text(text)
        read = process_time()
        compile_mission(spec, Vocabulary())
        compiled.append(process_time() - read)
        whole.append(process_time() - began)
    return 1e3 * median(compiled), 1e3 * median(whole)


def peers() -> dict[str, list[float]]:
    with TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        python = Path(folder) / "bin" / "python"
        subprocess.run([python, "-m", "pip", "install", "-q", *PEERS], check=True)
        script = Path(__file__).parent / "latency_peers.py"
        done = subprocess.run([python, script], check=True, capture_output=True, text=True)
        found: dict[str, list[float]] = json.loads(done.stdout.splitlines()[-1])
        return found


def main() -> None:
    rows = {"vencejo": ours(), **({} if "--alone" in sys.argv else peers())}
    widths = {states: wide(states) for states in (10, 100, 1000, 4900)}
    depths = {levels: deep(levels) for levels in (1, 10, 30)}
    compiles = {states: compiling(states) for states in (100, 1000)}
    if "--json" in sys.argv:
        facts = {"machine": machine(), "goal_us": GOAL, "latency_us": rows}
        print(json.dumps({**facts, "wide_us": widths, "deep_us": depths, "compile_ms": compiles}))
        return
    print(f"latency per event, hooks and trace on, CPU µs (goal ≤ {GOAL:g}); {machine()}")
    print(f"  {'':22}{'local':>8}{'crossing':>10}{'internal':>10}")
    for name, (near, crossing, internal) in rows.items():
        print(f"  {name:22}{near:8.1f}{crossing:10.1f}{internal:10.1f}")
    print("  local event, no hooks: " + ", ".join(f"{n} states {t:.1f}" for n, t in widths.items()))
    print("                         " + ", ".join(f"depth {n} {t:.1f}" for n, t in depths.items()))
    for states, (compiled, whole) in compiles.items():
        print(f"  {states} states: compile {compiled:.1f} ms, file to graph {whole:.1f} ms")


if __name__ == "__main__":
    main()
