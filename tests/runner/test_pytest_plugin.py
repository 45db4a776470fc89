from __future__ import annotations

import re
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

DOCUMENT = Path(__file__).parents[2] / "docs" / "testing.md"
# Where the distribution is installed with its entry point, pytest knows the plugin by that name.
PLUGIN = "vencejo" if entry_points(group="pytest11", name="vencejo") else "runner.pytest_plugin"


@pytest.fixture
def patrol(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """The folder that docs/testing.md describes."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    for text in re.findall(r"^```\w+\n(# file: .*?)^```", DOCUMENT.read_text("utf-8"), re.M | re.S):
        name = text.split("\n")[0].removeprefix("# file: ")
        (pytester.path / name).write_text(text, "utf-8")
    return pytester


def test_what_the_document_shows_passes_and_its_coverage_is_told(patrol: pytest.Pytester) -> None:
    result = patrol.runpytest_subprocess("-p", PLUGIN, "--mission-coverage")
    result.assert_outcomes(passed=4)
    lines = result.outlines
    title = next(n for n, line in enumerate(lines) if line.startswith("patrol.yaml (patrol): "))
    assert lines[title : title + 6] == [
        "patrol.yaml (patrol): 8 of 8 states, 8 of 12 transitions",
        "  patrol.yaml:4:76: takeoff → land by on failed",
        "  patrol.yaml:6:52: patrol → land by on failed",
        "  patrol.yaml:11:64: home → land by on blocked",
        "  patrol.yaml:11:78: home → land by on failed",
        lines[title + 5],
    ]
    assert not lines[title + 5].startswith("  ")


def test_without_the_option_nothing_is_told(patrol: pytest.Pytester) -> None:
    result = patrol.runpytest_subprocess("-p", PLUGIN, "-k", "battery")
    result.assert_outcomes(passed=1, deselected=3)
    result.stdout.no_fnmatch_line("*mission coverage*")


def test_workers_add_up(patrol: pytest.Pytester) -> None:
    pytest.importorskip("xdist")
    result = patrol.runpytest_subprocess(
        "-p", "xdist", "-p", PLUGIN, "--mission-coverage", "-n", "2", "-k", "there or battery"
    )
    result.assert_outcomes(passed=2)
    result.stdout.fnmatch_lines(["patrol.yaml (patrol): 8 of 8 states, 7 of 12 transitions"])


def test_a_text_and_a_vocabulary_of_ones_own(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        from fsm import BehaviorInfo, Vocabulary
        from fsm.testing import ends

        WORDS = Vocabulary({"cook": BehaviorInfo("cook", outcomes={"done": {}, "burnt": {}})})
        MEAL = '''
        mission: meal
        states:
          cook: {do: cook, on: {done: eat, burnt: order, failed: order}}
          order: {after: {5 s: eat}}
          eat: {type: final}
        '''

        def test_meal(mission):
            run = mission(MEAL, {"cook": ends("burnt", after=1)}, vocabulary=WORDS)
            run.until("order").advance(5.1).assert_path("cook", "order", "eat")
        """
    )
    pytester.runpytest_subprocess("-p", PLUGIN).assert_outcomes(passed=1)


def test_the_plugin_imports_nothing_of_ours_before_it_is_used() -> None:
    code = (
        "import sys, pytest; before = set(sys.modules); import runner.pytest_plugin; "
        "print(sorted(set(sys.modules) - before))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['runner', 'runner.pytest_plugin']"


def test_flights_of_tests_need_no_command_line() -> None:
    code = (
        "import sys, runner.pytest_plugin; from runner.testing import fly_mission\n"
        "print(fly_mission('first_flight').outcome)\n"
        "print(sorted({'cli', 'click', 'rich', 'PIL'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[-3:] == ["done", "[]", ""]
