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
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bench.latency_peers import microseconds
from bench.machine import machine
from bench.no_host import NoHost
from fsm import Graph, Instance, Vocabulary, compile_mission, read_mission

CHART = Path(__file__).parent / "bench_chart.yaml"
PEERS = ("transitions", "sismic", "python-statemachine", "xstate-statemachine", "py_trees")
GOAL = 12.0


def started(graph: Graph, host_values: Sequence[Any] = ()) -> Instance:
    instance = Instance(graph, NoHost())
    instance.period(0.0, host_values)
    return instance


def ours() -> list[float]:
    """Latency of a local, a crossing and an internal event, microseconds."""
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
    if "--json" in sys.argv:
        print(json.dumps({"machine": machine(), "goal_us": GOAL, "latency_us": rows}))
        return
    print(f"latency per event, hooks and trace on, CPU µs (goal ≤ {GOAL:g}); {machine()}")
    print(f"  {'':22}{'local':>8}{'crossing':>10}{'internal':>10}")
    for name, (near, crossing, internal) in rows.items():
        print(f"  {name:22}{near:8.1f}{crossing:10.1f}{internal:10.1f}")


if __name__ == "__main__":
    main()
