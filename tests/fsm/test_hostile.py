"""Malicious missions are refused, soon and clearly; mangled ones fly or are refused."""

from __future__ import annotations

import builtins
import json
import os
import socket
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from time import process_time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors import drone_vocabulary, load_all, trusted
from fsm import Graph, compile_mission, prove, read_mission_text
from fsm.faults import Faults
from fsm.values.functions import FAILURES
from tests.fsm.toy import Run, faults_of
from vencejo.errors import Fault, UserError
from vencejo.nodes import Scalar, read_text

VOCABULARY = drone_vocabulary()
MISSIONS = [path.read_text() for path in (Path(__file__).parents[2] / "missions").glob("*.yaml")]


def expression(text: str) -> str:
    """A mission that evaluates an expression on entry."""
    quoted = text.replace("'", "''")
    state = f"{{entry: {{log: '${{{quoted}}}'}}, on: {{operator.abort: a}}}}"
    return f"data: {{x: 1}}\nstates:\n  a: {state}\n"


def bomb() -> str:
    text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n"
    for level in range(1, 10):
        text += f"a{level}: &a{level} [{', '.join([f'*a{level - 1}'] * 10)}]\n"
    return text + "states: {a: {}}\n"


def nested(depth: int) -> str:
    return "states: {a: " + "{states: {a: " * depth + "{}" + "}}" * depth + "}\n"


REFUSED = {
    "alias bomb": (bomb(), "too-many-nodes"),
    "300 nested states": (nested(300), "too-deep"),
    "100,000 brackets": ("states: " + "[" * 100_000, "too-deep"),
    "an anchor inside itself": ("states: &a {b: *a}\n", "unknown-anchor"),
    "a merge of itself": ("states: &a {<<: *a}\n", "unknown-anchor"),
    "Python tag": ("states: !!python/object/apply:os.system ['true']\n", "custom-tag"),
    "a text over 1 MiB": ("description: " + "x" * (1 << 20), "too-large"),
    "dunder field": (expression("x.__class__"), "unknown-field"),
    "dunder of a text": (expression("''.__class__.__mro__"), "unknown-field"),
    "dunder name": (expression("__import__('os')"), "unknown-function"),
    "builtins": (expression("__builtins__"), "unknown-name"),
    "open": (expression("open('/etc/passwd')"), "unknown-function"),
    "eval": (expression("eval('1')"), "unknown-function"),
    "a method": (expression("'{0.__class__}'.format(x)"), "unknown-function"),
    "a lambda": (expression("(lambda: 1)()"), "unknown-function"),
    "a walrus": (expression("(y := 1)"), "bad-expression"),
    "a format that reaches": (expression("x:{x.__class__}"), "bad-expression"),
    "a percent format": (expression("'%1000000000d' % x"), "bad-expression"),
    "deep brackets": (expression("(" * 400 + "1" + ")" * 400), "bad-expression"),
    "a million letters": (expression("1 + " * 200_000 + "1"), "expression-too-long"),
}


def codes(text: str) -> set[str]:
    return {fault.code for fault in faults_of(text)}


@pytest.mark.parametrize(("text", "code"), REFUSED.values(), ids=REFUSED)
def test_refused_in_under_a_second(text: str, code: str) -> None:
    began = process_time()
    found = codes(text)
    assert process_time() - began < 1
    assert code in found


AT_WORK = {
    "a huge text": "'a' * 10**9",
    "a doubling list": "[0] * 10**9",
    "a power": "9**9**9",
    "a comprehension of comprehensions": "len([a for a in "
    + "[1, 2, 3, 4, 5, 6, 7, 8, 9, 0] for b in [1, 2, 3, 4, 5, 6, 7, 8, 9, 0] "
    "for c in [1, 2, 3, 4, 5, 6, 7, 8, 9, 0] for d in [1, 2, 3, 4, 5, 6, 7, 8, 9, 0] "
    "for e in [1, 2, 3, 4, 5, 6, 7, 8, 9, 0] for f in [1, 2, 3, 4, 5, 6, 7, 8, 9, 0]])",
    "a list of lists of lists": "[[[[x for a in [1, 2, 3, 4, 5, 6, 7, 8, 9]] for b in "
    "[1, 2, 3, 4, 5, 6, 7, 8, 9]] for c in [1, 2, 3, 4, 5, 6, 7, 8, 9]] for d in "
    "[1, 2, 3, 4, 5, 6, 7, 8, 9]]",
}


