"""Random charts run as appendix D of the W3C's SCXML says, action by action (see appendix_d)."""

from __future__ import annotations

from collections import Counter

import pytest

from fsm.chart.selection import select
from fsm.engine import interpreter
from tests.fsm.appendix_d.comparison import difference, trace_of_appendix_d
from tests.fsm.appendix_d.random_charts import random_chart
from tests.fsm.appendix_d.report import report

LANGUAGES = pytest.mark.parametrize("mission", [False, True], ids=["documents", "missions"])


@LANGUAGES
def test_random_charts_run_as_appendix_d_says(mission: bool) -> None:
    for seed in range(25):
        assert report(seed, mission) == ""


@pytest.mark.slow
@LANGUAGES
@pytest.mark.parametrize("first", range(1000, 2000, 250))
def test_a_thousand_random_charts_run_as_appendix_d_says(first: int, mission: bool) -> None:
    for seed in range(first, first + 250):
        assert report(seed, mission) == ""


@LANGUAGES
def test_everything_that_is_compared_occurs(mission: bool) -> None:
    seen: Counter[str] = Counter()
    for seed in range(60):
        root, events = random_chart(seed, mission)
        for state in root.walk():
            seen[state.kind] += 1
            seen["several by default"] += bool(state.default and state.default.targets[1:])
            for transition in state.transitions:
                seen["internal"] += transition.internal and bool(transition.targets)
                seen["several"] += len(transition.targets) > 1
                seen["to history"] += any(target.is_history for target in transition.targets)
        steps = trace_of_appendix_d(root, events, mission)
        seen["not endless"] += len(steps) > len(events)
        for line in (line for step in steps for line in step):
            seen[line.split()[0]] += 1
            seen["always"] += line.endswith("by always")
            seen["done"] += "by done.state" in line
            seen["default content"] += line.startswith("log default")
            seen["unheard"] += line.endswith("unheard")
    only_documents = {"several by default", "default content"}
    assert {word for word, count in seen.items() if not count} == (
        only_documents if mission else set()
    )


def one_transition_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Break the engine: of what regions take together only the first is taken."""
    monkeypatch.setattr(interpreter, "select", lambda *arguments: select(*arguments)[:1])


@LANGUAGES
def test_what_differs_is_found(mission: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    one_transition_at_a_time(monkeypatch)
    assert any(difference(*random_chart(seed, mission), mission) for seed in range(100))


def test_what_differs_is_shown_shrunk_and_with_its_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    one_transition_at_a_time(monkeypatch)
    seed, found = next((seed, text) for seed in range(100) if (text := report(seed, False)))
    assert found.startswith(f"seed {seed}, shrunk; events ")
    assert len(found.splitlines()) < 60
    assert "\n  appendix D: " in found
    assert "\n  engine: " in found
