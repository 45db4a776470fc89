"""Runs what the documents show: each is a script of files to save, missions and commands."""

from __future__ import annotations

import re
import runpy
import shlex
from pathlib import Path

import pytest

from runner.testing import fly_mission
from tests.cli.run_cli import run_cli

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_FILE = re.compile(r"(?:#|<!--) file: (\S+)")


def blocks(document: Path) -> list[tuple[str, str]]:
    return _BLOCK.findall(document.read_text("utf-8"))


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_a_document_does_what_it_says(
    document: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cli.run._draw", lambda folder: None)
    for language, text in blocks(document):
        named = _FILE.match(text)
        if named:
            Path(named[1]).write_text(text, "utf-8")
        elif language == "yaml" and text.startswith("mission:"):
            Path("snippet.yaml").write_text(text, "utf-8")
            flight = fly_mission("snippet.yaml")
            assert flight.outcome == "done", f"{text}\n{flight.reason}"
        elif language == "sh":
            _run_commands(text)


def _run_commands(text: str) -> None:
    for line in text.splitlines():
        command = shlex.split(line, comments=True)
        if command and command[0] == "drone-cli":
            result = run_cli(*command[1:])
            assert result.code == 0, f"{line}\n{result.err}"
        elif command and command[0] == "python" and Path(command[-1]).exists():
            runpy.run_path(command[-1])


def test_every_link_leads_somewhere() -> None:
    for document in [*DOCUMENTS, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]:
        for target in re.findall(r"\]\(([^)#]+)\)", document.read_text("utf-8")):
            if "://" not in target:
                assert (document.parent / target).exists(), f"{document.name}: {target}"


def test_commands_are_those_of_the_active_environment() -> None:
    """After `make run` and activation every page works as pasted."""
    for document in [*DOCUMENTS, ROOT / "CONTRIBUTING.md"]:
        text = document.read_text("utf-8").replace("source .venv/bin/activate", "")
        assert ".venv/bin/" not in text, document.name
    steps = [
        line.partition("#")[0].strip() for line in blocks(ROOT / "README.md")[0][1].split("\n")
    ]
    assert steps[:2] == ["make run", "source .venv/bin/activate"]
    assert '@echo "  source $(BIN)/activate ' in (ROOT / "Makefile").read_text("utf-8")


def test_what_make_run_prints_to_try_next_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shown = re.findall(r"@echo \"  drone-cli (.*)\"", (ROOT / "Makefile").read_text("utf-8"))
    assert len(shown) == 3
    for line in shown:
        command = [word for word in shlex.split(line) if word not in ("--speed", "4")]
        assert run_cli(*command).code == 0, line
