"""Files that a mission's behaviours name."""

from __future__ import annotations

from pathlib import Path

import pytest

from runner.missions import Found
from runner.preparation import Prepared, prepare
from vencejo.errors import UserError

MISSION = """\
mission: along
parameters: {name: path.csv}
states:
  up: {do: takeoff, on: {done: fly}}
  fly:
    do: follow_path
    with: {shape: file, file: NAME}
    on: {done: MORE, blocked: down}
  again: {include: parts/again.yaml, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
AGAIN = """\
states:
  fly:
    do: follow_path
    with: {shape: file, file: path.csv}
    on: {done: there, blocked: there}
  there: {type: final}
"""
CSV = "t,x,y,z\n0,0,0,2\n3,3,0,2\n"


def prepared(folder: Path, name: str, more: str = "again") -> Prepared:
    path = folder / "along.yaml"
    text = MISSION.replace("NAME", name).replace("MORE", more)
    if more == "down":
        text = text.replace("  again: {include: parts/again.yaml, on: {done: down}}\n", "")
    path.write_text(text)
    return prepare(Found(path, "missions/along.yaml"))


def fault_of(folder: Path, name: str, more: str = "down") -> tuple[str, str, str]:
    with pytest.raises(UserError) as caught:
        prepared(folder, name, more)
    (fault,) = caught.value.faults
    return str(fault.where), fault.code, fault.message


def test_each_file_is_named_from_what_names_it_and_kept(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/again.yaml").write_text(AGAIN)
    (tmp_path / "parts/path.csv").write_text(CSV)
    (tmp_path / "own.csv").write_text("x,y,z\n1,2,3\n3,0,2\n")
    mission = prepared(tmp_path, "own.csv")
    names = ["along.yaml", "parts/again.yaml", "own.csv", "parts/path.csv"]
    assert mission.files == tuple(tmp_path / name for name in names)
    assert mission.graph.files["own.csv"].times is None
    assert mission.graph.files["path.csv"].times == (0.0, 3.0)


def test_one_word_is_one_file(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/again.yaml").write_text(AGAIN)
    for name in ("path.csv", "parts/path.csv"):
        (tmp_path / name).write_text(CSV)
    where, code, message = fault_of(tmp_path, "path.csv", "again")
    assert (where, code) == ("missions/parts/again.yaml:4:31", "same-name")
    assert message == "another graph of this mission has another file 'path.csv'"


@pytest.mark.parametrize(
    ("name", "where", "code"),
    [
        ("pats.csv", "along.yaml:7:31", "no-such-file"),
        ("../path.csv", "along.yaml:7:31", "outside-folder"),
        ("/etc/passwd", "along.yaml:7:31", "outside-folder"),
        ("$name", "along.yaml:7:32", "computed-file"),
        ('"${name}"', "along.yaml:7:34", "computed-file"),
        ("flawed.csv", "flawed.csv:2:3", "wrong-path-file"),
        (".", "along.yaml:7:31", "not-a-file"),
        ('""', "along.yaml:7:31", "not-a-file"),
        ("1", "along.yaml:7:31", "no-such-file"),
    ],
)
def test_what_cannot_be_read_is_told(name: str, where: str, code: str, tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text(CSV)
    (tmp_path / "flawed.csv").write_text("x,y,z\n1,two,3\n2,2,2\n")
    found = fault_of(tmp_path, name)
    assert found[:2] == (f"missions/{where}", code)
