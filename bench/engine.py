"""CPU time and memory of the statechart engine, by the size of the mission.

    python -m bench.engine [--json]

CPU time, the median of batches. An idle period is one of 25 ms in which nothing happens: 20 states,
10 conditions of active states, all of them false. Memory is that of one more started instance of a
graph, the mean of 1,000. A crossing event leaves a tower of states and enters another. Compiling
includes all checks of the structure; plain states have one transition each, busy ones three and
four expressions.
"""

from __future__ import annotations

import gc
import json
import sys
import tracemalloc
from collections.abc import Callable
from statistics import correlation, linear_regression, median
from time import process_time
from types import SimpleNamespace
from typing import Any

from bench.latency import CHART, started
from bench.latency_peers import microseconds
from bench.machine import machine
from fsm import Graph, Vocabulary, compile_mission, read_mission, read_mission_text
from fsm.values.types import MapOf, Number
from vencejo.units import LENGTH, RATIO

Fire = Callable[[], Any]
HOST = Vocabulary(
    names={"vehicle": MapOf({"altitude": Number(LENGTH), "battery": Number(RATIO)})},
    events={"leaf.next": {}, "side.next": {}},
)
VEHICLE = SimpleNamespace(altitude=4.0, battery=0.9)
IDLE = """
parameters: {floor: 30 %, ceiling: 100 m}
data: {seen: 0}
when: {vehicle.battery < floor: home, vehicle.altitude > ceiling: home, seen > 99: home}
states:
  patrol:
    when:
      vehicle.altitude < 0.5 m: home
      seen > 50 and vehicle.battery < 50 %: home
      time_in_state > 1000 h: home
    states:
      leg:
        when:
          vehicle.altitude > 3 m and seen > 10: next
          abs(vehicle.altitude - 4 m) > 2 m: next
          max(vehicle.altitude, 2 m) > 9 m: {for: 2 s, target: next}
          seen > 5: next
      next: {on: {leaf.next: leg}}
  home: {on: {leaf.next: s0}}
"""


def compiled(text: str, vocabulary: Vocabulary = HOST) -> Graph:
    return compile_mission(read_mission_text(text), vocabulary)


def idle_mission() -> Graph:
    """A mission of twenty states, root included; ten conditions are active in the first leaf."""
    targets = [f"s{n}" for n in range(1, 15)] + ["patrol"]
    rest = (f"  s{n}: {{on: {{leaf.next: {target}}}}}\n" for n, target in enumerate(targets))
    return compiled(IDLE + "".join(rest))


def period() -> float:
    """CPU time of an idle period, microseconds."""
    instance, now = started(idle_mission(), (VEHICLE,)), 0.0

    def wait() -> None:
        nonlocal now
        now += 0.025
        instance.period(now, (VEHICLE,))

    cost = microseconds(wait)
    assert {kind for kind, _ in instance.records} == {"enter"}, "something happened"
    return cost


def memory(graph: Graph, host_values: tuple[Any, ...] = (), instances: int = 1000) -> float:
    """Memory of one more instance, bytes: the mean of some."""
    started(graph, host_values)  # what all instances share is made by the first
    gc.collect()
    tracemalloc.start()
    kept = [started(graph, host_values) for _ in range(instances)]
    for instance in kept:
        instance.records.clear()
    gc.collect()
    taken, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return taken / instances


def side_by_side(missions: dict[int, str], event: str) -> dict[int, float]:
    """CPU time of an event by size, µs; measured in turns, since the machine's speed varies."""
    fires: dict[int, Fire] = {size: fire(text, event) for size, text in missions.items()}
    times: dict[int, list[float]] = {size: [] for size in missions}
    for _ in range(12):
        for size, repeated in fires.items():
            times[size].append(microseconds(repeated, batches=5))
    return {size: median(found) for size, found in times.items()}


def fire(text: str, event: str) -> Fire:
    instance = started(compiled(text))
    return lambda: (instance.trigger(event), instance.records.clear())


def wide(states: int) -> str:
    """A mission of ``states`` states, for a local event."""
    # The root's own transition leaves every state: that takes the fewest of a file's 10,000 values,
    # which is why there are not quite 5,000.
    text = "on: {side.next: a}\nstates:\n"
    text += "  a: {on: {leaf.next: b}}\n  b: {on: {leaf.next: a}}\n"
    return text + "".join(f"  s{n}:\n" for n in range(states - 2))


def tower(name: str, levels: int, leaf: str, indent: int = 1) -> str:
    """Nested states, ``levels`` deep; ``leaf`` is the innermost one's contents."""
    if levels == 1:
        return f"{' ' * indent}{name}: {leaf}\n"
    inner = tower(name, levels - 1, leaf, indent + 2)
    return f"{' ' * indent}{name}:\n{' ' * (indent + 1)}states:\n{inner}"


