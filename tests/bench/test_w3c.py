"""The bench of the W3C's tests, on documents of our own."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from bench import w3c

HEAD = '<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">'
ENDS = '<final id="pass"/><final id="fail"/></scxml>'
TESTS = {
    "mandatory/test1": '<state id="s"><transition target="pass"/></state>',
    "mandatory/test2": '<state id="s"><transition target="fail"/></state>',
    "mandatory/test3": '<state id="s"><invoke type="scxml"/></state>',
    "mandatory/test4": '<state id="s"><transition event="e"/></state>',
    "mandatory/test5": '<state id="s"><onentry><send event="e" delay="20s"/></onentry>'
    '<transition event="e" target="pass"/></state>',
    "mandatory/test5sub1": '<state id="s"/>',
    "optional/test6": '<state id="s"><transition cond="new X" target="pass"/></state>',
    "optional/test7": '<state id="s"><onentry><send event="e" target="x" '
    'type="http://www.w3.org/TR/scxml/#BasicHTTPEventProcessor"/></onentry>'
    '<transition event="error" target="fail"/></state>',
}


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    for name, body in TESTS.items():
        path = tmp_path / f"{name}.scxml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(HEAD + body + ENDS)
    return tmp_path


def test_each_test_is_counted_in_its_group_with_the_reason_why_it_did_not_pass(suite: Path) -> None:
    result = w3c.measure(suite)
    assert result["groups"] == {
        "mandatory": {"tests": 4, "passed": 2, "failed": 2, "refused": 0},
        "mandatory, with <invoke>": {"tests": 1, "passed": 0, "failed": 0, "refused": 1},
        "optional": {"tests": 1, "passed": 0, "failed": 0, "refused": 1},
        "optional, over HTTP": {"tests": 1, "passed": 0, "failed": 1, "refused": 0},
    }
    assert result["refused"] == {
        "not-supported: <invoke> in <state> is not supported": 1,
        "not-supported: 'new' is a part of ECMAScript that is not run here": 1,
    }
    assert result["not passed"] == {
        "mandatory: test2": "failed: ended in fail",
        "mandatory, with <invoke>: test3": "refused: not-supported: <invoke> in <state> is not "
        "supported",
        "mandatory: test4": "failed: ended in s",
        "optional: test6": "refused: not-supported: 'new' is a part of ECMAScript that is not run "
        "here",
        "optional, over HTTP: test7": "failed: ended in fail",
    }


def test_the_table_is_printed(
    suite: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["w3c", str(suite)])
    w3c.main()
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].split() == ["tests", "passed", "failed", "refused"]
    assert lines[2].split() == ["mandatory", "4", "2", "2", "0"]
    assert lines[-1] == "  optional, over HTTP: test7: failed: ended in fail"


def test_without_a_folder_there_is_a_line_of_help(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["w3c"])
    with pytest.raises(SystemExit, match=r"usage: python -m bench\.w3c FOLDER"):
        w3c.main()
