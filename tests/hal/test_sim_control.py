"""The accuracy of the controller; its figures are measured by the bench."""

from __future__ import annotations

from math import pi
from random import Random

import pytest

from bench.hold import hold, step, track, velocity_step, yaw_step
from hal.sim import open_session
from hal.vehicle import Hold, Limits, Options, Position, Setpoint, Velocity
from tests.hal.flying import LONG, finish, hovering, take_off, wait
from vencejo.geometry import Point, distance, horizontal_distance, roll_pitch_of


def test_holds_within_a_millimetre() -> None:
    assert hold(0.0)["rms_mm"] <= 1


def test_holds_within_five_centimetres_in_command_noise() -> None:
    assert 1 < hold(1.0)["rms_mm"] <= 50


@pytest.mark.parametrize(
    ("direction", "length", "cruise"),
    [
        (Point(1.0, 0.0, 0.0), 20.0, 3.0),
        (Point(-0.6, 0.8, 0.0), 20.0, 3.0),
        (Point(0.0, 0.0, 1.0), 10.0, 1.5),
        (Point(0.6, 0.0, -0.8), 4.0, 1.0),
    ],
)
def test_follows_a_set_point_that_moves(direction: Point, length: float, cruise: float) -> None:
    figures = track(direction, length, cruise)
    assert figures["cruise_lag_mm"] <= 50
    assert figures["overshoot_mm"] <= 50


@pytest.mark.parametrize("way", [(0, 2, 0), (40, 0, 0), (0, 0, 30), (-25, 25, -3), (0.3, 0, 0)])
def test_goes_any_way_without_overshoot(way: tuple[float, float, float]) -> None:
    figures = step(Point(*way))
    assert figures["overshoot_mm"] <= 300
    assert figures["fastest_m_s"] <= 5.1
    assert figures["arrived_s"] <= 2.5 + max(Point(*way).norm() / 5, abs(way[2]) / 2) + 1.5


def test_takes_up_a_velocity_soon() -> None:
    figures = velocity_step()
    assert figures["settled_s"] <= 1.5
    assert figures["overshoot_percent"] <= 10
    assert figures["height_lost_mm"] <= 10
    assert figures["hold_drift_mm"] <= 1


@pytest.mark.parametrize("degrees", [5, 90, 170])
def test_turns_without_overshoot(degrees: float) -> None:
    figures = yaw_step(degrees * pi / 180)
    assert figures["overshoot_deg"] <= 3
    assert figures["final_error_deg"] <= 0.1
    assert figures["fastest_rad_s"] <= 1.8


def test_stays_where_it_stopped_in_command_noise() -> None:
    with hovering(noise=1.0) as (session, vehicle):
        vehicle.command(Velocity(x=2.0), LONG)
        wait(session, 2)
        vehicle.command(Hold())
        there = wait(session, 3)[-1].position
        for _ in range(40):
            vehicle.command(Hold())
            assert distance(wait(session, 1)[-1].position, there) < 0.1


def test_leans_no_further_than_allowed() -> None:
    with hovering() as (session, vehicle):
        for allowed in (0.35, 0.15):
            vehicle.configure(Limits(max_tilt=allowed))
            vehicle.command(Hold(), LONG)
            wait(session, 3)
            steepest = 0.0
            for speed in (5.0, -5.0):
                vehicle.command(Velocity(x=speed, y=speed), LONG)
                for seen in wait(session, 3):
                    roll, pitch = roll_pitch_of(seen.attitude)
                    steepest = max(steepest, (roll**2 + pitch**2) ** 0.5)
            assert 0.8 * allowed < steepest < allowed + 0.035


def test_keeps_the_heading_when_it_is_not_told_to_turn() -> None:
    with hovering() as (session, vehicle):
        vehicle.command(Velocity(yaw_rate=1.0), LONG)
        wait(session, 1)
        vehicle.command(Velocity(x=3.0), LONG)
        yaw = wait(session, 0.3)[-1].yaw
        seen = wait(session, 4)
        assert all(abs(each.yaw - yaw) < 0.03 for each in seen), "leaning over turns it a little"
        assert abs(seen[-1].yaw - yaw) < 0.01


def test_a_velocity_told_again_and_again_is_one_velocity() -> None:
    with hovering() as (session, vehicle):
        speeds = []
        for _ in range(120):
            vehicle.command(Velocity(x=1.0, frame="heading"), LONG)
            session.wait()
            speeds.append(vehicle.observe().velocity.x)
        assert speeds[-1] == pytest.approx(1.0, abs=0.01)
        assert vehicle.observe().yaw == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_no_commands_make_it_tumble(seed: int) -> None:
    random = Random(seed)

    def anywhere() -> Setpoint:
        def some() -> float:
            return random.uniform(-9, 9)

        targets: list[Setpoint] = [
            Hold(),
            Velocity(some(), some(), some(), "world", some()),
            Velocity(some(), some(), some(), "heading", some()),
            Position(Point(some(), some(), some() + 40), yaw=some()),
            Position(Point(some(), some(), some() + 40), Point(some(), some(), some())),
        ]
        return random.choice(targets)

    with hovering(Point(0.0, 0.0, 30.0)) as (session, vehicle):
        for _ in range(400):
            vehicle.command(anywhere(), LONG)
            for _ in range(random.choice([1, 2, 20])):
                session.wait()
                seen = vehicle.observe()
                roll, pitch = roll_pitch_of(seen.attitude)
                assert abs(roll) < 0.8 and abs(pitch) < 0.8
                assert seen.velocity.norm() < 6
            if seen.position.z < 10:
                vehicle.command(Position(seen.position._replace(z=40.0)), LONG)
                wait(session, 10)
        vehicle.command(Position(Point(1.0, 2.0, 30.0)), LONG)
        assert distance(wait(session, 90)[-1].position, (1, 2, 30)) < 0.01


def test_a_landing_comes_down_where_it_stopped() -> None:
    """Command noise would carry a vehicle that only stands still by a tenth of a metre."""
    for seed in range(3):
        with open_session(Options(seed=seed, settings={"noise": 1.0})) as session:
            vehicle = take_off(session, 12.0)
            wait(session, 3, Velocity(x=2.0))
            order = vehicle.land()
            stopped = wait(session, 3)[-1].position
            finish(session, order, 40)
            assert horizontal_distance(vehicle.observe().position, stopped) < 0.05
