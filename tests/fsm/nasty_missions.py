"""Missions that are as nasty as a file may be, and what a process takes that checks one."""

from __future__ import annotations

import os
import sys
from pathlib import Path

LAND = "  land: {do: land, on: {done: finish}}\n  finish: {type: final}\n"
PARALLEL = "states:\n  p:\n    type: parallel\n    on: {operator.abort: land}\n    states:\n"


def regions(count: int, states: int, last: str = "land", history: bool = False) -> str:
    """Regions whose states follow each other by timers; the last one leads to ``last``."""
    text = ""
    for region in range(count):
        text += f"      r{region}:\n        states:\n"
        for state in range(states):
            after = f"s{state + 1}" if state + 1 < states else last
            text += f"          s{state}: {{after: {{5 s: {after}}}}}\n"
        text += "          h: {type: history, target: s0}\n" * history
    return text


def targets(count: int) -> str:
    return ", ".join(f"p.r{region}.h" for region in range(count))


def conditions(count: int, target: str) -> str:
    return ", ".join(f"vehicle.altitude > {n} m: {target.format(n)}" for n in range(count))


def included(states: str, count: int, around: str = "") -> str:
    """A graph of these states, included by many states."""
    text = f"graphs:\n  part:\n    states:\n{states}states:\n{around}"
    indent = "      " if around else "  "
    for number in range(count):
        text += f"{indent}i{number}: {{include: part, on: {{failed: land, battery.low: land}}}}\n"
    return text + LAND


