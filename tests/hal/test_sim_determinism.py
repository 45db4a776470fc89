"""Equal seeds and commands: equal flights, bit for bit."""

from __future__ import annotations

import os
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest

from hal.sim import open_session
from hal.vehicle import Hold, Observation, Options, Position, VehicleSpec, Velocity
from tests.hal.engines import ENGINES
from tests.hal.flying import LONG, named, wait
from vencejo.geometry import Point
from worlds.world import Start

ROOT = Path(__file__).parents[2]


def flight(
    seed: int, noise: float = 1.0, looks: int = 1, world: str = "yard", engine: str | None = None
) -> str:
    """The digest of all that two vehicles report in a flight that touches much."""
    digest = sha256()
    options = Options(
        named("cat", "mouse"), world, seed, settings={"noise": noise, "engine": engine}
    )
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


@pytest.mark.parametrize("engine", ENGINES)
def test_the_same_seed_is_the_same_flight(engine: str) -> None:
    assert flight(7, engine=engine) == flight(7, engine=engine)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("world", ["pursuit", "forest:3"])
def test_the_same_world_is_the_same_flight(world: str, engine: str) -> None:
    assert flight(7, world=world, engine=engine) == flight(7, world=world, engine=engine)


def test_looking_often_changes_nothing() -> None:
    assert flight(7) == flight(7, looks=3)


@pytest.mark.parametrize("engine", ENGINES)
def test_another_process_flies_the_same(engine: str) -> None:
    call = f"flight(7, engine={engine!r})"
    program = f"from tests.hal.test_sim_determinism import flight; print({call})"
    ran = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "5"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ran.stdout.strip() == flight(7, engine=engine)


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


@pytest.mark.parametrize("engine", ENGINES)
def test_another_simulation_beside_it_changes_nothing(engine: str) -> None:
    alone = flight(3, engine=engine)
    with open_session(Options(world="yard", settings={"engine": engine})) as session:
        session.wait()
        assert flight(3, engine=engine) == alone


@pytest.mark.parametrize("engine", ENGINES)
def test_another_vehicle_far_away_changes_nothing(engine: str) -> None:
    """Neither its model nor its flight does; hardly anything where the engine, which solves for all
    contacts at once, is asked: in Bullet only on landing.
    """

    def flown(*others: VehicleSpec) -> list[Observation]:
        ours = VehicleSpec("ours", start=Start(Point(0, 0, 0), 0.0))
        settings = {"engine": engine, "noise": 1.0, "wind": "2 m/s@270 deg, turbulence=natural"}
        with open_session(Options((ours, *others), seed=3, settings=settings)) as session:
            for vehicle in session.vehicles.values():
                vehicle.takeoff(1.0)
            seen = wait(session, 5)
            session.vehicles["ours"].command(Velocity(x=2.0), LONG)
            seen += wait(session, 4)
            for vehicle in session.vehicles.values():
                vehicle.land()
            return seen + wait(session, 6)

    far = VehicleSpec("far", "f450", Start(Point(60, 60, 0), 0.0))
    alone, beside = flown(), flown(far)
    if engine == "bullet":
        assert alone[:360] == beside[:360]
    for one, other in zip(alone, beside, strict=True):
        assert one.position == pytest.approx(other.position, abs=1e-3)
