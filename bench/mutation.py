"""Mutation testing: random lines of the packages are changed, one at a time, and tested.

python -m bench.mutation [--mutants 60] [--seed 0] [--jobs 2] [--only FILE:LINE] [--json]

Each mutant lives in a copy of the checkout, and only tests that execute its line are run, the
fastest first, until one fails. The first run for a state of the checkout measures which tests
these are (some minutes, kept in the system's folder for temporary files).
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import random
import shutil
import signal
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import pytest

from bench.machine import machine
from bench.mutation_coverage import (
    EQUIVALENT,
    PLUGIN,
    CoverageMap,
    copy_checkout,
    coverage_map,
    environment,
    modules,
)
from bench.mutation_operators import Mutation, mutations, optional_arguments
from bench.mutation_plugin import Report

GOAL = 0.85
SECONDS = 105.0
"""Time limit for one mutant: 60 of them take less than an hour on two cores."""


RESULTS = ("killed", "timeout", "survived", "uncovered", "equivalent")


@dataclass(frozen=True)
class Mutant:
    file: str
    mutation: Mutation
    code: str
    """Text of the mutated line, without its indentation."""

    @property
    def place(self) -> str:
        return f"{self.file}:{self.mutation.line}"

    @property
    def key(self) -> tuple[str, str, str]:
        """Identifies the mutant in the list of equivalent ones; line numbers change too often."""
        return self.file, self.code, str(self.mutation)


@dataclass(frozen=True)
class Verdict:
    mutant: Mutant
    result: str
    """One of RESULTS."""
    why: str
    seconds: float = 0.0


def mutants_by_line(sources: Mapping[str, str]) -> Mapping[tuple[str, int], Sequence[Mutant]]:
    """All mutants of these modules (path → text), by path and line."""
    optional = optional_arguments(sources.values())
    found: defaultdict[tuple[str, int], list[Mutant]] = defaultdict(list)
    for file, source in sources.items():
        lines = source.splitlines()
        for mutation in mutations(source, optional):
            code = lines[mutation.line - 1].strip()
            found[file, mutation.line].append(Mutant(file, mutation, code))
    return found


def chosen(
    by_line: Mapping[tuple[str, int], Sequence[Mutant]], count: int, seed: int
) -> list[Mutant]:
    """One mutant of each of `count` lines, drawn uniformly over the lines that have any."""
    draw = random.Random(seed)
    lines = draw.sample(sorted(by_line), min(count, len(by_line)))
    return [draw.choice(by_line[line]) for line in lines]


def equivalents(text: str) -> Mapping[tuple[str, str, str], str]:
    """Read the list of mutants that a person judged equivalent: key → reason.

    Paragraphs of four lines: file, text of the code line, mutation, reason; `#` begins a comment.
    Raises ValueError for a paragraph that has another number of lines.
    """
    found = {}
    kept = "\n".join(line.strip() for line in text.splitlines() if not line.startswith("#"))
    for paragraph in filter(None, (part.strip() for part in kept.split("\n\n"))):
        lines = paragraph.splitlines()
        if len(lines) != 4:
            raise ValueError(f"{EQUIVALENT}: four lines are needed, not these:\n{paragraph}")
        found[lines[0], lines[1], lines[2]] = lines[3]
    return found


async def judged(mutant: Mutant, tree: Path, known: CoverageMap) -> Verdict:
    """Test one mutant in a copy of the checkout, and restore the copy."""
    tests = known.tests_of(mutant.file, mutant.mutation)
    if not tests:
        return Verdict(mutant, "uncovered", "(no test covers it)")
    path = tree / mutant.file
    source = path.read_text(encoding="utf-8")
    mutated = mutant.mutation.apply(source)
    compile(mutated, mutant.place, "exec")
    began = perf_counter()
    _write(path, mutated)
    try:
        code, report = await _tested(tree, {test: 10 + 10 * known.seconds[test] for test in tests})
    finally:
        _write(path, source)
    seconds = perf_counter() - began
    failed = [test for test, (_, failed) in report["tests"].items() if failed]
    if failed:
        return Verdict(mutant, "killed", f"by {failed[0]}", seconds)
    if code is None:
        cut = f"what {SECONDS:.0f} s allowed of {len(tests)} tests, up to {report['running']}"
        return Verdict(mutant, "survived", cut, seconds)
    if code in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
        return Verdict(mutant, "survived", f"{len(tests)} tests", seconds)
    if code == 1:  # the watchdog's
        return Verdict(mutant, "timeout", f"in {report['running']}", seconds)
    return Verdict(mutant, "killed", f"by exit code {code} in {report['running']}", seconds)


def _write(path: Path, text: str) -> None:
    """Write a module with another time than before: byte code is kept by second and size."""
    before = path.stat().st_mtime
    path.write_text(text, encoding="utf-8")
    os.utime(path, (before + 2, before + 2))


async def _tested(tree: Path, limits: Mapping[str, float]) -> tuple[int | None, Report]:
    """Run tests (node id → seconds) in order until one fails.

    Returns pytest's exit code, None if SECONDS did not suffice, and what it reported.
    """
    chosen, written = tree.with_suffix(".tests"), tree.with_suffix(".report")
    chosen.write_text(json.dumps(limits))
    written.write_text(json.dumps({"tests": {}, "running": "the start of pytest"}))
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "pytest", "-x", "--tb=no", *PLUGIN),
        *(f"--tests-from={chosen}", f"--report-to={written}"),
        *sorted({test.partition("::")[0] for test in limits}),
        cwd=tree,
        env=environment(tree),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.DEVNULL,
        start_new_session=True,
    )
    code = None
    try:
        with suppress(TimeoutError):
            async with asyncio.timeout(SECONDS):
                code = await process.wait()
    finally:
        with suppress(ProcessLookupError):  # also what the tests started and left
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
    report: Report = json.loads(written.read_text())
    return code, report


async def judge_all(
    mutants: Sequence[Mutant], tree: Path, known: CoverageMap, jobs: int, shown: bool
) -> list[Verdict]:
    """Test mutants, `jobs` at a time, each job in a copy of the tree; verdicts in their order."""
    equivalent = equivalents((tree / EQUIVALENT).read_text(encoding="utf-8"))
    verdicts: dict[Mutant, Verdict] = {}
    waiting = iter(mutants)

    async def work(copy: Path) -> None:
        for mutant in waiting:
            if mutant.key in equivalent:
                verdict = Verdict(mutant, "equivalent", f"({equivalent[mutant.key]})")
            else:
                verdict = await judged(mutant, copy, known)
            verdicts[mutant] = verdict
            if shown:
                print(line(verdict), flush=True)

    async with asyncio.TaskGroup() as group:
        for job in range(jobs):
            copy = tree.with_name(f"copy{job}")
            shutil.copytree(tree, copy)
            group.create_task(work(copy))
    return [verdicts[mutant] for mutant in mutants]


def line(verdict: Verdict) -> str:
    """A verdict for the terminal, with the code line unless the mutant was killed."""
    mutant = verdict.mutant
    text = f"  {mutant.place}: {mutant.mutation}: {verdict.result} {verdict.why}"
    return text if verdict.result in ("killed", "timeout") else f"{text}\n      {mutant.code}"


def score(counts: Mapping[str, int]) -> float:
    """The share of mutants killed, by failure or time limit, of those not equivalent."""
    judged = sum(counts.values()) - counts["equivalent"]
    return (counts["killed"] + counts["timeout"]) / judged if judged else 1.0


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--mutants", type=int, default=60, help="how many lines to mutate")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="mutants tested at the same time")
    parser.add_argument("--only", metavar="FILE:LINE", help="all mutants of this line instead")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that the copies are removed
    with tempfile.TemporaryDirectory(prefix="vencejo-mutation-") as folder:
        tree = Path(folder).resolve() / "tree"
        copy_checkout(tree)
        run(tree, options)


def run(tree: Path, options: argparse.Namespace) -> None:
    """Mutate a copy of the checkout by the options, and print the results."""
    by_line = mutants_by_line(modules(tree))
    if options.only:
        file, _, number = options.only.rpartition(":")
        mutants = by_line.get((file, int(number) if number.isdigit() else 0), ())
        if not mutants:
            sys.exit(f"nothing to mutate in {options.only}; give a line as fsm/fleet.py:12")
    else:
        mutants = chosen(by_line, options.mutants, options.seed)
    shown = not options.json
    if shown:
        which = options.only or f"{len(mutants)} of {len(by_line)} lines, seed {options.seed}"
        print(f"mutation, {which}; goal ≥ {GOAL:.0%}; {machine()}", flush=True)
    began = perf_counter()
    try:
        known = coverage_map(tree, options.jobs)
    except RuntimeError as error:
        sys.exit(str(error))
    measured = perf_counter()
    if shown:
        print(
            f"  {len(known.seconds)} tests pass and count, {len(known.failing)} do not"
            f" ({', '.join(known.failing) or 'none'}); measured in {measured - began:.0f} s",
            flush=True,
        )
    verdicts = asyncio.run(judge_all(mutants, tree, known, options.jobs, shown))
    minutes = (perf_counter() - measured) / 60
    counts = Counter(verdict.result for verdict in verdicts)
    if shown:
        print(
            f"  score {score(counts):.0%}: {counts['killed']} killed, {counts['timeout']} timed"
            f" out, {counts['survived']} survived, {counts['uncovered']} not covered,"
            f" {counts['equivalent']} equivalent; {minutes:.1f} min"
        )
        return
    figures = {
        "machine": machine(),
        "seed": None if options.only else options.seed,
        "goal": GOAL,
        "score": score(counts),
        "counts": {result: counts[result] for result in RESULTS},
        "minutes": minutes,
        "not_passing": known.failing,
        "mutants": [described(verdict) for verdict in verdicts],
    }
    print(json.dumps(figures, indent=2, ensure_ascii=False))


def described(verdict: Verdict) -> Mapping[str, str | float]:
    """A verdict for the JSON."""
    mutant = verdict.mutant
    return {
        "place": mutant.place,
        "code": mutant.code,
        "mutation": str(mutant.mutation),
        "result": verdict.result,
        "why": verdict.why,
        "seconds": verdict.seconds,
    }


if __name__ == "__main__":
    main()
