# ruff: noqa: E501  (tables keep their lines)
"""YAML files as nodes: what is read, and what keeps a file from being read."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vencejo.errors import UserError
from vencejo.nodes import MAX_BYTES, Mapping, Scalar, YamlNode, kind, read_file, read_text


def plain(node: YamlNode) -> Any:
    if isinstance(node, Mapping):
        return {key.text: plain(value) for key, value in node}
    return node.text if isinstance(node, Scalar) else [plain(item) for item in node.items]


def fault(text: str) -> tuple[str, str, str]:
    with pytest.raises(UserError) as raised:
        read_text(text, "f")
    (found,) = raised.value.faults
    return found.code, str(found.where), found.hint or ""


def test_scalars_keep_their_text_and_quoting() -> None:
    root = read_text("a: on\n'b': \"10\"\nc: ~\n010: null\nd:\n", "f")
    assert plain(root) == {"a": "on", "b": "10", "c": "~", "010": "null", "d": ""}
    values = [value for _, value in root]
    assert [value.plain for value in values if isinstance(value, Scalar)] == [
        True,
        False,
        True,
        True,
        True,
    ]
    assert [value.null for value in values if isinstance(value, Scalar)] == [
        False,
        False,
        True,
        True,
        True,
    ]


def test_every_value_and_key_knows_its_place() -> None:
    root = read_text("a: {é: [1, x]}\n\nb:\n  - c: d\n", "f")
    places = []

    def walk(node: YamlNode) -> None:
        places.append((kind(node), str(node.where)))
        if isinstance(node, Mapping):
            for key, value in node:
                places.append((key.text, str(key.where)))
                walk(value)
        elif not isinstance(node, Scalar):
            for item in node.items:
                walk(item)

    walk(root)
    assert places == [
        ("a map", "f:1:1"), ("a", "f:1:1"), ("a map", "f:1:4"), ("é", "f:1:5"), ("a list", "f:1:8"),
        ("'1'", "f:1:9"), ("'x'", "f:1:12"), ("b", "f:3:1"), ("a list", "f:4:3"), ("a map", "f:4:5"),
        ("c", "f:4:5"), ("'d'", "f:4:8"),
    ]  # fmt: skip


def test_anchors_and_merges_are_expanded() -> None:
    root = read_text(
        "base: &b {x: 1, y: 2}\nmore: &m {y: 3, z: 4}\none: *b\ntwo: {y: 9, <<: *b}\nthree: {<<: [*b, *m]}\n",
        "f",
    )
    assert plain(root) == {
        "base": {"x": "1", "y": "2"},
        "more": {"y": "3", "z": "4"},
        "one": {"x": "1", "y": "2"},
        "two": {"y": "9", "x": "1"},
        "three": {"x": "1", "y": "2", "z": "4"},
    }


@pytest.mark.parametrize(
    ("text", "code", "where", "hint"),
    [
        ("", "empty-file", "f:1:1", ""),
        ("# only this\n", "empty-file", "f:1:1", ""),
        ("- a\n- b\n", "not-a-map", "f:1:1", ""),
        ("word", "not-a-map", "f:1:1", ""),
        ("a: 1\nb: 2\na: 3\n", "duplicate-key", "f:3:1", "rename"),
        ("a: {b: 1, 'b': 2}", "duplicate-key", "f:1:11", ""),
        ("a: !mine 3", "custom-tag", "f:1:4", "quotes"),
        ("a: !!str 3", "custom-tag", "f:1:4", ""),
        ("a: !!python/object:os.system {}", "custom-tag", "f:1:4", ""),
        ("a: !armed", "custom-tag", "f:1:4", "not"),
        ("a: *b", "unknown-anchor", "f:1:4", ""),
        ("a: &x {b: *x}", "unknown-anchor", "f:1:11", ""),
        ("a:\n  *: b\n", "bad-yaml", "f:2:4", '"*"'),
        ("a: {*: b}\n", "bad-yaml", "f:1:6", '"*"'),
        ("a: {b: ${c}}\n", "bad-yaml", "f:1:9", "needs quotes"),
        ("a: [1, ${c}]\n", "bad-yaml", "f:1:9", "needs quotes"),
        ("a: found: b\n", "bad-yaml", "f:1:9", "needs quotes"),
        ("a:\n\tb: 1\n", "tab-indent", "f:2:1", "spaces"),
        ("a:\n  b: 1\n \tc: 2\n", "tab-indent", "f:3:2", "spaces"),
        ("a: 1\n---\nb: 2\n", "two-documents", "f:2:1", ""),
        ("{a: 1}: 2", "bad-key", "f:1:1", "quotes"),
        ("a: {<<: 3}", "bad-merge", "f:1:9", ""),
        ("a: 'open\n", "bad-yaml", "f:1:4", "not closed"),
        ('m: {l: "$h}\ns:\n  a: {l: "x"}\n', "bad-yaml", "f:1:8", "not closed in its line"),
        ("a: 'x\nb: it's\n", "bad-yaml", "f:1:4", "not closed in its line"),
        ('a: "x" y\n', "bad-yaml", "f:1:8", "all of it in quotes"),
        ('a: {b: "x" y}\n', "bad-yaml", "f:1:12", "all of it in quotes"),
        ('a: "\\q"\n', "bad-yaml", "f:1:5", "single quotes"),
        ("a: {b: 1\nc: 2\n", "bad-yaml", "f:1:4", "`{` that opens here"),
        ("a: [1, 2\nc: 3\n", "bad-yaml", "f:1:4", "`[` that opens here"),
        ("a: {b: 1}}\n", "bad-yaml", "f:1:10", "`}` is too many"),
        ("a:\n  b: x\n   c: [1, {d: 2}]\n", "bad-yaml", "f:3:5", "indentation"),
        ("a:\n  b: {c: [1]}\n   d: 2\n", "bad-yaml", "f:3:4", "indentation"),
        ("a:\n  b: 1\n c: 2\n", "bad-yaml", "f:3:2", "indentation"),
        ("  a: 1\nb: 2\n", "bad-yaml", "f:2:1", "indentation"),
        ("a: 1\nb\nc: 2\n", "bad-yaml", "f:3:1", "colon"),
        ("a: @b\n", "bad-yaml", "f:1:4", "quotes"),
        ("a: > 3\n", "bad-yaml", "f:1:6", "quotes"),
        ("a: 1\nb: x\x07y\n", "bad-yaml", "f:2:5", '"\\x07"'),
        ("a: \0b\n", "bad-yaml", "f:1:4", "UTF-16"),
        ("a: b\nc: \ud800\n", "not-text", "f:2:4", "surrogate"),
        ("a: " + "[" * 300 + "]" * 300, "too-deep", "f:1:203", ""),
        ("a: [" + "x," * 10_000 + "]", "too-many-nodes", "f:1:19999", ""),
        ("a: " + "x" * MAX_BYTES, "too-large", "f", ""),
    ],
)
def test_fault(text: str, code: str, where: str, hint: str) -> None:
    found = fault(text)
    assert found[:2] == (code, where)
    assert hint in found[2]


def test_an_alias_bomb_is_refused_quickly() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 40)]
    began = time.process_time()
    assert fault("\n".join(lines))[0] == "too-many-nodes"
    assert time.process_time() - began < 1.0


def test_files(tmp_path: Path) -> None:
    good = tmp_path / "good.yaml"
    good.write_bytes(b"\xef\xbb\xbfa: \xc3\xa9\n")
    assert plain(read_file(good)) == {"a": "é"}
    latin = tmp_path / "latin.yaml"
    latin.write_bytes("a: é\nb: caf".encode() + b"\xe9\n")
    utf16 = tmp_path / "utf16.yaml"
    utf16.write_text("a: 1\n", "utf-16")
    utf32 = tmp_path / "utf32.yaml"
    utf32.write_text("a: 1\n", "utf-32")
    windows = tmp_path / "windows.yaml"
    windows.write_bytes("a: “b”\n".encode("cp1252"))
    large = tmp_path / "large.yaml"
    large.write_bytes(b"#" * (MAX_BYTES + 1))
    for path, code, where, hint in (
        (tmp_path / "none.yaml", "no-such-file", "shown", None),
        (tmp_path, "not-a-file", "shown", "name a .yaml file inside it"),
        (latin, "not-text", "shown:2:7", "save it as UTF-8; in Latin-1 this would be 'é'"),
        (utf16, "not-text", "shown:1:1", "save it as UTF-8"),
        (utf32, "not-text", "shown:1:1", "save it as UTF-8"),
        (windows, "not-text", "shown:1:4", "save it as UTF-8; in Windows-1252 this would be '“'"),
        (large, "too-large", "shown", None),
    ):
        with pytest.raises(UserError) as raised:
            read_file(path, "shown")
        (found,) = raised.value.faults
        assert (found.code, str(found.where), found.hint) == (code, where, hint)


YAML = st.lists(
    st.sampled_from(["a", "b", ": ", "- ", "\n", "  ", "{", "}", "[", "]", ",", "&x ", "*x", "<<", "!t ",
                     "'", '"', "#", "|", ">", "? ", "\t", "---", "${", "%", "@", "é"]),
    max_size=30,
).map("".join)  # fmt: skip


@given(st.text() | YAML)
def test_any_text_gives_a_map_or_a_user_error(text: str) -> None:
    try:
        assert isinstance(read_text(text, "f"), Mapping)
    except UserError as error:
        assert str(error)
