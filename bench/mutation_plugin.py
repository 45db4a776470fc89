"""A pytest plugin for the mutation bench: it selects and orders tests, and reports results.

Measured by coverage.py, it also names the test that runs, as the context of the lines executed.
"""

from __future__ import annotations

import contextlib
import faulthandler
import importlib
import json
import os
import resource
import sys
from collections.abc import Generator, Mapping
from pathlib import Path
from typing import TypedDict

import pytest
from coverage import Coverage
from hypothesis import settings

TEST = "MUTATION_TEST"
"""Environment variable with the test that runs, for the processes which that test starts."""

MEMORY = 4 * 2**30
"""Memory limit for the tests of one mutant, bytes: an endless loop often fills a list."""

IMPORT_SECONDS = 60.0
"""Time limit for collecting the tests: a mutant may hang when it is imported."""


class Report(TypedDict):
    """The results of a run of pytest, as JSON."""

    tests: dict[str, tuple[float, bool]]
    """Node id → seconds, whether it failed; of collectors those that failed."""

    running: str | None
    """The test, or the phase of pytest, that ran when the process ended early; None otherwise."""


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("mutation")
    group.addoption("--report-to", type=Path, help="JSON file for the Report")
    group.addoption("--tests-from", type=Path, help="JSON: node ids to run, in order, to seconds")
    group.addoption("--import-all", action="append", default=[], help="package to import first")


def pytest_configure(config: pytest.Config) -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    settings.register_profile("mutation", deadline=None, derandomize=True, database=None)
    settings.load_profile("mutation")
    if Coverage.current():
        config.pluginmanager.register(_Contexts(config))
    if config.option.report_to and not hasattr(config, "workerinput"):
        reporter = _Reporter(config.option.report_to)
        config.pluginmanager.register(reporter)
        if config.option.tests_from:
            limits = json.loads(config.option.tests_from.read_text())
            config.pluginmanager.register(_Chosen(limits, reporter))


class _Reporter:
    """Writes the report at the end, and before every test, which may never return."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.tests: dict[str, tuple[float, bool]] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        seconds, failed = self.tests.get(report.nodeid, (0.0, False))
        self.tests[report.nodeid] = seconds + report.duration, failed or report.failed

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.tests[report.nodeid] = 0.0, True

    def pytest_sessionfinish(self) -> None:
        self.write({"tests": self.tests, "running": None})

    def write(self, report: Report) -> None:
        unfinished = self.path.with_suffix(".unfinished")
        unfinished.write_text(json.dumps(report))
        unfinished.replace(self.path)


class _Chosen:
    """Runs chosen tests in their order; ends the process if one takes longer than it may."""

    def __init__(self, limits: Mapping[str, float], reporter: _Reporter) -> None:
        self.limits = limits
        self.reporter = reporter
        self.watch("the import of the tests", IMPORT_SECONDS)

    def watch(self, running: str, seconds: float) -> None:
        self.reporter.write({"tests": {}, "running": running})
        faulthandler.dump_traceback_later(seconds, exit=True, file=2)

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        order = {test: place for place, test in enumerate(self.limits)}
        items[:] = [item for item in items if item.nodeid in order]
        items.sort(key=lambda item: order[item.nodeid])

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        self.watch(item.nodeid, self.limits[item.nodeid])
        result = yield
        faulthandler.cancel_dump_traceback_later()
        return result


class _Contexts:
    """Tells coverage.py which test runs.

    Code executed once for many tests would be counted for the first alone. So all modules are
    imported before any test, and caches are emptied between tests.
    """

    def __init__(self, config: pytest.Config) -> None:
        self.packages = config.option.import_all
        self.root = config.rootpath

    def pytest_collection_finish(self) -> None:
        for package in self.packages:
            for path in sorted((self.root / package).rglob("*.py")):
                if path.stem != "__main__":
                    parts = path.relative_to(self.root).with_suffix("").parts
                    with contextlib.suppress(ImportError):
                        importlib.import_module(".".join(parts).removesuffix(".__init__"))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        self.empty_caches()
        self.switch(item.nodeid)
        result = yield
        self.switch("")
        return result

    def switch(self, test: str) -> None:
        os.environ[TEST] = test
        if coverage := Coverage.current():
            coverage.switch_context(test)

    def empty_caches(self) -> None:
        ours = {*self.packages, "tests"}
        for name, module in list(sys.modules.items()):
            if name.partition(".")[0] in ours:
                for value in list(vars(module).values()):
                    if hasattr(value, "cache_clear"):
                        value.cache_clear()

    def pytest_sessionfinish(self) -> None:
        if coverage := Coverage.current():  # a worker of xdist ends without the handlers of exit
            coverage.stop()
            coverage.save()
