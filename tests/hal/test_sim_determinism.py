"""Equal seeds and commands: equal flights, bit for bit."""

from __future__ import annotations

import os
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest

from hal.sim import open_session
from hal.vehicle import Hold, Options, Position, Velocity
from tests.hal.flying import LONG, named
from vencejo.geometry import Point

ROOT = Path(__file__).parents[2]


def flight(seed: int, noise: float = 1.0, looks: int = 1, world: str = "yard") -> str:
    """The digest of all that two vehicles report in a flight that touches much."""
    digest = sha256()
    options = Options(named("cat", "mouse"), world, seed, settings={"noise": noise})
    with open_session(options) as session:
        cat, mouse = session.vehicles["cat"], session.vehicles["mouse"]
        cat.takeoff(2.0)
        for period in range(600):
            if period == 20:
                mouse.takeoff(1.0)
            if period > 120:
                place = Point(0.02 * (period - 120), 0.0, 2.0)
                cat.command(Position(place, Point(0.8, 0.0, 0.0), yaw=0.5), LONG)
            if period == 200:
                mouse.command(Velocity(x=1.5, frame="heading", yaw_rate=0.4), LONG)
            if period == 400:
                mouse.command(Hold())
            if period == 450:
                mouse.return_home()
            session.wait()
            for _ in range(looks):
                seen = [vehicle.observe() for vehicle in session.vehicles.values()]
            digest.update(repr(seen).encode())
    return digest.hexdigest()


def test_the_same_seed_is_the_same_flight() -> None:
    assert flight(7) == flight(7)


@pytest.mark.parametrize("world", ["pursuit", "forest:3"])
def test_the_same_world_is_the_same_flight(world: str) -> None:
    assert flight(7, world=world) == flight(7, world=world)


def test_looking_often_changes_nothing() -> None:
    assert flight(7) == flight(7, looks=3)


def test_another_process_flies_the_same() -> None:
    program = "from tests.hal.test_sim_determinism import flight; print(flight(7))"
    ran = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "5"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ran.stdout.strip() == flight(7)


def test_the_seed_moves_the_noise_and_only_that() -> None:
    assert flight(7) != flight(8)
    assert flight(7, noise=0.0) == flight(8, noise=0.0)


def test_vehicles_have_noise_of_their_own() -> None:
    with open_session(Options(named("a", "b"), settings={"noise": True})) as session:
        for vehicle in session.vehicles.values():
            vehicle.takeoff(3.0)
        for _ in range(200):
            session.wait()
        a, b = (vehicle.observe().position for vehicle in session.vehicles.values())
        assert a.minus(b).plus((2.0, 0.0, 0.0)).norm() > 1e-4


def test_another_simulation_beside_it_changes_nothing() -> None:
    alone = flight(3)
    with open_session(Options(world="yard")) as session:
        session.wait()
        assert flight(3) == alone