def deep(levels: int) -> str:
    """A mission of ``levels`` nested states, for a local event."""
    pair = "a: {on: {leaf.next: b}}, b: {on: {leaf.next: a}}"
    if levels == 1:
        return f"states: {{{pair}}}"
    return "states:\n" + tower("d", levels - 1, f"{{states: {{{pair}}}}}")


def crossing(levels: int) -> str:
    """A mission in which an event leaves and enters ``levels`` nested states."""
    sides = (("a", "b"), ("b", "a"))
    towers = (tower(name, levels, f"{{on: {{side.next: {other}}}}}") for name, other in sides)
    return "states:\n" + "".join(towers)


def chain_of_groups(states: int) -> str:
    """A mission of ``states`` states with one transition each, in groups of five."""
    text = "states:\n"
    for n in range(states // 5):
        text += f"  g{n}:\n    on: {{side.next: g{(n + 1) % (states // 5)}}}\n    states:\n"
        text += "".join(f"      s{k}: {{on: {{leaf.next: s{(k + 1) % 4}}}}}\n" for k in range(4))
    return text


def busy_states(states: int) -> str:
    """A mission of ``states`` states with four expressions and three transitions each."""
    text = "data: {n: 0}\nstates:\n"
    for k in range(states):
        near, far = (k + 1) % states, (k + 2) % states
        text += f"  s{k}:\n    after: {{{k + 1} s: s{near}}}\n"
        text += f"    when: {{vehicle.altitude > {k} m and n < {k}: s{near}}}\n"
        text += f"    on: {{leaf.next: {{target: s{far}, guard: n >= {k}, "
        text += f"actions: {{set: {{n: '${{n + {k}}}'}}}}}}}}\n"
    return text


def milliseconds(work: Callable[[], Any], times: int = 9) -> float:
    """CPU time of some work, milliseconds: the median of several times."""
    found = []
    for _ in range(times):
        began = process_time()
        work()
        found.append(1e3 * (process_time() - began))
    return median(found)


def measure() -> dict[str, Any]:
    levels = [1, 2, 5, 10, 15, 20, 25, 30]
    crossings = side_by_side({count: crossing(count) for count in levels}, "side.next")
    slope, start = linear_regression(levels, list(crossings.values()))
    texts = {
        "100 plain": chain_of_groups(100),
        "100 busy": busy_states(100),
        "1000 plain": chain_of_groups(1000),
    }
    compiles, files = {}, {}
    for name, text in texts.items():
        spec = read_mission_text(text)
        compiles[name] = milliseconds(lambda spec=spec: compile_mission(spec, HOST))  # type: ignore[misc]
        files[name] = milliseconds(lambda text=text: compiled(text))  # type: ignore[misc]
    return {
        "machine": machine(),
        "idle_period_us": period(),
        "instance_bytes": {
            "bench_chart": memory(compile_mission(read_mission(CHART), Vocabulary())),
            "idle mission": memory(idle_mission(), (VEHICLE,)),
        },
        "wide_us": side_by_side({n: wide(n) for n in (10, 100, 1000, 4990)}, "leaf.next"),
        "deep_us": side_by_side({n: deep(n) for n in (1, 10, 20, 30)}, "leaf.next"),
        "crossing_us": crossings,
        "crossing_fit": {
            "us": start,
            "us_per_level": slope,
            "correlation": correlation(levels, list(crossings.values())),
        },
        "compile_ms": compiles,
        "file_to_graph_ms": files,
    }


def main() -> None:
    found = measure()
    if "--json" in sys.argv:
        print(json.dumps(found))
        return

    def row(what: str, values: dict[Any, float], goal: str = "", digits: int = 1) -> None:
        shown = ", ".join(f"{key}: {value:,.{digits}f}" for key, value in values.items())
        print(f"  {what:32}{shown}{f'  (goal {goal})' if goal else ''}")

    def growth(values: dict[int, float]) -> float:
        return max(values.values()) / next(iter(values.values()))

    fit = found["crossing_fit"]
    print(f"the statechart engine, CPU time; {found['machine']}")
    row("idle period, µs", {"20 states, 10 conditions": found["idle_period_us"]}, "≤ 30")
    row("memory per instance, bytes", found["instance_bytes"], digits=0)
    row("local event by states, µs", found["wide_us"], "≤ 1.3 ×")
    print(f"  {'':32}grows {growth(found['wide_us']):.2f} ×")
    row("local event by depth, µs", found["deep_us"], "≤ 1.5 ×")
    print(f"  {'':32}grows {growth(found['deep_us']):.2f} ×")
    row("crossing event by levels, µs", found["crossing_us"], "linear")
    print(
        f"  {'':32}{fit['us']:.1f} + {fit['us_per_level']:.2f} per level, "
        f"correlation {fit['correlation']:.4f}"
    )
    row("compile by states, ms", found["compile_ms"], "≤ 1 per 100")
    row("file to graph by states, ms", found["file_to_graph_ms"], "≤ 50, ≤ 600")


if __name__ == "__main__":
    main()
