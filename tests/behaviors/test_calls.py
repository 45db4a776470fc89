"""Calls into people's code: whatever it raises is a sentence with the place in its file."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from behaviors.calls import MAX_TEXT, Calls, CodeFailed, one_line, place_in
from fsm.values.functions import EvaluationError
from vencejo.errors import Stopped, UserError


def written(folder: Path, text: str, name: str = "own.py") -> Any:
    """A person's file, run as a module of its own."""
    path = folder / name
    path.write_text(text)
    module = ModuleType(path.stem)
    exec(compile(text, str(path), "exec"), vars(module))
    return module


def failure(function: Any, *arguments: Any) -> CodeFailed:
    with pytest.raises(CodeFailed) as raised:
        Calls().run(function, *arguments)
    return raised.value


def test_what_it_returns_is_returned() -> None:
    assert Calls().run(lambda a, b: a - b, 3, 1) == 2


@pytest.mark.parametrize(
    ("statement", "told"),
    [
        ("raise ValueError('no')", "ValueError: no"),
        ("import sys; sys.exit()", "SystemExit"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        ("raise GeneratorExit", "GeneratorExit"),
        ("raise StopIteration(1)", "StopIteration: 1"),
        ("raise MemoryError", "MemoryError"),
        ("f()", "RecursionError: maximum recursion depth exceeded"),
        ("raise Mine('mine')", "Mine: mine"),
        ("raise Mute", "Mute"),
        ("raise Exiting", "Exiting"),
        ("raise Mine('two\\n  lines\\x1b')", "Mine: two lines?"),
        ("raise Mine('half \\ud800')", "Mine: half ?"),
        ("raise ExceptionGroup('all', [ValueError()])", "ExceptionGroup: all (1 sub-exception)"),
        ("{}['key']", "KeyError: 'key'"),
        ("import json; json.loads('{')", "JSONDecodeError: "),
        ("eval('1 +')", "SyntaxError: "),
    ],
)
def test_whatever_it_raises_is_told_with_its_line(
    tmp_path: Path, statement: str, told: str
) -> None:
    own = written(
        tmp_path,
        "class Mine(BaseException): pass\n"
        "class Mute(Exception):\n    def __str__(self): raise self\n"
        "class Exiting(Exception):\n    def __str__(self): raise SystemExit\n"
        f"def f():\n    {statement}\n",
    )
    found = failure(own.f)
    assert found.message.startswith(told)
    assert str(found) == f"{found.message} (own.py:7)"
    assert str(tmp_path) not in str(found)


def test_the_line_is_the_innermost_of_a_person(tmp_path: Path) -> None:
    helper = written(tmp_path, "def half(x):\n    return x / 0\n", "helper.py")
    own = written(tmp_path, "def f(half):\n    return sorted([1], key=half)\n")
    assert str(failure(own.f, helper.half)) == "ZeroDivisionError: division by zero (helper.py:2)"


def test_an_installed_behaviour_is_told_with_its_own_line(tmp_path: Path) -> None:
    folder = tmp_path / "site-packages"
    folder.mkdir()
    own = written(folder, "import json\ndef f():\n    return json.loads('{')\n", "plug.py")
    assert str(failure(own.f)).endswith("(plug.py:3)")


def test_what_speaks_of_the_mission_has_no_line() -> None:
    def unknown_place() -> None:
        raise EvaluationError("there is no place 'x'")

    assert str(failure(unknown_place)) == "there is no place 'x'"


def test_a_fault_is_told_by_its_sentence(tmp_path: Path) -> None:
    own = written(tmp_path, "from hal import Lights\ndef f():\n    Lights('strobo')\n")
    assert str(failure(own.f)) == "there is no pattern of lights 'strobo' (own.py:3)"
    assert isinstance(failure(own.f).cause, UserError)


def test_only_the_operator_gets_through() -> None:
    def stop() -> None:
        raise Stopped

    class Bad(Exception):
        def __str__(self) -> str:
            raise Stopped

    def fail() -> None:
        raise Bad

    for function in (stop, fail):
        calls = Calls()
        with pytest.raises(Stopped):
            calls.run(function)
        assert calls.current == 0


def test_a_call_is_known_while_it_runs_and_only_then() -> None:
    times = iter((3.0, 5.0, 8.0))
    calls = Calls(lambda: next(times))
    seen: list[tuple[int, float]] = []

    def look() -> None:
        seen.append((calls.current, calls.began))

    def nested() -> None:
        look()
        calls.run(look)
        look()

    calls.run(nested)
    assert calls.current == 0
    calls.run(look)
    assert [number for number, _ in seen] == [1, 2, 1, 3]
    assert [began for _, began in seen] == [3.0, 5.0, 5.0, 8.0]


def test_one_that_took_too_long_is_told_in_plain_words(tmp_path: Path) -> None:
    text = "from behaviors import TookTooLong\ndef f():\n    raise TookTooLong('it took 9 s')\n"
    assert str(failure(written(tmp_path, text).f)) == "it took 9 s (own.py:3)"


def test_the_place_of_a_call_under_way(tmp_path: Path) -> None:
    own = written(tmp_path, "def f(look):\n    return [look() for _ in range(1)]\n")

    def look() -> object:
        import sys

        frame = sys._getframe()
        assert frame.f_back
        return place_in(frame.f_back)

    (where,) = Calls().run(own.f, look)
    assert (where.file, where.line) == ("own.py", 2)


@given(st.text(st.characters()))
def test_a_text_becomes_one_short_line(text: str) -> None:
    line = one_line(text)
    assert len(line) <= MAX_TEXT
    assert line.isprintable()
    json.dumps(line, ensure_ascii=False).encode("utf-8")


def test_a_long_text_is_cut() -> None:
    assert one_line("x" * 10_000) == "x" * (MAX_TEXT - 1) + "…"


def test_threads_do_not_disturb_each_other() -> None:
    found: list[object] = []
    thread = threading.Thread(target=lambda: found.append(Calls().run(int, "7")))
    thread.start()
    thread.join()
    assert found == [7]
