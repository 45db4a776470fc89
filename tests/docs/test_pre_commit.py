"""The hooks of .pre-commit-config.yaml are the lint of the Makefile."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]


def test_the_hooks_run_what_make_lint_runs() -> None:
    config = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))
    (repository,) = config["repos"]
    assert repository["repo"] == "local"
    entries = [hook["entry"].removesuffix(" --force-exclude") for hook in repository["hooks"]]
    lint = re.search(r"^lint:.*\n((?:\t.*\n)+)", (ROOT / "Makefile").read_text("utf-8"), re.M)
    assert lint is not None
    commands = [
        # A hook rewrites what is formatted otherwise, and fails by that.
        line.strip().replace("$(BIN)", ".venv/bin").removesuffix(" .").removesuffix(" --check")
        for line in lint[1].splitlines()
    ]
    assert entries == commands
