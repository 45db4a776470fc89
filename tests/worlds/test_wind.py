"""The wind in world files and on the command line: the same forms, and the same faults."""

from __future__ import annotations

from math import log
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.cli.run_cli import run_cli
from vencejo.errors import UserError
from worlds.loader import read_world
from worlds.wind import read_wind
from worlds.world import Gusts, Wind

LIGHT = 15 * 1852 / 3600


@pytest.mark.parametrize(
    ("text", "wind"),
    [
        ("5 m/s@270 deg", Wind(5.0, 270.0)),
        ("5m/s@270deg", Wind(5.0, 270.0)),
        ("18 km/h@-90", Wind(5.0, -90.0)),
        ("5@270", Wind(5.0, 270.0)),
        ("0@0", Wind(0.0, 0.0)),
        ("none", None),
        ("3m/s@0,gusts=5m/s", Wind(3.0, 0.0, gusts=Gusts(5.0, 5.0, 20.0))),
        ("3@0, turbulence=light", Wind(3.0, 0.0, turbulence=LIGHT)),
        ("3@0, turbulence=natural", Wind(3.0, 0.0, turbulence=3.0)),
        (
            "3@0, roughness=0.1, turbulence=natural",
            Wind(3.0, 0.0, roughness=0.1, turbulence=3.0 * log(60.96) / log(100)),
        ),
        ("3@0, turbulence=4 m/s", Wind(3.0, 0.0, turbulence=4.0)),
        (
            "{speed: 3 m/s, from: 1.5708 rad, height: 2 m, roughness: 3 cm, turbulence: severe, "
            "gusts: {to: 7 m/s, duration: 2 s, every: 10 s}}",
            Wind(3.0, 90.0, 2.0, 0.03, Gusts(7.0, 2.0, 10.0), 3 * LIGHT),
        ),
        (
            "{speed: 0, from: 9, gusts: {to: 7, duration: 2 s, at: [1 s, 3 s]}}",
            Wind(0.0, 9.0, gusts=Gusts(7.0, 2.0, 20.0, (1.0, 3.0))),
        ),
    ],
)
def test_a_wind_reads_alike_on_the_command_line_and_in_a_world(
    text: str, wind: Wind | None
) -> None:
    found = read_wind(text, "--wind")
    written = text if text.startswith("{") else f'"{text}"'
    assert read_world(f"world: w\nwind: {written}\n", "w").wind == found
    if wind is None or found is None:
        assert found == wind
    else:
        assert found.bearing == pytest.approx(wind.bearing, abs=1e-3)
        assert (found.speed, found.height, found.roughness, found.gusts, found.turbulence) == (
            pytest.approx(wind.speed),
            wind.height,
            wind.roughness,
            wind.gusts,
            pytest.approx(wind.turbulence),
        )


def test_a_world_has_no_wind_unless_it_says_so() -> None:
    assert read_world("world: w\n", "w").wind is None


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("5 m/s", ["--wind wrong-type"]),
        ("", ["--wind wrong-type"]),
        ("@270", ["--wind wrong-type"]),
        ("5@", ["--wind wrong-type"]),
        ("5 s@west", ["--wind wrong-dimension", "--wind wrong-type"]),
        ("5@361", ["--wind out-of-range"]),
        ("101@0", ["--wind out-of-range"]),
        ("-1@0", ["--wind out-of-range"]),
        ("5@0,gusty", ["--wind wrong-type"]),
        ("5@0,gust=7", ["--wind unknown-key"]),
        ("5@0,gusts=7,gusts=8", ["--wind duplicate-key"]),
        ("5@0,from=3", ["--wind duplicate-key"]),
        ("5@0,gusts=5", ["--wind bad-gusts"]),
        ("5@0,turbulence=strong", ["--wind wrong-type"]),
        ("5@0,roughness=0", ["--wind bad-size"]),
        ("5@0,roughness=10", ["--wind out-of-range"]),
        ("{speed: 5}", ["--wind:1:1 missing-key"]),
        ("{from: 5}", ["--wind:1:1 missing-key"]),
        ("{speed: 5, from: 3, gusts: {}}", ["--wind:1:28 missing-key"]),
        ("{speed: 5, from: 3, gusts: {to: 6, every: 4 s}}", ["--wind:1:43 bad-gusts"]),
        ("{speed: 5, from: 3, gusts: {to: 6, at: [3, 7]}}", ["--wind:1:40 bad-gusts"]),
        ("{speed: 5, from: 3, gusts: {to: 6, at: [9, 3]}}", ["--wind:1:40 bad-gusts"]),
        ("{speed: 5, from: 3, gusts: {to: 6, at: []}}", ["--wind:1:40 wrong-type"]),
        (
            "{speed: 5, from: 3, gusts: {to: 6, every: 9 s, at: [3]}}",
            ["--wind:1:52 bad-gusts"],
        ),
        ("{speed: 5, from: 3", ["--wind:2:1 bad-yaml"]),
    ],
)
def test_what_is_wrong_is_told_at_its_place(text: str, faults: list[str]) -> None:
    with pytest.raises(UserError) as caught:
        read_wind(text, "--wind")
    assert [f"{fault.where} {fault.code}" for fault in caught.value.faults] == faults


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet="0159.-@,= m/sdegnouturbulcihtfakvy{}:[]'\"\n", max_size=40))
def test_any_text_is_a_wind_or_a_fault(text: str) -> None:
    try:
        wind = read_wind(text, "--wind")
    except UserError as error:
        assert all(fault.message for fault in error.faults)
    else:
        assert wind is None or 0.0 <= wind.speed <= 100.0


def test_the_list_of_worlds_shows_it(tmp_path: Path) -> None:
    file = tmp_path / "w.yaml"
    file.write_text("world: w\nwind: 5 m/s@270 deg, gusts=8 m/s, turbulence=light\n")
    shown = run_cli("worlds", str(file)).out
    assert "wind     5 m/s from 270 deg, gusts to 8 m/s, turbulence of 7.72 m/s" in shown


@pytest.mark.parametrize("command", [("run",), ("check", "--fly", "1")])
def test_a_wrong_wind_of_the_command_line_is_told(command: tuple[str, ...]) -> None:
    result = run_cli(*command, "first_flight", "--wind", "5m/s")
    assert result.code == 2
    assert "'--wind': a wind is needed here, not '5m/s'; write 5 m/s@270 deg" in result.err


def test_a_wrong_turbulence_is_told_with_the_words_there_are() -> None:
    with pytest.raises(UserError) as caught:
        read_wind("5@0,turbulence=lite", "--wind")
    hint = "a speed, or one of natural, light, moderate, severe"
    assert caught.value.faults[0].hint == hint
