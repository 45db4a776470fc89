from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from vencejo.errors import UserError, Where
from vencejo.files import file_inside, whole_folder, write_whole
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


# -- files that are written whole or not at all ----------------------------------------------------


def full(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that takes half of what is written, and then no more."""
    for name in ("write_bytes", "write_text"):
        whole = getattr(Path, name)

        def half(path: Path, data: Any, *more: str, whole: Any = whole) -> int:
            whole(path, data[: len(data) // 2], *more)
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr(Path, name, half)


def test_a_file_that_cannot_be_written_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = tmp_path / "old.txt"
    old.write_bytes(b"old")
    full(monkeypatch)
    for path in (old, tmp_path / "new.txt"):
        with pytest.raises(OSError, match="No space"):
            write_whole(path, b"new text")
    assert [path.name for path in tmp_path.iterdir()] == ["old.txt"]
    assert old.read_bytes() == b"old"


def test_a_file_is_written_where_its_link_leads_and_keeps_its_mode(tmp_path: Path) -> None:
    (tmp_path / "real.txt").write_bytes(b"old")
    (tmp_path / "real.txt").chmod(0o600)
    (tmp_path / "link.txt").symlink_to("real.txt")
    write_whole(tmp_path / "link.txt", b"new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "real.txt").read_bytes() == b"new"
    assert (tmp_path / "real.txt").stat().st_mode & 0o777 == 0o600


def test_devices_are_written_and_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(os.devnull)
    for path in (Path(os.devnull), tmp_path / "link"):
        write_whole(path, b"x")
        assert path.is_char_device()
    with pytest.raises(OSError, match="No space"):
        write_whole(Path("/dev/full"), b"x")
    assert Path("/dev/full").is_char_device()
    (tmp_path / "circle").symlink_to("circle")
    write_whole(tmp_path / "circle", b"x")
    assert (tmp_path / "circle").read_bytes() == b"x"


def test_a_folder_is_whole_or_is_not_there(tmp_path: Path) -> None:
    def write(name: str, error: BaseException | None = None) -> None:
        with whole_folder(tmp_path / name) as folder:
            (folder / "a.txt").write_text("a")
            if error:
                raise error

    write("good")
    assert (tmp_path / "good" / "a.txt").read_text() == "a"
    for error in (OSError("full"), KeyboardInterrupt()):
        with pytest.raises(type(error)):
            write("bad", error)
    with pytest.raises(OSError, match=r"exist|empty"):
        write("good")
    assert [path.name for path in tmp_path.iterdir()] == ["good"]
