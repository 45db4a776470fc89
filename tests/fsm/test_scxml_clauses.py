"""SCXML by the clauses of the W3C recommendation of 2015; their numbers stand in the tests."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fsm import Instance
from fsm.engine.saving import restore, save
from fsm.scxml import advance, load_document, parse_document, read_document, sources
from fsm.values.null import NULL
from tests.fsm.toy import Run
from vencejo.errors import UserError

PROCESSOR = "http://www.w3.org/TR/scxml/#SCXMLEventProcessor"
MODELS = ("ecmascript", "python")
ANY = '<transition event="*" target="no"/>'
"""Whatever else comes is wrong."""


def document(body: str, attributes: str = 'datamodel="ecmascript"') -> str:
    head = f'<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" {attributes}>'
    return f'{head}{body}<final id="yes"/><final id="no"/></scxml>'


def run_of(body: str, attributes: str = 'datamodel="ecmascript"', seconds: float = 10.0) -> Run:
    """A document that has run for some time."""
    text = document(body, attributes)
    run = Run("", graph=load_document(parse_document(text, "c.scxml"), "c"))
    advance(run.instance, 0.0)
    advance(run.instance, seconds)
    return run


def ends(body: str, attributes: str = 'datamodel="ecmascript"') -> str:
    """Where a document ends that has a state with `<onentry>` and transitions to yes and no."""
    return ",".join(run_of(body, attributes).instance.paths())


def state(entry: str, transitions: str, data: str = "") -> str:
    model = f"<datamodel>{data}</datamodel>" if data else ""
    return f'{model}<state id="s"><onentry>{entry}</onentry>{transitions}</state>'


def on(event: str, cond: str = "") -> str:
    guard = f' cond="{cond}"' if cond else ""
    return f'<transition event="{event}"{guard} target="yes"/>{ANY}'


# -- 3: states and events -----------------------------------------------------------------------


def test_3_12_2_an_error_goes_before_external_events() -> None:
    body = state('<send event="e"/><assign location="x.y" expr="1"/>', on("error"))
    assert ends(body) == "yes"


def test_3_13_each_handler_is_a_block_of_its_own() -> None:
    body = (
        '<datamodel><data id="n" expr="0"/></datamodel><state id="s">'
        '<onentry><send event="e" target="nobody"/><assign location="n" expr="n + 1"/></onentry>'
        '<onentry><assign location="n" expr="n + 10"/></onentry>'
        '<transition cond="n == 10" target="yes"/><transition target="no"/></state>'
    )
    assert ends(body) == "yes"


# -- 4: executable content ----------------------------------------------------------------------


@pytest.mark.parametrize("cond", ["1 = 1", "x", "return", "(", ""])
@pytest.mark.parametrize("model", MODELS)
def test_5_9_1_a_condition_without_value_is_false_and_an_error_each_time(
    cond: str, model: str
) -> None:
    body = (
        '<state id="s"><onentry><raise event="e"/><raise event="e"/><raise event="end"/></onentry>'
        f'<transition event="e" cond="{cond}" target="no"/>'
        '<transition event="error.execution"><log expr="_event.name"/></transition>'
        '<transition event="after" target="yes"/>'
        '<transition event="end"><send event="after"/></transition></state>'
    )
    run = run_of(body, f'datamodel="{model}"')
    assert (run.logged(), run.instance.paths()) == (["error.execution"] * 2, ["yes"])


def test_4_3_a_condition_without_value_in_an_if_leads_on() -> None:
    body = state(
        '<if cond="1 +"><raise event="a"/><elseif cond="true"/><raise event="b"/></if>',
        f'<transition event="error"/>{on("b")}',
    )
    assert ends(body) == "yes"


@pytest.mark.parametrize(
    "attributes",
    [
        'array="7" item="i"',
        'array="list" item="\'continue\'"',
        'array="list" item="7"',
        'array="list" item="_name"',
        'array="list" item="i" index="1 + 1"',
        'array="list" item="list[0]"',
        'array="nowhere" item="i"',
        'array="[" item="i"',
    ],
)
@pytest.mark.parametrize("model", MODELS)
def test_4_6_an_illegal_array_or_item_is_an_error_and_nothing_is_run(
    attributes: str, model: str
) -> None:
    body = state(
        f'<foreach {attributes}><assign location="n" expr="n + 1"/></foreach><raise event="e"/>',
        on("error.execution", "n == 0"),
        '<data id="n" expr="0"/><data id="list" expr="[1, 2]"/>',
    )
    assert ends(body, f'datamodel="{model}"') == "yes"


@pytest.mark.parametrize("model", MODELS)
def test_4_6_foreach_declares_its_variables_and_goes_over_a_copy(model: str) -> None:
    body = state(
        '<foreach array="list" item="each" index="place">'
        '<assign location="list" expr="list2"/>'
        '<assign location="sum" expr="sum + each * (place + 1)"/></foreach>',
        '<transition cond="sum == 14 &amp;&amp; place == 2" target="yes"/>'
        if model == "ecmascript"
        else '<transition cond="sum == 14 and place == 2" target="yes"/>',
        '<data id="list" expr="[1, 2, 3]"/><data id="list2" expr="[9]"/><data id="sum" expr="0"/>',
    )
    assert ends(body, f'datamodel="{model}"') == "yes"


def test_4_6_an_error_ends_the_loop() -> None:
    body = state(
        '<foreach array="[1, 2, 3]" item="i"><assign location="n" expr="n + 1"/>'
        '<assign location="nowhere" expr="1"/></foreach>',
        '<transition cond="n == 1" target="yes"/><transition target="no"/>',
        '<data id="n" expr="0"/>',
    )
    assert ends(body) == "yes"


# -- 5: data ------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
def test_5_3_early_binding_gives_values_at_the_start_late_binding_at_the_first_entry(
    model: str,
) -> None:
    none = {"ecmascript": "undefined", "python": "None"}[model]
    body = (
        '<datamodel><data id="n" expr="1"/></datamodel>'
        '<state id="s"><onentry><log expr="x"/><assign location="n" expr="n + 1"/></onentry>'
        '<transition event="back" target="t"/><transition target="t"/></state>'
        '<state id="t"><datamodel><data id="x" expr="n"/></datamodel>'
        '<onentry><log expr="x"/><assign location="x" expr="x * 10"/></onentry>'
        '<transition cond="x &lt; 50" target="s"/><transition target="yes"/></state>'
    )
    early = run_of(body, f'datamodel="{model}"')
    late = run_of(body, f'datamodel="{model}" binding="late"')
    assert early.logged() == ["1", "1", "10", "10"]
    assert late.logged() == [none, "2", "20", "20"]


def test_5_3_late_binding_is_saved() -> None:
    body = (
        '<state id="s"><datamodel><data id="x" expr="1"/></datamodel>'
        '<onentry><log expr="x"/><assign location="x" expr="x + 1"/></onentry>'
        '<transition event="again" target="s"/></state>'
    )
    run = run_of(body, 'binding="late"')
    again = restore(run.graph, run, save(run.instance))
    again.post("again")
    advance(again, 11.0)
    assert [fields["text"] for what, fields in again.records if what == "log"] == ["2"]


@pytest.mark.parametrize(
    ("text", "cond"),
    [
        ('[1, {"a": 2.5}]', "d[1].a === 2.5 &amp;&amp; d.length === 2"),
        ("21", "d === 21"),
        ("null", "d === null"),
        ('"a  b"', "d === 'a  b'"),
        ("  some\n   words ", "d === 'some words'"),
        ("NaN", "d === 'NaN'"),
        ("1 + 1", "d === '1 + 1'"),
        ("", "d === undefined"),
    ],
)
def test_b_2_1_the_text_of_data_is_json_or_else_a_text(text: str, cond: str) -> None:
    body = (
        f'<datamodel><data id="d">{text}</data></datamodel>'
        f'<state id="s"><transition cond="{cond}" target="yes"/></state>'
    )
    assert ends(body) == "yes"
    if text.strip():
        sent = f'<send event="e"><content>{text}</content></send>'
        body = state(sent, on("e", cond.replace("d", "_event.data", 1).split(" &amp;")[0]))
        assert text == "null" or ends(body) == "yes"


@pytest.mark.parametrize("model", MODELS)
def test_5_3_data_that_have_no_value_are_an_error_and_can_be_assigned_later(model: str) -> None:
    body = state(
        "",
        '<transition event="error.execution" target="t"/>',
        '<data id="d" expr="1 = 1"/>',
    ) + (
        '<state id="t"><onentry><assign location="d" expr="1"/></onentry>'
        '<transition cond="d == 1" target="yes"/></state>'
    )
    assert ends(body, f'datamodel="{model}"') == "yes"


@pytest.mark.parametrize(
    "action",
    [
        '<assign location="nowhere" expr="1"/>',
        '<assign location="nowhere.x" expr="1"/>',
        '<assign location="27" expr="1"/>',
        '<assign location="d" expr="return"/>',
        '<assign location="d" expr="nowhere"/>',
        '<assign location="d.x.y" expr="1"/>',
        '<assign location="_name" expr="1"/>',
        '<assign location="_sessionid" expr="1"/>',
        '<assign location="_event" expr="1"/>',
        '<assign location="_ioprocessors" expr="1"/>',
        '<assign location="_event.data" expr="1"/>',
        "<script>_name = 1</script>",
        "<script>nowhere += 1</script>",
        '<log expr="nowhere"/>',
        '<cancel sendidexpr="nowhere"/>',
    ],
)
@pytest.mark.parametrize("model", MODELS)
def test_5_4_and_5_10_what_cannot_be_assigned_or_evaluated_is_an_error(
    action: str, model: str
) -> None:
    body = state(
        f'{action}<raise event="e"/>', on("error.execution", "_name == 'c'"), '<data id="d"/>'
    )
    assert ends(body, f'name="c" datamodel="{model}"') == "yes"


@pytest.mark.parametrize("model", MODELS)
def test_5_4_any_location_can_be_assigned_and_a_value_may_stand_inside(model: str) -> None:
    body = state(
        '<assign location="d.a" expr="2"/><assign location="d[\'b\']"> [1, 2] </assign>'
        '<assign location="d.b[1]" expr="d.a + 1"/>',
        '<transition cond="d.a + d.b[0] + d.b[1] == 6" target="yes"/>',
        '<data id="d">{"a": 0}</data>',
    )
    assert ends(body, f'datamodel="{model}"') == "yes"


@pytest.mark.parametrize(
    "donedata",
    ['<param name="p" location="x.y"/>', '<param name="p" expr="("/>', '<content expr="return"/>'],
)
def test_5_7_what_has_no_value_in_donedata_is_an_error_first_and_then_left_out(
    donedata: str,
) -> None:
    body = (
        f'<state id="s"><transition event="error.execution" target="t"/>{ANY}'
        '<state id="u"><transition target="f"/></state>'
        f'<final id="f"><donedata>{donedata}</donedata></final></state>'
        f'<state id="t">{on("done.state.s", "_event.data === undefined")}</state>'
    )
    assert ends(body) == "yes"


@pytest.mark.parametrize(
    ("donedata", "cond"),
    [
        ('<param name="p" expr="1"/><param name="q" expr="("/>', "_event.data.p === 1"),
        ("<content expr=\"'foo'\"/>", "_event.data === 'foo'"),
        ("<content>21</content>", "_event.data === 21"),
        ("<content/>", "_event.data === undefined"),
        ("", "_event.data === undefined"),
    ],
)
def test_5_5_donedata_are_the_data_of_the_done_event(donedata: str, cond: str) -> None:
    body = (
        f'<state id="s">{on("done.state.s", cond).replace(ANY, "")}'
        f'<transition event="done" target="no"/><state id="u"><transition target="f"/></state>'
        f'<final id="f"><donedata>{donedata}</donedata></final></state>'
    )
    assert ends(body) == "yes"


def test_5_8_a_script_of_the_document_runs_before_its_first_state() -> None:
    body = (
        "<script>n = m + 1; later = n</script>"
        '<datamodel><data id="m" expr="1"/><data id="n"/></datamodel>'
        '<state id="s"><transition cond="n === 2 &amp;&amp; later === 2" target="yes"/></state>'
    )
    assert ends(body) == "yes"


# -- 5.10: system variables ---------------------------------------------------------------------

FIELDS = ("type", "sendid", "origin", "origintype", "invokeid")


def shown(entry: str, event: str, model: str = "ecmascript") -> dict[str, str]:
    """The fields of the event that an action makes."""
    logs = "".join(f'<log label="{field}" expr="_event.{field}"/>' for field in FIELDS)
    body = state(entry, f'<transition event="{event}">{logs}</transition>')
    found = (line.partition(": ") for line in run_of(body, f'datamodel="{model}"').logged())
    return {name: value for name, _, value in found if value not in ("undefined", "None")}


SENT = {"type": "external", "origin": "#_scxml_1", "origintype": PROCESSOR}


@pytest.mark.parametrize(
    ("entry", "event", "expected"),
    [
        ('<raise event="e"/>', "e", {"type": "internal"}),
        ('<send event="e" target="#_internal"/>', "e", {"type": "internal"}),
        (
            '<send event="e" target="#_internal" id="i"/>',
            "e",
            {"type": "internal", "sendid": "i"},
        ),
        ('<send event="e"/>', "e", SENT),
        ('<send event="e" delay="1s"/>', "e", SENT),
        ('<send event="e" id="mine"/>', "e", {**SENT, "sendid": "mine"}),
        ('<log expr="x"/>', "error", {"type": "platform"}),
        (
            '<send event="e" id="mine" target="x"/>',
            "error.execution",
            {"type": "platform", "sendid": "mine"},
        ),
        (
            '<send event="e" id="mine"><param name="p" expr="("/></send>',
            "error.execution",
            {"type": "platform", "sendid": "mine"},
        ),
        (
            '<send event="e" target="#_parent"/>',
            "error.communication",
            {"type": "platform", "sendid": "send.1"},
        ),
    ],
)
def test_5_10_1_the_fields_of_an_event(entry: str, event: str, expected: dict[str, str]) -> None:
    assert shown(entry, event) == expected
    processor = {"origintype": "scxml"} if "origintype" in expected else {}
    assert shown(entry, event, "python") == {**expected, **processor}


def test_5_10_1_a_done_event_comes_from_the_platform_one_of_the_host_from_outside() -> None:
    body = (
        '<state id="s"><transition event="done.state.s"><log expr="_event.type"/></transition>'
        '<transition event="hello"><log expr="_event.type"/>'
        '<log expr="_event.data.n"/></transition><final id="f"/></state>'
    )
    run = run_of(body)
    run.instance.post("hello", {"n": 3})
    advance(run.instance, 11.0)
    assert run.logged() == ["platform", "external", "3"]


def test_5_10_1_the_id_of_a_failed_send_is_where_idlocation_put_it() -> None:
    body = state(
        '<send event="e" target="nobody" idlocation="d"/>',
        on("error.execution", "d !== undefined &amp;&amp; _event.sendid === d"),
        '<data id="d"/>',
    )
    assert ends(body) == "yes"


def test_5_10_1_an_event_stays_as_it_was_sent() -> None:
    body = state(
        '<send event="e" namelist="d"/><assign location="d[0]" expr="2"/>'
        '<send event="f"><content expr="d"/></send><assign location="d[0]" expr="3"/>',
        '<transition event="e"><log expr="_event.data.d[0]"/></transition>'
        '<transition event="f"><log expr="_event.data[0]"/></transition>',
        '<data id="d" expr="[1]"/>',
    )
    assert run_of(body).logged() == ["1", "2"]


def test_5_10_the_event_is_kept_until_the_next_one_and_unbound_before_the_first() -> None:
    body = (
        '<state id="s"><onentry><log expr="typeof _event"/><raise event="a"/></onentry>'
        '<transition event="a" target="t"/><onexit><log expr="_event.name"/></onexit></state>'
        '<state id="t"><onentry><raise event="b"/><log expr="_event.name"/></onentry></state>'
    )
    assert run_of(body).logged() == ["undefined", "a", "a"]


@pytest.mark.parametrize("name", [PROCESSOR, "scxml"])
def test_5_10_the_processors_have_a_location_that_can_be_sent_to(name: str) -> None:
    body = state(
        f'<send event="e" targetexpr="_ioprocessors[\'{name}\'].location"/>',
        on("e", "_event.origin === '#_scxml_' + _sessionid"),
    )
    assert ends(body) == "yes"


def test_5_10_what_one_session_does_to_its_system_variables_no_other_sees() -> None:
    body = (
        '<datamodel><data id="d" expr="_ioprocessors"/></datamodel><state id="s">'
        '<onentry><assign location="d[\'more\']" expr="1"/></onentry></state>'
    )
    run_of(body)
    other = run_of('<state id="s"/>').instance
    assert other.slots[_slot(other, "_ioprocessors")].keys() == {PROCESSOR, "scxml"}


def _slot(instance: Instance, name: str) -> int:
    return next(data.slot for data in instance.graph.root.data if data.name == name)


# -- 6.2: sending -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("send", "event"),
    [
        ("targetexpr=\"'#_internal'\"", "e"),
        ("targetexpr=\"'#_scxml_' + _sessionid\"", "e"),
        ('target="#_scxml_1"', "e"),
        ('target=""', "e"),
        (f'type="{PROCESSOR}"', "e"),
        ('type="scxml"', "e"),
        ("typeexpr=\"'scxml'\"", "e"),
        ("delayexpr=\"d + 's'\"", "e"),
        ('type="http"', "error.execution"),
        ('typeexpr="27"', "error.execution"),
        ('typeexpr="nowhere"', "error.execution"),
        ('target="nobody"', "error.execution"),
        ('target="http://example.org"', "error.execution"),
        ('targetexpr="27"', "error.execution"),
        ('targetexpr="("', "error.execution"),
        ('target="#_parent"', "error.communication"),
        ('target="#_child"', "error.communication"),
        ('target="#_scxml_2"', "error.communication"),
        ("targetexpr=\"'#_scxml_foo'\"", "error.communication"),
        ('delayexpr="d"', "error.execution"),
        ('delayexpr="nowhere"', "error.execution"),
        ('namelist="nowhere"', "error.execution"),
        ('idlocation="nowhere"', "error.execution"),
        ('target="#_internal" delay="1s"', "error.execution"),
    ],
)
def test_6_2_where_an_event_goes(send: str, event: str) -> None:
    body = state(f'<send event="e" {send}/>', on(event), '<data id="d" expr="2"/>')
    run = run_of(body)
    assert run.instance.paths() == ["yes"]
    assert run.instance.state.delayed == []


def test_6_2_values_are_those_of_the_time_of_sending() -> None:
    body = state(
        '<assign location="d" expr="\'e2\'"/>'
        '<send eventexpr="d" delayexpr="\'1s\'"><param name="p" expr="d"/></send>'
        '<assign location="d" expr="\'e3\'"/>',
        on("e2", "_event.data.p === 'e2' &amp;&amp; d === 'e3'"),
        '<data id="d" expr="\'e1\'"/>',
    )
    assert ends(body) == "yes"


def test_6_2_names_and_params_are_fields_together() -> None:
    body = state(
        '<send event="e" namelist="d"><param name="p" expr="2"/></send>',
        on("e", "_event.data.d + _event.data.p === 3"),
        '<data id="d" expr="1"/>',
    )
    assert ends(body) == "yes"


@pytest.mark.parametrize(
    ("content", "cond"),
    [
        ("<content>foo  bar</content>", "_event.data === 'foo bar'"),
        ("<content>123</content>", "_event.data === 123"),
        ('<content>{"a": [1]}</content>', "_event.data.a[0] === 1"),
        ('<content expr="d + 1"/>', "_event.data === 2"),
        ("", "_event.data === undefined"),
    ],
)
def test_6_2_content_is_the_data_as_a_whole(content: str, cond: str) -> None:
    body = state(f'<send event="e">{content}</send>', on("e", cond), '<data id="d" expr="1"/>')
    assert ends(body) == "yes"


def test_6_2_what_waits_to_be_heard_keeps_its_origin_in_a_save() -> None:
    body = state(
        '<send event="e" id="mine" delay="20s"><content>[null]</content></send>',
        on("e", "_event.sendid === 'mine' &amp;&amp; _event.data[0] === null"),
    )
    run = run_of(body)
    again = restore(run.graph, run, save(run.instance))
    advance(again, 30.0)
    assert again.paths() == ["yes"]


# -- files --------------------------------------------------------------------------------------


def test_5_2_values_and_scripts_come_from_files_beside_the_document(tmp_path: Path) -> None:
    (tmp_path / "d.json").write_text('{"n": [1, 2]}')
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside" / "s.js").write_text("m = d.n[1];\n")
    body = (
        '<script src="inside/s.js"/><datamodel><data id="d" src="file:d.json"/></datamodel>'
        '<state id="s"><transition cond="m === 2" target="yes"/></state>'
    )
    path = tmp_path / "c.scxml"
    path.write_text(document(body))
    root = read_document(path)
    assert sources(root) == [tmp_path / "inside" / "s.js", tmp_path / "d.json"]
    run = Run("", graph=load_document(root, "c"))
    advance(run.instance, 0.0)
    assert run.instance.paths() == ["yes"]
    digest = run.graph.digest
    (tmp_path / "d.json").write_text('{"n": [1, 3]}')
    assert load_document(read_document(path), "c").digest != digest


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("none.json", "unreadable"),
        ("../c.json", "not-supported"),
        ("/etc/hostname", "not-supported"),
        ("file:///etc/hostname", "not-supported"),
        ("https://example.org/d.json", "not-supported"),
        ("latin.txt", "not-text"),
        ("large.txt", "too-large"),
        ("d.xml", "not-supported"),
    ],
)
def test_what_is_no_file_beside_the_document_is_refused(
    source: str, found: str, tmp_path: Path
) -> None:
    (tmp_path / "latin.txt").write_bytes(b"\xe4")
    (tmp_path / "large.txt").write_bytes(b" " * ((1 << 20) + 1))
    (tmp_path / "d.xml").write_text("<a/>")
    path = tmp_path / "c.scxml"
    path.write_text(
        document(f'<datamodel>\n<data id="d" src="{source}"/></datamodel><state id="s"/>')
    )
    with pytest.raises(UserError) as caught:
        load_document(read_document(path, "c.scxml"), "c")
    (fault,) = [fault for fault in caught.value.faults if fault.severity == "error"]
    assert f"{fault.where} {fault.code}" == f"c.scxml:2:19 {found}"


def test_a_value_beside_a_source_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "c.scxml"
    path.write_text(document('<datamodel><data id="d" src="x" expr="1"/></datamodel>'))
    with pytest.raises(UserError) as caught:
        read_document(path)
    assert caught.value.code == "conflicting-values"


# -- B: data models -----------------------------------------------------------------------------


def test_b_1_the_null_data_model_has_conditions_in_and_nothing_else() -> None:
    body = (
        '<parallel id="p"><state id="s"><transition cond="In(u)" target="no"/>'
        '<transition cond="In(\'t\')" target="yes"/></state>'
        '<state id="t"/><state id="u0"><state id="v"/><state id="u"/></state></parallel>'
    )
    assert ends(body, 'datamodel="null"') == "yes"
    with pytest.raises(UserError) as caught:
        run_of(state('<log expr="1"/>', '<transition cond="true"/>'), 'datamodel="null"')
    errors = [fault for fault in caught.value.faults if fault.severity == "error"]
    assert [fault.code for fault in errors] == ["not-supported"] * 2


@pytest.mark.parametrize(
    ("model", "cond", "expected"),
    [
        ("ecmascript", "'3' == 3", "yes"),
        ("python", "'3' == 3", "no"),
        ("ecmascript", "[]", "yes"),
        ("python", "[]", "no"),
        ("ecmascript", "1 &lt; 3 &lt; 2", "yes"),
        ("python", "1 &lt; 3 &lt; 2", "no"),
        ("python", "not not 3", "yes"),
        ("ecmascript", "not not 3", "no"),
        ("ecmascript", "0", "no"),
        ("python", "0", "no"),
    ],
)
def test_b_2_each_data_model_has_its_own_truth(model: str, cond: str, expected: str) -> None:
    body = (
        f'<state id="s"><transition cond="{cond}" target="yes"/><transition target="no"/></state>'
    )
    assert ends(body, f'datamodel="{model}"') == expected


@pytest.mark.parametrize(
    ("model", "expr", "text"),
    [
        ("ecmascript", "[null, true, 2.0, 'a']", ",true,2,a"),
        ("python", "[None, True, 2.0, 'a']", "[None, True, 2.0, 'a']"),
        ("python", "None", "None"),
        ("ecmascript", "null", "null"),
    ],
)
def test_b_2_each_data_model_has_its_own_texts(model: str, expr: str, text: str) -> None:
    assert run_of(state(f'<log expr="{expr}"/>', ""), f'datamodel="{model}"').logged() == [text]


def test_null_and_undefined_are_saved_apart() -> None:
    body = '<datamodel><data id="d" expr="[null, undefined]"/></datamodel><state id="s"/>'
    run = run_of(body)
    saved: Any = save(run.instance)
    again = restore(run.graph, run, saved)
    assert again.slots[_slot(again, "d")] == [NULL, None]


PIECES = [
    "1",
    "0",
    "x",
    "d",
    "'a'",
    '"',
    "null",
    "None",
    "[",
    "]",
    "(",
    ")",
    "{",
    "}",
    ":",
    ",",
    ".",
]
PIECES += [
    "+",
    "-",
    "*",
    "**",
    "/",
    "%",
    "<",
    "==",
    "===",
    "!",
    "not ",
    " and ",
    "&&",
    "?",
    "|",
    "~",
]
PIECES += [
    "typeof ",
    "In(",
    "Math.",
    "_event",
    "\\u00",
    "$",
    " ",
    "if ",
    " else ",
    "=",
    ";",
    "ä",
    "9e9",
]


@given(st.lists(st.sampled_from(PIECES), max_size=30), st.sampled_from(MODELS))
@settings(max_examples=400, deadline=None)
def test_no_expression_does_more_than_fail(pieces: list[str], model: str) -> None:
    text = escape("".join(pieces), {'"': "&quot;"})
    body = (
        f'<datamodel><data id="d" expr="{text}"/></datamodel><state id="s">'
        f'<onentry><assign location="{text}" expr="{text}"/></onentry>'
        f"<onentry><script>{text}</script></onentry>"
        f'<transition cond="{text}" target="yes"/></state>'
    )
    with suppress(UserError):
        run_of(body, f'datamodel="{model}"')
