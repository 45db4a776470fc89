"""Lamps of vehicles in the pictures of others."""

from __future__ import annotations

import numpy as np
import pytest

from hal.engines import open_engine
from hal.lights import COLORS, Lights
from hal.sim import SimSession
from hal.vehicle import Frame, Options
from tests.hal.engines import needs_pybullet
from tests.hal.flying import named, wait
from worlds.loader import read_world

RED = COLORS["red"]


def pixels(frame: Frame, rgb: tuple[int, int, int]) -> int:
    """The number of pixels with nearly that colour."""
    away = np.abs(frame.image.astype(int)[..., ::-1] - rgb).max(-1)
    return int((away < 60).sum())


@pytest.mark.parametrize("renderer", ["raster", pytest.param("tiny", marks=needs_pybullet)])
def test_another_vehicle_s_camera_sees_the_lamps(renderer: str) -> None:
    world = read_world("world: test\nstart: [{at: [0, 0]}, {at: [1.2, 0]}]\n", "test.yaml")
    options = Options(named("cat", "mouse"), settings={"renderer": renderer})
    with SimSession(options, world, open_engine()) as session:
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
    options = Options(named("cat", "mouse"), settings={"cameras": {"front": {"rate": 1.0}}})
    with SimSession(options, world, open_engine()) as session:
        wait(session, 1.2)
        session.vehicles["mouse"].lights(Lights("solid", "blue"))
        wait(session, 0.3)
        frame = session.vehicles["cat"].camera("front").latest()
        assert frame is not None and frame.time == pytest.approx(1.0)
        assert pixels(frame, COLORS["blue"]) == 0 and pixels(frame, RED) > 4
