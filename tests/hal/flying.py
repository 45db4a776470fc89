"""Helpers of the flight tests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from hal.engines import open_engine
from hal.orders import Order
from hal.sim import SimSession, open_session
from hal.vehicle import (
    PERIOD,
    Observation,
    Options,
    Position,
    Session,
    Setpoint,
    Vehicle,
    VehicleSpec,
)
from vencejo.geometry import Point
from worlds.world import World

HIGH = Point(0.0, 0.0, 5.0)
LONG = 1000.0
"""Seconds for which a set-point stays valid that a test gives once."""


def named(*names: str) -> tuple[VehicleSpec, ...]:
    """Vehicles of which nothing is asked but their names."""
    return tuple(map(VehicleSpec, names))


def wait(session: Session, seconds: float, setpoint: Setpoint | None = None) -> list[Observation]:
    """Let time pass, with a set-point given anew in each period when there is one; what the first
    vehicle reported.
    """
    vehicle = only(session)
    seen = []
    for _ in range(round(seconds / PERIOD)):
        if setpoint is not None:
            vehicle.command(setpoint)
        session.wait()
        seen.append(vehicle.observe())
    return seen


def wait_until(session: Session, reached: Callable[[], bool], seconds: float) -> None:
    """Let time pass until something is so; fails when it takes too long."""
    for _ in range(round(seconds / PERIOD)):
        if reached():
            return
        session.wait()
    assert reached(), f"not so within {seconds} s: {only(session).observe()}"


def finish(session: Session, order: Order, seconds: float) -> None:
    """Let time pass until an order is done."""
    wait_until(session, lambda: order.ended, seconds)
    assert order.state == "done", order


def decided(session: Session, order: Order) -> Order:
    """The order after the ``wait()`` that decides on it."""
    assert order.state == "sent"
    session.wait()
    return order


def only(session: Session) -> Vehicle:
    return next(iter(session.vehicles.values()))


def take_off(session: Session, altitude: float = 3.0) -> Vehicle:
    """Bring the first vehicle to a hover."""
    vehicle = only(session)
    finish(session, vehicle.takeoff(altitude), 5 + altitude)
    wait(session, 1.5)
    return vehicle


@contextmanager
def hovering(
    at: Point = HIGH, world: str | None = None, **settings: object
) -> Iterator[tuple[SimSession, Vehicle]]:
    """A simulator whose vehicle hovers at a place, settled, heading east."""
    with open_session(Options(world=world, settings=settings)) as session:
        assert isinstance(session, SimSession)
        vehicle = take_off(session, at.z)
        wait(session, 4 + 0.5 * Point(at.x, at.y, 0.0).norm(), Position(at, yaw=0.0))
        yield session, vehicle


def session_of(
    world: World, vehicles: tuple[str, ...] = ("drone",), **settings: object
) -> SimSession:
    """The simulator on a world that is in no file."""
    return SimSession(Options(named(*vehicles), settings=settings), world, open_engine())


def told(seen: Iterable[Observation]) -> list[tuple[str, str]]:
    """The collisions and unstable landings that were reported: event and thing."""
    return [
        (event.name.removeprefix("vehicle."), event.fields["thing"])
        for each in seen
        for event in each.events
    ]
