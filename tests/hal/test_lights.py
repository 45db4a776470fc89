"""Lamps of vehicles: patterns, and how they look in pictures."""

from __future__ import annotations

import numpy as np
import pytest

from hal.lights import COLORS, STANDARD, Lights
from hal.sim import SimSession
from hal.sim.bullet import Bullet
from hal.vehicle import Frame, Options
from tests.hal.flying import wait
from vencejo.errors import UserError
from worlds.loader import read_world

RED, OFF = COLORS["red"], (0, 0, 0)


@pytest.mark.parametrize(
    ("lights", "elapsed", "lamps"),
    [
        (Lights(), 7.0, STANDARD),
        (Lights("off"), 1.0, (OFF,) * 4),
        (Lights("solid", "red"), 1.0, (RED,) * 4),
        (Lights("solid", "red", duration=2.0), 1.9, (RED,) * 4),
        (Lights("solid", "red", duration=2.0), 2.0, STANDARD),
        (Lights("blink", "red", 2.0), 0.2, (RED,) * 4),
        (Lights("blink", "red", 2.0), 0.3, (OFF,) * 4),
        (Lights("blink", "red", 2.0), 0.5, (RED,) * 4),
        (Lights("snake", "red"), 0.1, (RED, OFF, OFF, OFF)),
        (Lights("snake", "red"), 0.6, (OFF, OFF, RED, OFF)),
        (Lights("fire", "orange"), 0.2, (COLORS["orange"],) * 2 + (RED,) * 2),
        (Lights("fire", "orange"), 0.7, (OFF,) * 2 + (RED,) * 2),
    ],
)
def test_patterns(lights: Lights, elapsed: float, lamps: tuple[object, ...]) -> None:
    assert lights.lamps(elapsed) == lamps


@pytest.mark.parametrize(
    ("settings", "hint"),
    [
        ({"pattern": "blnik"}, "did you mean 'blink'?"),
        ({"color": "gren"}, "did you mean 'green'?"),
        ({"rate": 0.0}, None),
        ({"rate": 21.0}, None),
        ({"duration": 0.0}, None),
    ],
)
def test_what_lamps_cannot_show_is_refused(settings: dict[str, object], hint: str | None) -> None:
    with pytest.raises(UserError) as refused:
        Lights(**settings)  # type: ignore[arg-type]
    assert (refused.value.code, refused.value.faults[0].hint) == ("bad-lights", hint)


def pixels(frame: Frame, rgb: tuple[int, int, int]) -> int:
    """The number of pixels with nearly that colour."""
    away = np.abs(frame.image.astype(int)[..., ::-1] - rgb).max(-1)
    return int((away < 60).sum())


@pytest.mark.parametrize("renderer", ["raster", "tiny"])
def test_another_vehicle_s_camera_sees_the_lamps(renderer: str) -> None:
    world = read_world("world: test\nstart: [{at: [0, 0]}, {at: [1.2, 0]}]\n", "test.yaml")
    options = Options(("cat", "mouse"), settings={"renderer": renderer})
    with SimSession(options, world, Bullet()) as session:
        cat, mouse = session.vehicles["cat"], session.vehicles["mouse"]

        def seen() -> Frame:
            frame = cat.camera("front").latest()
            assert frame is not None
            return frame

        wait(session, 0.5)
        blue = COLORS["blue"]
        assert pixels(seen(), blue) == 0 and pixels(seen(), RED) > 4, "red behind"
        mouse.lights(Lights("solid", "blue"))
        wait(session, 0.5)
        assert pixels(seen(), blue) > 4 and pixels(seen(), RED) == 0
        mouse.lights(Lights("off"))
        wait(session, 0.5)
        assert pixels(seen(), blue) == pixels(seen(), RED) == 0


def test_lights_that_change_later_do_not_change_an_earlier_picture() -> None:
    world = read_world("world: test\nstart: [{at: [0, 0]}, {at: [1.2, 0]}]\n", "test.yaml")
    options = Options(("cat", "mouse"), settings={"cameras": {"front": {"rate": 1.0}}})
    with SimSession(options, world, Bullet()) as session:
        wait(session, 1.2)
        session.vehicles["mouse"].lights(Lights("solid", "blue"))
        wait(session, 0.3)
        frame = session.vehicles["cat"].camera("front").latest()
        assert frame is not None and frame.time == pytest.approx(1.0)
        assert pixels(frame, COLORS["blue"]) == 0 and pixels(frame, RED) > 4