STUCK = "".join(f"      s{n}: {{do: hover}}\n" for n in range(95))
LOOP = "".join(
    f"      s{n}: {{do: hover, on: {{operator.abort: s{(n + 1) % 95}}}, "
    f"after: {{5 s: s{(n + 1) % 95}}}}}\n"
    for n in range(95)
)
WITH_HISTORY = "".join(
    f"      s{n}:\n        on: {{operator.abort: s{(n + 1) % 20}.h, link.lost: s{n}.h}}\n"
    "        states: {a: {after: {5 s: b}}, b: {do: hover}, h: {type: history, target: a}}\n"
    for n in range(20)
)
AROUND = "  p:\n    type: parallel\n    states:\n"
NASTY = {
    "many regions": PARALLEL + regions(100, 8) + LAND,
    "two long regions": PARALLEL + regions(2, 350) + LAND,
    "a region for each state": PARALLEL + regions(700, 1) + LAND,
    "many histories": "states:\n  w:\n    on: {operator.abort: p}\n"
    f"    when: {{vehicle.altitude > 3 m: {{target: [{targets(40)}]}}}}\n"
    "  p:\n    type: parallel\n    on: {operator.takeover: w}\n    states:\n"
    + regions(40, 8, history=True)
    + LAND,
    "a deep history of regions": "states:\n  w: {on: {operator.abort: q.h}}\n  q:\n"
    "    on: {operator.takeover: w}\n    states:\n      h: {type: history, deep: true, target: p}\n"
    "      p:\n        type: parallel\n        states:\n"
    + regions(8, 8).replace("\n", "\n    ").rstrip(" ").replace("      r0", "          r0", 1)
    + LAND,
    "guards in every region": PARALLEL.replace("    on: {operator.abort: land}\n", "")
    + "".join(
        f"      r{n}: {{on: {{operator.abort: {{guard: vehicle.armed, target: land}}}}}}\n"
        for n in range(800)
    )
    + LAND,
    "conditions in every state": "states:\n"
    + "".join(f"  s{n}: {{do: hover, when: {{{conditions(60, 's{}')}}}}}\n" for n in range(60))
    + LAND,
    "conditions around all": f"when: {{{conditions(400, 's{}')}}}\nstates:\n"
    + "".join(f"  s{n}: {{do: hover, after: {{5 s: s{(n + 1) % 400}}}}}\n" for n in range(400))
    + LAND,
    "choices of choices": "states:\n"
    + "".join(
        f"  s{n}: {{always: [{{guard: vehicle.altitude > 1 m, target: s{(n + 1) % 500}}}, "
        f"{{guard: vehicle.altitude > 2 m, target: s{n * 7 % 500}}}], after: {{5 s: land}}}}\n"
        for n in range(500)
    )
    + LAND,
    "timers without end": "states:\n  a:\n    do: hover\n    on: {operator.abort: {}}\n    after: {"
    + "".join(f"{n + 1} s: {{}}, " for n in range(1500))
    + "5000 s: land}\n"
    + LAND,
    "events raised in a circle": PARALLEL
    + "".join(
        f"      r{n}: {{entry: {{raise: a.b{n}}}, on: {{a.b{(n + 1) % 500}: {{}}}}}}\n"
        for n in range(500)
    )
    + LAND,
    "events sent in a circle": "states:\n"
    + "".join(
        f"  s{n}: {{do: hover, entry: {{send: {{event: a.b{n}, delay: 3 s}}}}, "
        f"on: {{a.b{(n + 3) % 300}: s{(n + 1) % 300}, operator.abort: land}}, "
        f"after: {{5 s: s{(n + 1) % 300}}}}}\n"
        for n in range(300)
    )
    + LAND,
    "events without end": "events: {"
    + ", ".join(f"e.n{n}: {{}}" for n in range(1500))
    + "}\nstates:\n  s:\n    do: hover\n    after: {5 s: land}\n    on: {"
    + ", ".join(f"e.n{n}: land" for n in range(1500))
    + "}\n"
    + LAND,
    "regions that no one leaves": included(STUCK, 100, AROUND),
    "regions that go round": included(LOOP, 45, AROUND),
    "graphs with histories": included(WITH_HISTORY, 100),
    "defines of defines": "define: {"
    + ", ".join(f"d{n}: d{n + 1} + d{n + 1}" for n in range(24))
    + ", d24: 1}\nstates:\n  s: {do: hover, when: {d0 > 3: land}}\n"
    + LAND,
    "choices in every region": PARALLEL
    + "".join(
        f"      r{n}: {{states: {{a: {{always: {{guard: vehicle.armed, target: b}}}}, "
        "b: {always: {guard: vehicle.armed, target: land}}}}\n"
        for n in range(300)
    )
    + LAND,
    "graphs with many conditions": included(
        f"      s: {{do: hover, when: {{{conditions(1000, 't')}}}}}\n      t: {{do: hover}}\n", 400
    ),
    "graphs with long lists": included(
        f"      s: {{do: hover, data: {{a: [{'1, ' * 2000}]}}, after: {{5 s: s}}}}\n", 40
    ),
    "uses of a large define": f"define:\n  d: '{'time + ' * 90}time'\n"
    "states:\n  s:\n    do: hover\n    when:\n"
    + "".join(f"      d > {n}: land\n" for n in range(3000))
    + LAND,
    "a chain of defines": "define: {"
    + ", ".join(f"d{n}: d{n + 1} + 1" for n in range(2000))
    + ", d2000: 1}\nstates:\n  s: {do: hover, when: {d0 > 3: land}}\n"
    + LAND,
    "long expressions": "states:\n  s:\n    do: hover\n    when:\n"
    + "".join(f"      {'time + ' * 90}time > {n} s: land\n" for n in range(1000))
    + LAND,
    "names that no one knows": "data: {"
    + ", ".join(f"flight{n}: {n}" for n in range(2000))
    + "}\nstates:\n  s:\n    do: hover\n    when:\n"
    + "".join(f"      fligth{n} > 3: land\n" for n in range(1800))
    + LAND,
    "targets that no one knows": "states:\n"
    + "".join(f"  state{n}: {{do: hover, after: {{5 s: stade{n}}}}}\n" for n in range(1200))
    + LAND,
    "outcomes that no one has": "states:\n  p:\n    on: {"
    + ", ".join(f"o{n}: land" for n in range(1500))
    + "}\n    states:\n"
    + "".join(f"      o{n}: {{type: final, outcome: o{n}}}\n" for n in range(1000))
    + LAND,
}


_CHECK = """
import atexit, re, sys
from pathlib import Path
from cli.main import main

def keep(file):
    file.write_text(re.search(r"VmHWM:(.*)", Path("/proc/self/status").read_text())[1])

atexit.register(keep, Path(sys.argv.pop()))
main()
"""
"""Runs the command line, and writes down its peak memory: what wait4 tells of that is no less than
the memory of the process that spawned it."""


def check_usage(text: str, file: Path) -> tuple[float, float]:
    """CPU seconds and peak megabytes of `drone-cli check` of a mission, written to a file."""
    file.write_text(f"mission: m\n{text}")
    peak = file.with_suffix(".peak")
    command = [sys.executable, "-c", _CHECK, "check", str(file), str(peak)]
    # As for somebody who uses it twice: the first run keeps the byte code.
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    with Path(os.devnull).open("w") as nothing:
        actions = [(os.POSIX_SPAWN_DUP2, nothing.fileno(), fd) for fd in (1, 2)]
        process = os.posix_spawn(command[0], command, environment, file_actions=actions)
    _, _, used = os.wait4(process, 0)
    return used.ru_utime + used.ru_stime, int(peak.read_text().split()[0]) / 1024
