"""The tests that execute each line, by one run of the quick tests under coverage.py."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import coverage
import pytest
from coverage import CoverageData

from bench.mutation_operators import Mutation
from bench.mutation_plugin import TEST, Report

ROOT = Path(__file__).parents[1]
EQUIVALENT = "bench/mutation_equivalent.txt"
PLUGIN = ("-p", "bench.mutation_plugin")

CONFIGURATION = """\
[run]
core = ctrace
parallel = true
data_file = {data}
source =
    {source}
context = ${{{test}-}}
sigterm = true
disable_warnings =
    no-data-collected
    module-not-measured
    module-not-imported
    already-imported
"""


def copy_checkout(target: Path) -> None:
    """Copy the checkout as it stands: what git tracks, and what is new and not ignored."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target / name)


def packages(tree: Path) -> list[str]:
    """The top-level packages of the distribution, as pyproject.toml lists them for mypy."""
    project = tomllib.loads((tree / "pyproject.toml").read_text())
    found: list[str] = project["tool"]["mypy"]["packages"]
    return found


def modules(tree: Path) -> dict[str, str]:
    """Every module of the packages, by its path, with its source text."""
    paths = (path for package in packages(tree) for path in (tree / package).rglob("*.py"))
    return {str(path.relative_to(tree)): path.read_text(encoding="utf-8") for path in sorted(paths)}


def environment(tree: Path) -> dict[str, str]:
    """Environment of a process that imports from a tree, with its temporary files beside it."""
    rubbish = tree.with_name(f"{tree.name}.tmp")
    rubbish.mkdir(exist_ok=True)
    return {**os.environ, "PYTHONPATH": str(tree), "TMPDIR": str(rubbish)}


class CoverageMap:
    """The tests of the quick tier that pass, how long each takes, and the lines it executes."""

    def __init__(self, folder: Path) -> None:
        about = json.loads((folder / "tests.json").read_text())
        self.root = Path(about["root"])
        self.seconds: Mapping[str, float] = about["seconds"]
        self.failing: list[str] = about["failing"]
        self._data = CoverageData(str(folder / "coverage"))
        self._data.read()
        self._lines: dict[str, Mapping[int, list[str]]] = {}

    def tests_of(self, file: str, mutation: Mutation) -> list[str]:
        """Tests that execute a mutated expression, the fastest first.

        For code executed at import it is not known which tests use its values: then all tests
        count that execute anything in the module, and all tests of its package's folder.
        """
        lines = self._contexts(file)
        mutated = range(mutation.line, mutation.end_line + 1)
        contexts = {test for line in mutated for test in lines.get(line, ())}
        contexts = contexts or set(lines.get(mutation.statement, ()))
        if mutation.at_import or "" in contexts:
            folder = f"tests/{file.partition('/')[0]}/"
            contexts |= {test for tests in lines.values() for test in tests}
            contexts |= {test for test in self.seconds if test.startswith(folder)}
        return sorted(contexts & self.seconds.keys(), key=lambda test: (self.seconds[test], test))

    def _contexts(self, file: str) -> Mapping[int, list[str]]:
        if file not in self._lines:
            self._lines[file] = self._data.contexts_by_lineno(str(self.root / file))
        return self._lines[file]


def coverage_map(tree: Path, jobs: int) -> CoverageMap:
    """The map of a copy of the checkout, measured there unless that was done before.

    Raises RuntimeError with pytest's last words if its tests could not be run.
    """
    cache = Path(tempfile.gettempdir()) / f"vencejo-mutation-{_digest(tree)}"
    if not cache.exists():
        with tempfile.TemporaryDirectory(prefix="vencejo-mutation-") as folder:
            found = _measured(tree, Path(folder).resolve(), jobs)
            with suppress(OSError):  # another process made it meanwhile
                found.rename(cache)
    return CoverageMap(cache)


def _digest(tree: Path) -> str:
    """A digest of everything that the coverage map depends on."""
    digest = hashlib.sha256(f"{sys.version} {coverage.__version__}".encode())
    for path in sorted(path for path in tree.rglob("*") if path.is_file()):
        name = str(path.relative_to(tree))
        if name != EQUIVALENT:
            digest.update(f"{name}\0".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def _measured(tree: Path, folder: Path, jobs: int) -> Path:
    """Run the tests of a tree, and return the folder of the map, made inside `folder`."""
    raw, found = folder / "raw", folder / "map"
    raw.mkdir()
    found.mkdir()
    source = "\n    ".join(str(tree / package) for package in packages(tree))
    configuration = CONFIGURATION.format(data=raw / "coverage", source=source, test=TEST)
    (folder / "coveragerc").write_text(configuration)
    report = folder / "report.json"
    imports = [f"--import-all={package}" for package in packages(tree)]
    command = [sys.executable, "-m", "pytest", *PLUGIN, *imports, f"-n{jobs}", "--tb=no"]
    measured = {**environment(tree), "COVERAGE_PROCESS_START": str(folder / "coveragerc")}
    command.append(f"--report-to={report}")
    run = subprocess.run(
        command, cwd=tree, env=measured, check=False, capture_output=True, text=True
    )
    if run.returncode not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        raise RuntimeError(f"the tests could not be run:\n{(run.stdout + run.stderr)[-2000:]}")
    combine = [sys.executable, "-m", "coverage", "combine", "-q", f"--data-file={found}/coverage"]
    subprocess.run([*combine, f"--rcfile={folder}/coveragerc", raw], cwd=tree, check=True)
    written: Report = json.loads(report.read_text())
    tests = written["tests"]
    about = {
        "root": str(tree),
        "seconds": {test: seconds for test, (seconds, failed) in tests.items() if not failed},
        "failing": sorted(test for test, (_, failed) in tests.items() if failed),
    }
    (found / "tests.json").write_text(json.dumps(about))
    return found
