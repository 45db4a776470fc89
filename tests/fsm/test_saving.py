from __future__ import annotations

import json
import math
import random
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from fsm.chart.graph import Graph
from fsm.engine.saving import read_saved, restore, save, write_saved
from fsm.scxml import advance, load_document, parse_document
from fsm.values.packing import pack, unpack
from tests.fsm.toy import Run, graph_of
from vencejo.errors import UserError
from vencejo.geometry import Point

ROUND = """
mission: round
data: {n: 0, at: {type: point}, said: []}
events: {turn.back: {}, turn.late: {k: number}}
states:
  work:
    type: parallel
    on: {turn.back: pause}
    states:
      fly:
        states:
          out:
            do: go
            with: {to: {forward: 2 m}}
            on: {done: wait, blocked: wait, failed: wait}
            entry: {send: {event: turn.late, with: {k: 7}, delay: 200 ms, id: a}}
          wait: {after: {100 ms: out}}
          before: {type: history, target: out, deep: true}
      watch:
        do: look
        when: {"vehicle.battery < 0.5": {for: 75 ms, actions: {append: {said: low}}}}
        on: {turn.late: {actions: {set: {n: "${n + event.k}", at: $vehicle.position}}}}
        throughout: {log: "${1 / (n - 7)}"}
  pause: {after: {50 ms: work.fly.before}}
"""
SCRIPT = {
    "work.fly.out": [None, None, None, "done", None, None, None, "blocked"],
    "work.watch": [None, SimpleNamespace(visible=True, x=0.25, tags=[{"id": 3}])],
}


def through_json(saved: Any) -> Any:
    return json.loads(json.dumps(saved, allow_nan=False))


def resumed(run: Run) -> Run:
    """The same host with an instance that was saved and restored."""
    records = run.instance.records
    run.instance = restore(run.graph, run, through_json(save(run.instance)))
    run.instance.records = records
    return run


def play(graph: Graph, script: Any, events: list[list[str]], saves: set[int]) -> tuple[Any, ...]:
    """Periods with events; saved and restored after some of them. Everything to be seen of it."""
    run = Run("", script, graph=graph)
    trace = []
    for number, posted in enumerate(events):
        for event in posted:
            run.post(event)
        run.run(1, battery=0.4 if number % 16 > 6 else 0.9)
        trace.append(run.take())
        if number in saves:
            resumed(run)
    # What ended before the save does not exist any more after it, and needs no stop.
    worked = [line for line in run.log if line.startswith(("begin", "step"))]
    return trace, save(run.instance), worked


EVENTS = [["turn.back"] if number == 13 else [] for number in range(40)]


@pytest.mark.parametrize("saves", [{n} for n in range(40)] + [set(range(40))], ids=str)
def test_a_restored_run_goes_on_as_if_nothing_had_happened(saves: set[int]) -> None:
    graph = graph_of(ROUND)
    assert play(graph, SCRIPT, EVENTS, saves) == play(graph, SCRIPT, EVENTS, set())


def test_nothing_is_left_out_of_the_run_that_shows_it() -> None:
    """The test above is worth what it goes through: everything that is saved occurs in it."""
    run, seen = Run(ROUND, SCRIPT), set[str]()
    for number in range(40):
        if number == 13:
            run.post("turn.back")
        run.run(1, battery=0.4 if number % 16 > 6 else 0.9)
        saved = save(run.instance)
        seen |= {name for name, value in saved.items() if value}
    assert set(saved) - seen == {
        "outcome",
        "output",
        "urgent",
        "internal",
        "resumed",
        "suspended_at",
    }


# -- random graphs ------------------------------------------------------------------------------

NAMES = ["a", "b", "a.c", "a.d", "b.e", "b.f", "b.e.g", "b.e.h", "b.f.i", "b.f.j", "p"]


def transition(draw: Any, raises: str = "{raise: x.two}") -> str:
    target = draw(st.sampled_from([*NAMES, "a.was", "b.was", ""]))
    action = draw(
        st.sampled_from(
            [
                "{set: {n: '${n + 1}'}}",
                raises,
                "{send: {event: x.one, delay: 60 ms}}",
                "{log: '${1 / mod(n, 3)}'}",
                "{cancel: x.one}",
            ]
        )
    )
    to = f"target: {target}, reenter: true, " if target else ""
    return f"{{{to}actions: {action}}}"


