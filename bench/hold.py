"""Accuracy and speed of the simulator's controller: one table, or JSON with ``--json``.

python -m bench.hold [--json]
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from math import hypot, pi, sqrt
from statistics import median
from time import perf_counter

from bench.machine import machine
from hal.sim import open_session
from hal.vehicle import PERIOD, Hold, Observation, Options, Position, Session, Velocity
from vencejo.geometry import Point, distance, wrap

START = Point(0.0, 0.0, 5.0)
ONCE = 1000.0
"""Validity of a set-point that is given once, seconds."""


def airborne(noise: float = 0.0, seed: int = 0) -> Session:
    """A session with the vehicle hovering at START, settled."""
    session = open_session(Options(seed=seed, settings={"noise": noise}))
    vehicle = session.vehicles["drone"]
    vehicle.takeoff(START.z)
    for _ in range(200):
        session.wait()
    vehicle.command(Position(START, yaw=0.0), ONCE)
    for _ in range(200):
        session.wait()
    return session


def fly(session: Session, seconds: float) -> Iterator[Observation]:
    for _ in range(round(seconds / PERIOD)):
        session.wait()
        yield session.vehicles["drone"].observe()


def rms(values: list[float]) -> float:
    return sqrt(sum(value * value for value in values) / len(values))


def hold(noise: float) -> dict[str, float]:
    """Position errors of a hold of 30 s, millimetres: the worst of three seeds with noise."""
    runs = []
    for seed in range(3 if noise else 1):
        with airborne(noise, seed) as session:
            runs.append([distance(seen.position, START) for seen in fly(session, 30)])
    return {"rms_mm": 1e3 * max(map(rms, runs)), "max_mm": 1e3 * max(map(max, runs))}


def trapezoid(length: float, cruise: float, acceleration: float, t: float) -> tuple[float, float]:
    """Distance and speed at time ``t`` of a trapezoidal (or triangular) velocity profile."""
    cruise = min(cruise, sqrt(length * acceleration))
    ramp, whole = cruise / acceleration, length / cruise + cruise / acceleration
    if t < ramp:
        return acceleration * t * t / 2, acceleration * t
    if t < whole - ramp:
        return cruise * (t - ramp / 2), cruise
    left = max(0.0, whole - t)
    return length - acceleration * left * left / 2, acceleration * left


def track(direction: Point, length: float, cruise: float) -> dict[str, float]:
    """Lag of the vehicle behind a moving set-point along its line, and overshoot, mm."""
    with airborne() as session:
        vehicle, start = session.vehicles["drone"], session.vehicles["drone"].observe().time
        worst_cruise = worst = overshoot = 0.0
        for _ in range(round((length / cruise + cruise / 2 + 4) / PERIOD)):
            way, speed = trapezoid(length, cruise, 2.0, vehicle.observe().time - start)
            place = START.plus((direction.x * way, direction.y * way, direction.z * way))
            velocity = Point(direction.x * speed, direction.y * speed, direction.z * speed)
            vehicle.command(Position(place, velocity, yaw=0.0))
            session.wait()
            seen = vehicle.observe()
            want, at_speed = trapezoid(length, cruise, 2.0, seen.time - start)
            off = seen.position.minus(START)
            flown = off.x * direction.x + off.y * direction.y + off.z * direction.z
            worst = max(worst, abs(want - flown))
            overshoot = max(overshoot, flown - length)
            if at_speed == cruise:
                worst_cruise = max(worst_cruise, abs(want - flown))
    return {
        "cruise_lag_mm": 1e3 * worst_cruise,
        "max_lag_mm": 1e3 * worst,
        "overshoot_mm": 1e3 * overshoot,
    }


def step(to: Point) -> dict[str, float]:
    """The response to a position set-point far away, without feed-forward."""
    with airborne() as session:
        way = to.norm()
        session.vehicles["drone"].command(Position(START.plus(to), yaw=0.0), ONCE)
        fastest = overshoot = arrived = 0.0
        begin = session.vehicles["drone"].observe().time
        for seen in fly(session, way / 1.8 + 10):
            off = seen.position.minus(START)
            along = (off.x * to.x + off.y * to.y + off.z * to.z) / way
            overshoot = max(overshoot, along - way)
            fastest = max(fastest, hypot(seen.velocity.x, seen.velocity.y))
            if distance(off, to) > 0.1:
                arrived = seen.time - begin
    return {"overshoot_mm": 1e3 * overshoot, "fastest_m_s": fastest, "arrived_s": arrived}


def velocity_step() -> dict[str, float]:
    """The response to a velocity set-point of 2 m/s, then to Hold."""
    with airborne() as session:
        vehicle = session.vehicles["drone"]
        begin = vehicle.observe().time
        vehicle.command(Velocity(x=2.0), ONCE)
        settled = fastest = sink = 0.0
        for seen in fly(session, 5):
            fastest = max(fastest, seen.velocity.x)
            sink = max(sink, abs(seen.position.z - START.z))
            if abs(seen.velocity.x - 2) > 0.1:
                settled = seen.time - begin
        vehicle.command(Hold())
        seen = list(fly(session, 5))
        drift = distance(seen[-1].position, seen[-81].position)
    return {
        "settled_s": settled,
        "overshoot_percent": 100 * (fastest / 2 - 1),
        "height_lost_mm": 1e3 * sink,
        "hold_drift_mm": 1e3 * drift,
    }


def yaw_step(angle: float) -> dict[str, float]:
    """The response to a heading set-point, radians."""
    with airborne() as session:
        session.vehicles["drone"].command(Position(START, yaw=angle), ONCE)
        begin = session.vehicles["drone"].observe().time
        overshoot = settled = fastest = 0.0
        for seen in fly(session, 8):
            off = wrap(seen.yaw - angle)
            overshoot = max(overshoot, off if abs(off) < 1 else 0.0)
            fastest = max(fastest, seen.rates.z)
            if abs(off) > pi / 180:
                settled = seen.time - begin
    return {
        "overshoot_deg": overshoot * 180 / pi,
        "settled_s": settled,
        "fastest_rad_s": fastest,
        "final_error_deg": abs(off) * 180 / pi,
    }


def speed() -> dict[str, float]:
    """Wall time of `wait` and `observe`, microseconds per mission period."""
    times = []
    with airborne() as session:
        vehicle = session.vehicles["drone"]
        for k in range(4000):
            place = Point(0.01 * k, 0.0, 5.0)
            begin = perf_counter()
            vehicle.command(Position(place, Point(0.4, 0.0, 0.0)))
            session.wait()
            vehicle.observe()
            times.append(perf_counter() - begin)
    middle = median(times)
    return {"median_us": 1e6 * middle, "times_real_time": PERIOD / middle}


def main() -> None:
    results = {
        "hold 30 s": hold(0.0),
        "hold 30 s, command noise": hold(1.0),
        "track 3 m/s along": track(Point(1.0, 0.0, 0.0), 20.0, 3.0),
        "track 3 m/s oblique": track(Point(-0.6, 0.8, 0.0), 20.0, 3.0),
        "track 1.5 m/s up": track(Point(0.0, 0.0, 1.0), 10.0, 1.5),
        "step 40 m": step(Point(40.0, 0.0, 0.0)),
        "step 2 m": step(Point(0.0, 2.0, 0.0)),
        "step 30 m up": step(Point(0.0, 0.0, 30.0)),
        "velocity 0 to 2 m/s, hold": velocity_step(),
        "yaw 90 deg": yaw_step(pi / 2),
        "yaw 170 deg": yaw_step(170 * pi / 180),
        "speed": speed(),
    }
    if "--json" in sys.argv[1:]:
        print(json.dumps({"machine": machine(), **results}, indent=2))
        return
    print(f"hal.sim; {machine()}")
    for name, figures in results.items():
        shown = "  ".join(f"{key} {value:.3f}" for key, value in figures.items())
        print(f"{name:28}{shown}")


if __name__ == "__main__":
    main()