@pytest.mark.parametrize("text", AT_WORK.values(), ids=AT_WORK)
def test_what_is_only_large_when_it_runs_is_stopped_there(text: str) -> None:
    began = process_time()
    if not [f for f in faults_of(expression(text)) if f.severity == "error"]:
        run = Run(expression(text))
        run.run(2)
        assert max(map(len, run.take()), default=0) < 2_000_000
    assert process_time() - began < 1


@pytest.mark.parametrize("name", ["../evil.py", "/etc/passwd", "sub/../../evil.py", "link.py"])
def test_code_outside_the_folder_is_refused(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "mission"
    (folder / "sub").mkdir(parents=True)
    (tmp_path / "evil.py").write_text("raise SystemExit\nclass Evil(Behavior): pass\n")
    (folder / "link.py").symlink_to(tmp_path / "evil.py")
    uses = [(Scalar(name, read_text("a: b", "m.yaml").where), folder)]
    with pytest.raises(UserError) as raised:
        load_all(uses)
    assert raised.value.code == "outside-folder"
    faults: list[Fault] = []
    assert trusted(uses, faults) == {}
    assert [fault.code for fault in faults] == ["outside-folder"]


@pytest.fixture
def shut(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Every way out of the process, each of which only notes that it was tried."""
    tried: list[str] = []

    def closed(name: str) -> object:
        return lambda *arguments, **named: tried.append(name)

    with monkeypatch.context() as patch:
        for place, name in (
            (builtins, "open"), (builtins, "exec"), (builtins, "input"), (os, "system"),
            (os, "open"), (socket, "socket"), (subprocess, "Popen"),
        ):  # fmt: skip
            patch.setattr(place, name, closed(name))
        yield tried


def test_no_expression_reaches_out(shut: list[str]) -> None:
    for text, _ in REFUSED.values():
        faults_of(text)
    for text in AT_WORK.values():
        if not [f for f in faults_of(expression(text)) if f.severity == "error"]:
            Run(expression(text)).run(1)
    assert shut == []


def checked(text: str) -> Graph | tuple[Fault, ...]:
    """A graph, or the faults that keep it from flying; nothing else may come out."""
    faults = Faults()
    try:
        graph = compile_mission(read_mission_text(text, "m.yaml", None, faults), VOCABULARY, faults)
        prove(graph)
        return graph
    except UserError as error:
        return error.faults


TOKENS = ["on", "do", "states", "type", "parallel", "history", "final", "$", "${", "}", "{", "[",
          "]", ":", ",", "*", "&a", "*a", "<<", "!x", "-1e999", "null", "land", "goto", "done",
          "link.lost", "__class__", "\t", "'", '"', "#", "|", "home", "a.b", "5 s"]  # fmt: skip


@st.composite
def mangled(draw: st.DrawFn) -> str:
    """A shipped mission with lines or words dropped, doubled, exchanged or replaced."""
    lines = draw(st.sampled_from(MISSIONS)).splitlines()
    for _ in range(draw(st.integers(1, 5))):
        at = draw(st.integers(0, len(lines) - 1))
        match draw(st.sampled_from(["drop", "double", "swap", "token", "insert", "indent"])):
            case "drop" if len(lines) > 1:
                del lines[at]
            case "double":
                lines.insert(at, lines[at])
            case "swap":
                other = draw(st.integers(0, len(lines) - 1))
                lines[at], lines[other] = lines[other], lines[at]
            case "indent":
                lines[at] = " " * draw(st.integers(0, 6)) + lines[at].lstrip()
            case kind:
                words = lines[at].split(" ")
                place = draw(st.integers(0, len(words) - 1))
                token = draw(st.sampled_from(TOKENS))
                words[place : place + (kind == "token")] = [token]
                lines[at] = " ".join(words)
    return "\n".join(lines) + "\n"


@settings(max_examples=150, deadline=None)
@given(mangled())
def test_a_mangled_mission_flies_or_is_refused(text: str) -> None:
    found = checked(text)
    if not isinstance(found, Graph):
        assert all(str(fault) for fault in found)
        assert found[0].severity == "error"


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=60))
def test_any_expression_has_a_value_or_is_refused(text: str) -> None:
    graph = checked(f"states:\n  a: {{when: {{{json.dumps(text)}: b}}}}\n  b: {{type: final}}\n")
    if isinstance(graph, Graph):
        condition = graph.nodes[1].whens[0].condition
        with suppress(*FAILURES):
            condition([0.0] * graph.slots)
