"""Paths in CSV files."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from behaviors.path_file import MAX_ROWS, PathFile, read_path_file
from vencejo.errors import UserError
from vencejo.geometry import Point


def read(folder: Path, text: str | bytes) -> PathFile:
    path = folder / "path.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_path_file(path, "missions/path.csv")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x,y,z\n0,0,3\n4,1.5,3\n", PathFile((Point(0, 0, 3), Point(4, 1.5, 3)), None, None)),
        (
            "t,x,y,z\n10,0,0,3\n12.5,4,1,3",
            PathFile((Point(0, 0, 3), Point(4, 1, 3)), (0.0, 2.5), None),
        ),
        (
            '\ufeff"yaw", z ,"t",y,x\r\n\r\n "0.5", 3, 0, 1, 2\r\n-1e-1,4,1,1,2\r\n  \r\n',
            PathFile((Point(2, 1, 3), Point(2, 1, 4)), (0.0, 1.0), (0.5, -0.1)),
        ),
    ],
)
def test_a_file_gives_places_times_and_headings(
    text: str, expected: PathFile, tmp_path: Path
) -> None:
    assert read(tmp_path, text) == expected


@pytest.mark.parametrize(
    ("text", "at", "message"),
    [
        ("", "1:1", "the column 'x' is missing"),
        ("0,0,3\n1,1,3\n", "1:1", "there is no column '0' of a path"),
        ("x,y, zed\n0,0,3", "1:6", "there is no column 'zed' of a path"),
        ("x;y;z\n0;0;3", "1:1", "there is no column 'x;y;z' of a path"),
        ("\n t,x,y\n", "2:1", "the column 'z' is missing"),
        ("x,y,z,x\n", "1:7", "the column 'x' stands here twice"),
        ("x,y,z\n", "", "a path has 2 rows or more, not 0"),
        ("x,y,z\n1,2,3\n", "2:1", "a path has 2 rows or more, not 1"),
        ("x,y,z\n1,2,3\n2, 2.x,3\n", "3:4", "'2.x' is no number for 'y'"),
        ("x,y,z\n1,2,3\n2,,3\n", "3:3", "'' is no number for 'y'"),
        ("x,y,z\n1,2,nan\n2,2,3\n", "2:5", "'nan' is no number for 'z'"),
        ("x,y,z\n1,2,1e7\n2,2,3\n", "2:5", "'1e7' is no number for 'z'"),
        ("x,y,z\n1,2,1_0\n2,2,3\n", "2:5", "'1_0' is no number for 'z'"),
        ("x,y,z\n1,2,3\n\n2,5,2,3\n", "4:1", "this row has 4 values, and the file 3 columns"),
        ("x,y,z\n1,2,3\n1\n", "3:1", "this row has 1 value, and the file 3 columns"),
        ("t,x,y,z\n1,1,2,3\n1,2,2,3\n", "3:1", "the times do not grow: 1 s comes after 1 s"),
        ("t,x,y,z\n1,1,2,3\n0,2,2,3\n", "3:1", "the times do not grow: 0 s comes after 1 s"),
        ("x,y,z\n1,2,3\n1,2,3\n", "3:1", "this row is where the one before is"),
        ("t,x,y,z\n0,1,2,3\n90,2,2,3\n", "3:1", "it comes here at 0.011 m/s, and a path is flown"),
        ("x,y,z\n0,0,3\n4,0,3\n1,0,3\n", "3:1", "a smooth path cannot turn back here"),
        ("x,y,z\n1,2,3\n1,2\x00,3\n", "3:", ""),
    ],
)
def test_what_is_wrong_is_told_with_its_place(
    text: str, at: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(UserError) as caught:
        read(tmp_path, text)
    (fault,) = caught.value.faults
    assert fault.code == "wrong-path-file" and fault.message.startswith(message)
    assert str(fault.where).startswith(f"missions/path.csv:{at}".removesuffix(":"))


def test_all_that_is_wrong_is_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(UserError) as caught:
        read(tmp_path, "x,y,z\n1,b,c\n1,2\n1,2,3\n1,2,d\n")
    places = [str(fault.where).partition(":")[2] for fault in caught.value.faults]
    assert places == ["2:3", "2:5", "3:1", "5:5"]


def test_a_file_is_text_of_moderate_size(tmp_path: Path) -> None:
    rows = "".join(f"{k},0,3\n" for k in range(MAX_ROWS))
    assert len(read(tmp_path, f"x,y,z\n{rows}").places) == MAX_ROWS
    for text, code in (
        (f"x,y,z\n{rows}9,9,9\n", "wrong-path-file"),
        ("x,y,z\n" + " " * (1 << 20), "too-large"),
        (b"x,y,z\n\xff,1,1\n", "not-text"),
    ):
        with pytest.raises(UserError) as caught:
            read(tmp_path, text)
        assert caught.value.code == code


@given(text=st.text("xyzt,yaw\n\r\"'0123456789.-e \x00;", max_size=80))
def test_any_text_is_a_path_or_a_fault(text: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    try:
        assert len(read(tmp_path_factory.getbasetemp(), text).places) >= 2
    except UserError as error:
        assert all(fault.where for fault in error.faults)
