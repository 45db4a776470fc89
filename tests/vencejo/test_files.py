from __future__ import annotations

from pathlib import Path

import pytest

from vencejo.errors import UserError, Where
from vencejo.files import file_inside
from vencejo.nodes import Scalar, read_file

PLACE = Where("m.yaml", 3, 8)


def refusal(folder: Path, word: str) -> str:
    with pytest.raises(UserError) as caught:
        file_inside(folder, Scalar(word, PLACE), "what is included")
    (fault,) = caught.value.faults
    assert fault.where == PLACE
    return fault.code


def test_what_lies_inside_is_named_from_the_folder(tmp_path: Path) -> None:
    found = file_inside(tmp_path, Scalar("parts/x.yaml", PLACE), "what is included")
    assert found == tmp_path.resolve() / "parts" / "x.yaml"


def test_what_lies_outside_is_refused(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("/etc/passwd")
    words = ("../x.yaml", "/etc/passwd", "link", "parts/../../x")
    assert {word: refusal(tmp_path, word) for word in words} == dict.fromkeys(
        words, "outside-folder"
    )


@pytest.mark.parametrize("word", ["a\0b.yaml", "x" * 300 + ".yaml", "circle.yaml"])
def test_what_is_no_name_of_a_file_is_refused(tmp_path: Path, word: str) -> None:
    (tmp_path / "circle.yaml").symlink_to("circle.yaml")
    assert refusal(tmp_path, word) == "no-such-file"
    with pytest.raises(UserError) as caught:
        read_file(tmp_path / word, "it")
    assert caught.value.code in ("no-such-file", "unreadable")


def test_a_file_without_end_is_too_large() -> None:
    with pytest.raises(UserError) as caught:
        read_file(Path("/dev/zero"))
    assert caught.value.code == "too-large"
