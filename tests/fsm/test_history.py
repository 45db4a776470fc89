"""History states."""

from __future__ import annotations

import pytest

from tests.fsm.toy import Run

HISTORY = """
states:
  work:
    data: {{n: 0}}
    on: {{word.said: pause}}
    states:
      one: {{do: wait, on: {{done: two}}}}
      two:
        data: {{m: 0}}
        on: {{my.more: {{actions: [{{set: {{m: "${{m + 1}}", n: "${{n + 1}}"}}}}]}}}}
        states:
          x: {{do: wait, on: {{done: y}}}}
          y: {{do: wait, on: {{done: x}}}}
      back: {{type: history, target: one{deep}}}
  pause: {{on: {{my.back: work.back, my.anew: work, operator.abort: end}}}}
  end: {{type: final}}
events: {{my.more: {{}}, my.back: {{}}, my.anew: {{}}}}
"""

SCRIPT = {"work.one": ["done"], "work.two.x": ["done"]}


@pytest.mark.parametrize(
    ("deep", "state", "m", "progress"),
    [(", deep: true", "work.two.y", 1, {"steps": 3}), ("", "work.two.x", 1, None)],
)
def test_history_gives_back_states_data_and_progress(
    deep: str, state: str, m: int, progress: dict[str, int] | None
) -> None:
    run = Run(HISTORY.format(deep=deep), SCRIPT)
    run.run(3)
    run.post("my.more")
    run.run(2)
    run.post("word.said")
    assert run.run() == ["pause"]
    run.post("my.back")
    assert run.run() == [state]
    assert (run.value("n"), run.value("m")) == (1, m)
    assert run.activities[-1].resumed == progress


def test_without_history_everything_begins_anew() -> None:
    run = Run(HISTORY.format(deep=""), SCRIPT)
    run.run(3)
    run.post("my.more").post("word.said")
    run.run()
    run.post("my.anew")
    assert run.run() == ["work.one"]
    assert run.value("n") == 0
    assert run.activities[-1].resumed is None


def test_history_goes_to_its_target_the_first_time() -> None:
    run = Run(
        HISTORY.format(deep="").replace("states:\n  work", "initial: pause\nstates:\n  work", 1)
    )
    run.run()
    run.post("my.back")
    assert run.run() == ["work.one"]


def test_deep_history_restores_every_region() -> None:
    run = Run(
        """
states:
  work:
    on: {word.said: pause, operator.abort: end}
    states:
      both:
        type: parallel
        states:
          l: {states: {a: {on: {my.go: b}}, b: {on: {my.go: a}}}}
          r: {states: {a: {on: {my.go: b}}, b: {on: {my.go: a}}}}
      back: {type: history, deep: true, target: both}
  pause: {on: {my.back: work.back}}
  end: {type: final}
events: {my.go: {}, my.back: {}}
"""
    )
    run.run()
    run.post("my.go").post("word.said").post("my.back")
    assert run.run() == ["work.both.l.b", "work.both.r.b"]


def test_progress_that_was_given_back_is_gone_when_its_state_is_left_before_it_starts() -> None:
    run = Run(HISTORY.format(deep=""))
    run.run(3)
    run.post("word.said").run()
    run.post("my.back").post("word.said").post("my.anew")
    assert run.run() == ["work.one"]
    assert [activity.resumed for activity in run.activities] == [None, None]
    run.post("word.said").post("my.back").run()
    assert run.activities[-1].resumed == {"steps": 1}