def state(draw: Any, inner: str = "") -> str:
    parts = []
    if not inner:
        do = draw(st.booleans())
        parts += ["do: wait"] if do else []
        on = [f"done: {transition(draw)}"] if do else []
    else:
        parts.append(inner)
        on = []
    on += [
        f"{event}: {transition(draw, '{log: heard}')}"
        for event in ("x.one", "x.two")
        if draw(st.booleans())
    ]
    if on:
        parts.append(f"on: {{{', '.join(on)}}}")
    if draw(st.booleans()):
        parts.append(f"after: {{{draw(st.sampled_from([50, 75, 200]))} ms: {transition(draw)}}}")
    if draw(st.booleans()):
        condition = draw(st.sampled_from(["mod(n, 2) == 1", "n > 3", "vehicle.battery < 0.5"]))
        parts.append(f'when: {{"{condition}": {transition(draw)}}}')
    if draw(st.booleans()):
        parts.append(f"data: {{m{draw(st.integers(0, 10**9))}: 0}}")
    return f"{{{', '.join(parts)}}}"


@st.composite
def missions(draw: Any) -> str:
    """A compound, a parallel and a plain state with random insides, all with history."""
    deep = draw(st.sampled_from(["true", "false"]))

    def pair(one: str, two: str) -> str:
        return f"states: {{{one}: {state(draw)}, {two}: {state(draw)}}}"

    a_inner = f"{pair('c', 'd')[:-1]}, was: {{type: history, deep: {deep}, target: c}}}}"
    e, f = state(draw, pair("g", "h")), state(draw, pair("i", "j"))
    b_inner = (
        f"type: parallel, states: {{e: {e}, f: {f}, "
        f"was: {{type: history, deep: {deep}, target: e}}}}"
    )
    text = (
        "mission: random\ndata: {n: 0}\nevents: {x.one: {}, x.two: {}}\nstates:\n"
        f"  a: {state(draw, a_inner)}\n  b: {state(draw, b_inner)}\n  p: {state(draw)}\n"
    )
    try:
        graph_of(text)
    except UserError:
        assume(False)
    return text


@settings(
    max_examples=25,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
@given(
    text=missions(),
    events=st.lists(
        st.lists(st.sampled_from(["x.one", "x.two", "battery.low"]), max_size=2),
        min_size=5,
        max_size=25,
    ),
    at=st.integers(0, 24),
    script=st.lists(st.sampled_from([None, None, "done"]), max_size=9),
)
def test_random_graphs_go_on_as_if_nothing_had_happened(
    text: str, events: list[list[str]], at: int, script: list[Any]
) -> None:
    graph = graph_of(text)
    scripts = {node.path: script for node in graph.nodes}
    expected = play(graph, scripts, events, set())
    assert play(graph, scripts, events, {at}) == expected


# -- values -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Mark:
    at: Point
    names: tuple[str, ...] = ()


_scalars = (
    st.none()
    | st.booleans()
    | st.integers(-(10**30), 10**30)
    | st.floats(allow_nan=False)
    | st.text()
)
_points = st.builds(Point, *[st.floats(allow_nan=False)] * 3)
_values = st.recursive(
    _scalars | _points,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(inner, max_size=4).map(tuple)
        | st.dictionaries(st.text(), inner, max_size=4)
        | st.dictionaries(st.integers() | st.sampled_from(["$point", "$"]), inner, max_size=3)
        | st.builds(Mark, _points, st.just(("é", "\ud800")))
    ),
    max_leaves=12,
)


def same(one: Any, two: Any) -> bool:
    return repr(one) == repr(two) and type(one) is type(two)


@given(_values)
@settings(derandomize=True, deadline=None)
def test_values_come_back_exactly(value: Any) -> None:
    assert same(unpack(through_json(pack(value))), value)


@pytest.mark.parametrize("value", [-0.0, 5e-324, 0.1 + 0.2, math.inf, -math.inf, math.nan, {1, 2}])
def test_odd_values_come_back_too(value: Any) -> None:
    assert same(unpack(through_json(pack(value))), value)


def test_what_json_cannot_hold_is_refused_by_name() -> None:
    with pytest.raises(UserError, match="a range cannot be saved") as refused:
        pack([range(3)])
    assert refused.value.code == "unsavable"


