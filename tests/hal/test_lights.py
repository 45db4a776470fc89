"""Lamps: what each pattern shows at a moment, and what it may not be given."""

from __future__ import annotations

import pytest

from hal import Lights
from hal.lights import COLORS, PATTERNS, STANDARD, Rgb
from hal.sim import open_session
from hal.sim.vehicle import SimVehicle
from hal.vehicle import Options
from tests.hal.flying import wait
from vencejo.errors import UserError

GREEN, RED, BLUE, WHITE, OFF = (
    (0, 255, 0),
    (255, 0, 0),
    (0, 80, 255),
    (255, 255, 255),
    (0, 0, 0),
)
USUAL = (GREEN, GREEN, RED, RED)


@pytest.mark.parametrize("elapsed", [0.0, 0.3, 60.0])
@pytest.mark.parametrize(
    ("lights", "shown"),
    [
        (Lights(), USUAL),
        (Lights("standard", "blue"), USUAL),
        (Lights("off", "blue"), (OFF,) * 4),
        (Lights("solid"), (WHITE,) * 4),
        (Lights("solid", "blue"), (BLUE,) * 4),
    ],
)
def test_what_does_not_move_is_always_the_same(
    lights: Lights, shown: tuple[Rgb, ...], elapsed: float
) -> None:
    assert lights.lamps(elapsed) == shown


@pytest.mark.parametrize(
    ("pattern", "quarters"),
    [
        ("blink", [(BLUE,) * 4, (BLUE,) * 4, (OFF,) * 4, (OFF,) * 4]),
        (
            "snake",
            [
                (BLUE, OFF, OFF, OFF),
                (OFF, BLUE, OFF, OFF),
                (OFF, OFF, BLUE, OFF),
                (OFF, OFF, OFF, BLUE),
            ],
        ),
        ("fire", [(BLUE, BLUE, RED, RED)] * 2 + [(OFF, OFF, RED, RED)] * 2),
    ],
)
@pytest.mark.parametrize("rate", [0.5, 1.0, 4.0])
def test_what_moves_goes_through_its_quarters_at_its_rate(
    pattern: str, quarters: list[tuple[Rgb, ...]], rate: float
) -> None:
    lights = Lights(pattern, "blue", rate)  # type: ignore[arg-type]
    for turn in range(3):
        # From the beginning of each quarter to shortly before its end.
        for within in (0.0, 0.5, 0.99):
            times = [(turn + (quarter + within) / 4) / rate for quarter in range(4)]
            assert [lights.lamps(time) for time in times] == quarters


def test_after_their_duration_the_usual_lights_come_back() -> None:
    lights = Lights("solid", "blue", duration=3.0)
    shown = [lights.lamps(time) for time in (0.0, 2.999, 3.0, 99.0)]
    assert shown == [(BLUE,) * 4, (BLUE,) * 4, USUAL, USUAL]


def test_the_usual_lights_are_green_in_front_and_red_behind() -> None:
    assert STANDARD == USUAL
    assert set(PATTERNS) == {"standard", "off", "solid", "blink", "snake", "fire"}
    assert all(Lights("solid", color).lamps(0.0) == (rgb,) * 4 for color, rgb in COLORS.items())


@pytest.mark.parametrize(
    ("given", "message", "hint"),
    [
        ({"pattern": "blnk"}, "there is no pattern of lights 'blnk'", "did you mean 'blink'?"),
        ({"color": "rd"}, "there is no color of lights 'rd'", "did you mean 'red'?"),
        ({"rate": 0.0}, "lights blink 0 to 20 times a second, not 0", None),
        ({"rate": -1.0}, "lights blink 0 to 20 times a second, not -1", None),
        ({"rate": 20.5}, "lights blink 0 to 20 times a second, not 20.5", None),
        ({"rate": float("nan")}, "lights blink 0 to 20 times a second, not nan", None),
        ({"duration": 0.0}, "lights cannot last 0 s", None),
        ({"duration": -2.0}, "lights cannot last -2 s", None),
        ({"duration": float("nan")}, "lights cannot last nan s", None),
    ],
)
def test_what_lamps_cannot_show_is_refused(
    given: dict[str, object], message: str, hint: str | None
) -> None:
    with pytest.raises(UserError) as refused:
        Lights(**given)  # type: ignore[arg-type]
    (fault,) = refused.value.faults
    assert (fault.code, fault.message, fault.hint) == ("bad-lights", message, hint)


def test_the_fastest_rate_may_be_had() -> None:
    assert Lights("blink", "blue", 20.0).lamps(0.03) == (OFF,) * 4


def test_the_simulator_s_lamps_count_from_the_period_that_set_them() -> None:
    with open_session(Options()) as session:
        vehicle = session.vehicles["drone"]
        assert isinstance(vehicle, SimVehicle)
        wait(session, 1.0)
        assert vehicle.lamps(vehicle.observe().time) == USUAL
        order = vehicle.lights(Lights("blink", "blue", rate=2.0, duration=1.0))
        assert vehicle.lamps(vehicle.observe().time) == USUAL
        shown = []
        for _ in range(48):
            session.wait()
            shown.append(vehicle.lamps(vehicle.observe().time))
        assert order.state == "done"
    on, off = (BLUE,) * 4, (OFF,) * 4
    # The first moment is the end of the period in which they were set.
    assert [on, *shown] == [*[on] * 10, *[off] * 10, *[on] * 10, *[off] * 10, *[USUAL] * 9]
