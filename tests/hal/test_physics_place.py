"""Bodies that are taken out of the engine's world and put back, whatever the engine."""

from __future__ import annotations

import pytest

from tests.hal.engines import ENGINES, WEIGHT, box, run, simulation, vehicle
from vencejo.geometry import Point, yaw_quaternion
from worlds.things import UPRIGHT, Motion


@pytest.mark.parametrize("engine", ENGINES)
def test_a_withdrawn_body_stays_where_it_is_and_is_touched_by_nothing(engine: str) -> None:
    through = (Point(-2, 0, 0.5), Point(6, 0, 0.5))
    cart = box("cart", through[0], Point(1, 1, 1), motion=Motion(through, 1.0, False, False))
    with simulation(engine, cart) as physics:
        above, below = vehicle(physics, (0, 0, 0.7)), vehicle(physics, (0, 0, 0.06), name="other")
        below.withdraw()
        before = below.state()
        for _ in range(5 * 240):
            physics.step()
            assert below.contacts() == ()
        assert below.state()[0] == pytest.approx(before[0], abs=1e-9)
        assert above.state()[0][2] == pytest.approx(0.06, abs=0.01), "it falls through the other"


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("seconds", [0.0, 1.0])
def test_a_body_goes_on_from_where_it_is_placed(engine: str, seconds: float) -> None:
    state = ((1.0, 2.0, 3.0), yaw_quaternion(0.5), (0.4, -0.2, 1.0), (0.0, 0.0, 0.7))
    with simulation(engine) as physics:
        body = vehicle(physics, (0, 0, 0.06))
        run(physics, 0.05)
        body.withdraw()
        run(physics, seconds)
        body.place(state)
        placed = body.state()
        for value, expected in zip(placed, state, strict=True):
            assert value == pytest.approx(expected, abs=1e-12)
        physics.step()
        (x, y, z), _, (u, v, w), turning = body.state()
        assert (x, y, z) == pytest.approx((1 + 0.4 / 240, 2 - 0.2 / 240, 3 + w / 240), abs=1e-6)
        assert (u, v, w) == pytest.approx((0.4, -0.2, 1 - 9.80665 / 240), abs=1e-6)
        assert turning == pytest.approx((0.0, 0.0, 0.7), abs=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_placed_body_hits_and_rests_again(engine: str) -> None:
    with simulation(engine) as physics:
        body = vehicle(physics, (0, 0, 5))
        body.withdraw()
        body.place(((0, 0, 0.3), UPRIGHT, (0, 0, 0), (0, 0, 0)))
        run(physics, 2)
        assert body.state()[0][2] == pytest.approx(0.06, abs=0.005)
        assert body.contacts()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_force_and_a_torque_act_along_the_bodys_own_axes(engine: str) -> None:
    with simulation(engine) as physics:
        body = vehicle(physics, (0, 0, 5), yaw_quaternion(0.5 * 3.141592653589793))
        body.push((0.436, 0.0, WEIGHT), (0.0, 0.0, 4.8e-3))
        physics.step()
        _, _, velocity, turning = body.state()
        assert velocity == pytest.approx((0.0, 1 / 240, 0.0), abs=1e-6)
        assert turning == pytest.approx((0.0, 0.0, 1 / 240), abs=1e-6)