@pytest.mark.parametrize(
    "packed",
    [
        {"$what": 1},
        {"$record": ["os", "path", {}]},
        {"$record": ["subprocess", "Popen", {}]},
        {"$record": ["nowhere", "Mark", {}]},
        {"$record": [__name__, "Mark", {"at": 1}]},
    ],
)
def test_nothing_else_is_made_of_a_file(packed: Any) -> None:
    with pytest.raises(ValueError, match=r"no kind of value|no record|other fields"):
        unpack(packed)


# -- what is refused ----------------------------------------------------------------------------


def saved_round() -> dict[str, Any]:
    run = Run(ROUND, SCRIPT)
    run.run(12)
    return save(run.instance)


def refusal(text: str, saved: Any) -> UserError:
    run = Run(text)
    with pytest.raises(UserError) as refused:
        restore(run.graph, run, saved)
    assert refused.value.faults[0].hint
    assert run.log == []
    return refused.value


def test_a_changed_mission_is_refused() -> None:
    error = refusal(ROUND.replace("100 ms", "101 ms"), saved_round())
    assert error.code == "other-mission"
    assert error.args == ("another text of 'round' was saved, not this 'round'",)


def test_another_mission_is_refused_by_name() -> None:
    error = refusal(
        "mission: other\nstates: {a: {after: {1 s: b}}, b: {type: final}}", saved_round()
    )
    assert error.args == ("'round' was saved, not this 'other'",)


@pytest.mark.parametrize(
    ("version", "by"),
    [(1, "an earlier version"), (99, "another version"), (None, "another version")],
)
def test_another_form_is_refused(version: Any, by: str) -> None:
    error = refusal(ROUND, {**saved_round(), "version": version})
    assert error.code == "other-version"
    assert error.args == (
        f"the mission was saved by {by} of vencejo, in form {version}; this one reads form 2",
    )
    assert error.faults[0].hint == (
        "go on with the version that saved it, or start the mission anew"
    )


def test_what_is_no_save_is_refused() -> None:
    assert refusal(ROUND, {"format": "x"}).code == "not-a-save"


@pytest.mark.parametrize(
    "missing", sorted({*saved_round()} - {"format", "version", "digest", "mission"})
)
def test_a_save_with_a_part_missing_is_refused(missing: str) -> None:
    saved = saved_round()
    del saved[missing]
    assert refusal(ROUND, saved).code == "torn-save"


def test_a_save_nested_beyond_measure_is_refused(tmp_path: Path) -> None:
    text = json.dumps({**saved_round(), "output": 0}).replace(
        '"output": 0', f'"output": {"[" * 900}{"]" * 900}'
    )
    (tmp_path / "deep.json").write_text(text)
    with pytest.raises(UserError) as caught:
        restore(graph_of(ROUND), Run(ROUND, SCRIPT), read_saved(tmp_path / "deep.json"))
    assert caught.value.code == "torn-save"


def document(guard: str, gap: str = "") -> Graph:
    text = (
        f'<scxml xmlns="http://www.w3.org/2005/07/scxml">{gap}<state id="a">'
        f'<onentry><send event="e" delay="1s"/></onentry>{gap}'
        f'<transition event="e" cond="{guard}" target="b"/></state><state id="b"/></scxml>'
    )
    return load_document(parse_document(text, "d.scxml"), "d")


def test_a_document_goes_on_with_what_was_saved_from_it_and_from_no_other() -> None:
    run = Run("", graph=document("1 &lt; 2"))
    advance(run.instance, 0.5)
    saved = through_json(save(run.instance))
    restored = restore(document("1 &lt; 2", gap="\n  <!-- the same -->\n"), run, saved)
    advance(restored, 1.5)
    assert restored.paths() == ["b"]
    with pytest.raises(UserError) as caught:
        restore(document("1 &lt; 3"), run, saved)
    assert caught.value.code == "other-mission"


def test_comments_and_layout_make_no_other_mission() -> None:
    commented = "# a comment\n\n" + ROUND.replace("mission: round", "mission:   round   # so")
    assert graph_of(commented).digest == graph_of(ROUND).digest
    assert graph_of(ROUND.replace("k: 7", "k: 8")).digest != graph_of(ROUND).digest
    assert graph_of(ROUND.replace("k: 7", "k: '7'")).digest != graph_of(ROUND).digest


