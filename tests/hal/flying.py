"""Helpers of the flight tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from hal.sim import SimSession, open_session
from hal.vehicle import PERIOD, Observation, Options, Order, Position, Session, Vehicle
from vencejo.geometry import Point

HIGH = Point(0.0, 0.0, 5.0)


def wait(session: Session, seconds: float) -> list[Observation]:
    """Let time pass; what the first vehicle reported in each period."""
    vehicle = only(session)
    seen = []
    for _ in range(round(seconds / PERIOD)):
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
        vehicle.command(Position(at, yaw=0.0))
        wait(session, 4 + 0.5 * Point(at.x, at.y, 0.0).norm())
        yield session, vehicle
