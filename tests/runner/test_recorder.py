"""Run folders: their names."""

from __future__ import annotations

from pathlib import Path

import pytest

from runner.recorder import new_folder
from vencejo import UserError


def test_folders_of_one_name_are_numbered(tmp_path: Path) -> None:
    names = [new_folder(tmp_path, "20260101-000000", "a").name for _ in range(3)]
    assert names == ["20260101-000000-a", "20260101-000000-a-2", "20260101-000000-a-3"]


def test_a_runs_dir_that_cannot_be_is_a_fault(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot make a run folder"):
        new_folder(tmp_path / "file", "now", "a")
