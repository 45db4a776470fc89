"""Executable content of SCXML documents: what events carry, and what is no content."""

from __future__ import annotations

import pytest

from fsm.scxml import advance
from tests.fsm.test_scxml import document_run, faults

DATA = '<datamodel><data id="n" expr="3"/><data id="word" expr="\'x\'"/></datamodel>'


def logged(actions: str, heard: str) -> list[str]:
    """What a document logs that does this on entry and ``heard`` for each event."""
    run = document_run(
        f'{DATA}<state id="a"><onentry>{actions}</onentry>'
        f'<transition event="*"><log expr="{heard}"/></transition></state>'
    )
    for period in range(1, 6):
        advance(run.instance, 0.025 * period)
    return run.logged()


@pytest.mark.parametrize(
    ("actions", "heard", "expected"),
    [
        ('<send event="e" namelist="n word"/>', "_event.data.n + _event.data.word", ["3x"]),
        ('<send event="e"><param name="m" expr="n + 1"/></send>', "_event.data.m", ["4"]),
        ('<send event="e"><param name="m" location="n"/></send>', "_event.data.m", ["3"]),
        ("<send eventexpr=\"'e.' + word\"/>", "_event.name", ["e.x"]),
        ('<send event="e" target="#_internal"/><raise event="f"/>', "_event.name", ["e", "f"]),
        ('<raise event="e"/><send event="f"/>', "_event.name", ["e", "f"]),
        ('<send event="e" idlocation="word"/>', "word", ["send.1"]),
        ('<send event="e" delay="50ms"/><send event="f"/>', "_event.name", ["f", "e"]),
        ('<send event="e" delayexpr="n + \'0ms\'"/>', "_event.name", ["e"]),
        ('<send event="e" id="i" delay="50ms"/><cancel sendid="i"/>', "_event.name", []),
        (
            '<send event="e" idlocation="word" delay="50ms"/><cancel sendidexpr="word"/>',
            "_event.name",
            [],
        ),
    ],
)
def test_what_an_event_carries(actions: str, heard: str, expected: list[str]) -> None:
    assert logged(actions, heard) == expected


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ('<send event="e" delayexpr="n"/>', "3 is no delay like '10ms'"),
        ('<foreach array="n" item="word"/>', "3 is no list"),
    ],
)
def test_what_goes_wrong_is_an_event_with_the_reason(actions: str, message: str) -> None:
    (told,) = logged(actions, "_event.name + ': ' + _event.data.message")
    assert told.startswith("error.execution: ") and told.endswith(message)


@pytest.mark.parametrize(
    ("actions", "expected"),
    [
        ("<send/>", "1 missing-attribute"),
        ('<send event="e" eventexpr="n"/>', "28 conflicting-values"),
        ('<send event="e" target="#_internal" targetexpr="n"/>', "49 conflicting-values"),
        ('<send event="e" type="scxml" typeexpr="n"/>', "40 conflicting-values"),
        ('<send event="e" delay="1s" delayexpr="n"/>', "39 conflicting-values"),
        ('<send event="e" id="i" idlocation="n"/>', "36 conflicting-values"),
        ('<send event="e"><content expr="n">1</content></send>', "32 conflicting-values"),
        (
            '<send event="e"><param name="p" expr="n"/><content>1</content></send>',
            "43 conflicting-values",
        ),
        ('<send event="e"><param name="p" expr="n" location="n"/></send>', "52 conflicting-values"),
        ('<send event="e"><content><b/></content></send>', "26 not-supported"),
        ('<send event="e"><log/></send>', "17 not-supported"),
        ('<send event="e" priority="1"/>', "27 unknown-attribute"),
        ('<send event="e"><param expr="n"/></send>', "17 missing-attribute"),
        ('<cancel sendid="a" sendidexpr="n"/>', "32 conflicting-values"),
        ("<cancel/>", "1 missing-attribute"),
        ("<raise/>", "1 missing-attribute"),
        ('<script src="x.js"/>', "14 not-supported"),
        ("<script>if (n) n = 1</script>", "9 not-supported"),
        ("<else/>", "1 not-supported"),
        ('<if cond="true"><else><log/></else></if>', "23 not-supported"),
        ('<log expr="n"><log/></log>', "15 not-supported"),
        ('<assign location="n" expr="1">2</assign>', "28 conflicting-values"),
        ('<assign location="n"><x/></assign>', "22 not-supported"),
        ('<assign location="n"/>', "1 missing-attribute"),
        ('<log expr="n.f()"/>', "15 not-supported"),
        ("<if/>", "1 missing-attribute"),
        ('<if cond="true"><elseif/></if>', "17 missing-attribute"),
        ('<if cond="true"><else/><elseif cond="n"/></if>', "24 bad-if"),
        ('<if cond="true"><else/><else/></if>', "24 bad-if"),
        ('<foreach item="m"/>', "1 missing-attribute"),
    ],
)
def test_what_is_no_content(actions: str, expected: str) -> None:
    column, code = expected.split()
    begins = f'{DATA}<state id="a"><onentry>'
    found = faults(f'{begins}{actions}</onentry></state><state id="b"/>')
    assert found == [f"c.scxml:2:{len(begins) + int(column)}: {code}"]