# -- files --------------------------------------------------------------------------------------


def test_a_file_comes_back_and_leaves_nothing_else(tmp_path: Path) -> None:
    saved = saved_round()
    for _ in range(2):
        write_saved(tmp_path / "run.saved", saved)
    assert read_saved(tmp_path / "run.saved") == saved
    assert [path.name for path in tmp_path.iterdir()] == ["run.saved"]


def test_a_torn_file_is_refused_wherever_it_was_cut(tmp_path: Path) -> None:
    path = tmp_path / "run.saved"
    write_saved(path, saved_round())
    whole = path.read_bytes()
    for length in range(0, len(whole) - 2, 97):
        path.write_bytes(whole[:length])
        with pytest.raises(UserError) as refused:
            read_saved(path)
        assert (refused.value.code, refused.value.faults[0].where.file) == ("torn-save", str(path))  # type: ignore[union-attr]


def test_a_file_that_is_not_there_and_a_place_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(UserError) as missing:
        read_saved(tmp_path / "no")
    with pytest.raises(UserError) as unwritable:
        write_saved(tmp_path / "no" / "run.saved", saved_round())
    assert (missing.value.code, unwritable.value.code) == ("no-such-file", "cannot-save")


WRITER = """
import sys
from pathlib import Path
from fsm.engine.saving import save, write_saved
from tests.fsm.test_saving import ROUND, SCRIPT
from tests.fsm.toy import Run
run = Run(ROUND, SCRIPT)
while True:
    run.run(1)
    run.instance.records.clear()
    write_saved(Path(sys.argv[1]), save(run.instance))
    print(run.instance.now, flush=True)
"""


@pytest.mark.slow
def test_a_killed_process_leaves_the_last_whole_save(tmp_path: Path) -> None:
    """One hundred processes, each killed at a random moment."""
    graph, draw = graph_of(ROUND), random.Random(7)
    for number in range(100):
        path = tmp_path / f"{number}.saved"
        with subprocess.Popen(
            [sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            said = [process.stdout.readline() for _ in range(draw.randrange(1, 30))]
            for _ in range(draw.randrange(20_000)):
                pass
            process.send_signal(signal.SIGKILL)
            said += process.stdout.read().split()
        host = Run("", SCRIPT, graph=graph)
        instance = restore(graph, host, read_saved(path))
        assert instance.now >= float(said[-1])
        instance.period(instance.now + 0.025, (host.vehicle,))


def test_a_suspended_run_is_still_suspended_and_sends_to_others_are_kept() -> None:
    mission = """
states:
  a:
    entry: {send: {event: game.over, to: cat, delay: 1 s}}
    do: wait
    on: {done: end}
    after: {10 s: end}
  end: {type: final}
"""
    run = Run(mission)
    run.run(5)
    run.instance.suspend()
    restored = restore(run.graph, run, save(run.instance))
    assert restored.suspended_at == run.instance.suspended_at is not None
    assert [(sent.due, sent.to) for sent in restored.state.delayed] == [
        (sent.due, sent.to) for sent in run.instance.state.delayed
    ]
    assert restored.state.delayed[0].to == "cat"


def test_a_restored_run_knows_its_active_states() -> None:
    mission = """
states:
  both:
    type: parallel
    on: {operator.abort: end}
    states:
      l: {states: {a: {on: {word.said: b}}, b: {on: {link.lost: a}}}}
      r: {throughout: {log: "${active('both.l.b')}"}}
  end: {type: final}
"""
    run = Run(mission)
    run.run()
    run.post("word.said").run()
    resumed(run).run()
    assert run.logged() == ["false", "true", "true"]


def test_only_what_is_active_is_kept_of_states() -> None:
    run = Run(ROUND, SCRIPT)
    for number in range(40):
        run.run(1, battery=0.4 if number % 16 > 6 else 0.9)
        if number in (13, 25):
            run.post("turn.back")
        saved = save(run.instance)
        for name in ("conditions", "timers", "running", "resumed"):
            assert set(saved[name]) <= set(saved["configuration"])
        assert set(saved["finished"]) <= set(saved["configuration"])
