"""A plugin of pytest for tests of missions: fixtures `mission` and `fly`, and their coverage.

Every pytest of the environment loads it: nothing of ours is imported before a fixture is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fsm import Vocabulary
    from fsm.coverage import Coverage
    from fsm.testing import Ending, Trial
    from runner.testing import MissionFlight

COVERAGE: pytest.StashKey[Coverage] = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.getgroup("vencejo").addoption(
        "--mission-coverage",
        action="store_true",
        help="show which states and transitions of missions the tests did not visit",
    )


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--mission-coverage"):
        from fsm.coverage import Coverage

        config.stash[COVERAGE] = Coverage()


@pytest.fixture
def mission(pytestconfig: pytest.Config) -> Callable[..., Trial]:
    """Make a trial of a mission (path, name or text): its graph, stepped without any vehicle.

    ``behaviors`` says how its behaviours end: ``{"goto": ends("blocked", after=2.0)}``;
    ``parameters`` are texts as after ``-p``; ``vocabulary`` replaces that of drones.
    """

    def make(
        source: str | Path,
        behaviors: Mapping[str, Ending] | None = None,
        parameters: Mapping[str, str] | None = None,
        *,
        vocabulary: Vocabulary | None = None,
    ) -> Trial:
        from fsm import parse_parameters
        from fsm.testing import Trial
        from runner.testing import graph_of

        graph = graph_of(source, vocabulary)
        _watch(pytestconfig)(graph)
        return Trial(graph, behaviors, parse_parameters(graph, parameters or {}))

    return make


@pytest.fixture
def fly(pytestconfig: pytest.Config) -> Callable[..., MissionFlight]:
    """Fly a mission in the simulator (see runner.testing.fly_mission)."""

    def flown(mission: str | Path, *args: Any, **settings: Any) -> MissionFlight:
        from runner.testing import fly_mission

        return fly_mission(mission, *args, watch=_watch(pytestconfig), **settings)

    return flown


def _watch(config: pytest.Config) -> Callable[[Any], None]:
    coverage = config.stash.get(COVERAGE, None)
    return coverage.watch if coverage else lambda graph: None


def pytest_sessionfinish(session: pytest.Session) -> None:
    """A worker of pytest-xdist hands what it has collected to the process that reports."""
    coverage = session.config.stash.get(COVERAGE, None)
    output = getattr(session.config, "workeroutput", None)
    if coverage and output is not None:
        output["mission_coverage"] = coverage.to_json()


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: object) -> None:
    coverage = node.config.stash.get(COVERAGE, None)
    if coverage:
        coverage.add(getattr(node, "workeroutput", {}).get("mission_coverage", {}))


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    coverage = config.stash.get(COVERAGE, None)
    if coverage and coverage.missions:
        terminalreporter.section("mission coverage")
        for line in coverage.lines():
            terminalreporter.write_line(line)
