"""200 seeded gotos through graph, pilot and simulator: one table, or JSON with ``--json``.

Each flight hovers, flies ``goto`` at its default parameters to a random point 0.5 to 40 m away
with a random change of heading, under command noise, and is watched for 2 s after ``done``. What
counts, each for itself:

- *in time*: from entering the state to its ``done``, the dwell included, within the distance over
  the speed and 6 s;
- *stays there*: in every period from the one in which the graph hears ``done`` until 2 s later,
  while no behaviour flies, its true place and heading are within the tolerances;
- *no overshoot*: from the start to the end of the watch it is nowhere further along the line of
  flight than 0.3 m past the target.

    python -m bench.gotos [--json]
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from math import cos, inf, pi, sin
from time import perf_counter

from behaviors import MissionFrame, Pilot, drone_vocabulary
from behaviors.goto import GoTo
from bench.machine import machine
from fsm import compile_mission, read_mission_text
from hal import Options, open_backend
from vencejo.geometry import Point, distance, wrap
from vencejo.seeds import generator

FLIGHTS = 200
NOISE = 1.0
SPEED, TOLERANCE, YAW_TOLERANCE = (
    GoTo.Params.speed,
    GoTo.Params.tolerance,
    GoTo.Params.yaw_tolerance,
)
SPARE_TIME, WATCHED, PAST_TARGET = 6.0, 2.0, 0.3
LOWEST = 2.0
"""Lowest height of all flights, metres above ground."""

MISSION = """
mission: one_goto
parameters:
  start: 2 m
  to: {type: point, default: [0, 0, 2]}
  heading: {type: angle, default: 0}
states:
  takeoff: {do: takeoff, with: {altitude: $start}, on: {done: settle}}
  settle: {after: {2 s: fly}}
  fly: {do: goto, with: {to: $to, heading: $heading}, on: {done: stay, blocked: stray}}
  stay: {after: {10 s: finish}}
  stray: {type: final, outcome: stray}
  finish: {type: final}
"""
GRAPH = compile_mission(read_mission_text(MISSION, "one_goto.yaml"), drone_vocabulary())


@dataclass(frozen=True)
class MeasuredGoto:
    """The measurements of one goto."""

    length: float
    spare: float
    """Time left of the time allowed, seconds."""
    off: float
    """Largest distance from the target after ``done``, metres."""
    yaw_off: float
    """Largest error of the heading after ``done``, radians."""
    past: float
    """Overshoot along the line of flight, metres; negative when the target is not reached."""


def fly(seed: int) -> MeasuredGoto:
    """Fly the goto of a seed; its length and direction are uniformly distributed."""
    draw = generator(seed, "bench", "gotos")
    length, heading = draw.uniform(0.5, 40.0), draw.uniform(-pi, pi)
    around, rise = draw.uniform(-pi, pi), draw.uniform(-1.0, 1.0)
    flat = (1 - rise * rise) ** 0.5
    ray = Point(flat * cos(around), flat * sin(around), rise)
    height = LOWEST + max(0.0, -length * rise)
    target = Point(length * ray.x, length * ray.y, height + length * ray.z)
    with open_backend("sim", Options(seed=seed, settings={"noise": NOISE})) as session:
        (vehicle,) = session.vehicles.values()
        session.wait()
        frame = MissionFrame(vehicle.observe().position, session.places, session.geographic)
        parameters = {"start": height, "to": target, "heading": heading}
        pilot = Pilot(GRAPH, vehicle, parameters, frame=frame, seed=seed)
        while not pilot.instance.is_active("fly"):
            session.wait()
            pilot.period()
        seen = pilot.channel.observation
        # Command noise has moved the vehicle a little: measure from its true position.
        began, length = seen.time, distance(seen.position, target)
        ray = Point(*(part / length for part in target.minus(seen.position)))
        ended, off, yaw_off, past = inf, 0.0, 0.0, -length
        while pilot.outcome is None and seen.time < ended + WATCHED:
            session.wait()
            # Observed before the pilot acts, so that the period of `done` counts too.
            seen = vehicle.observe()
            pilot.period()
            left = target.minus(frame.from_world(seen.position))
            past = max(past, -(left.x * ray.x + left.y * ray.y + left.z * ray.z))
            if ended == inf and not pilot.instance.is_active("fly"):
                ended = seen.time
            if ended < inf:
                off, yaw_off = max(off, left.norm()), max(yaw_off, abs(wrap(seen.yaw - heading)))
    if ended == inf or pilot.outcome is not None:
        return MeasuredGoto(length, -inf, inf, inf, past)
    return MeasuredGoto(length, length / SPEED + SPARE_TIME - (ended - began), off, yaw_off, past)


def measure(flights: int = FLIGHTS) -> dict[str, object]:
    """Fly all gotos; the results by name."""
    began = perf_counter()
    flown = [fly(seed) for seed in range(flights)]
    wall = perf_counter() - began
    return {
        "flights": flights,
        "seeds": f"0 to {flights - 1}",
        "noise": NOISE,
        "speed_m_s": SPEED,
        "in_time": sum(f.spare >= 0 for f in flown),
        "least_spare_s": round(min(f.spare for f in flown), 3),
        "stays_there": sum(f.off <= TOLERANCE and f.yaw_off <= YAW_TOLERANCE for f in flown),
        "max_off_m": round(max(f.off for f in flown), 4),
        "max_yaw_off_rad": round(max(f.yaw_off for f in flown), 4),
        "no_overshoot": sum(f.past <= PAST_TARGET for f in flown),
        "max_past_m": round(max(f.past for f in flown), 4),
        "length_m": [round(pick(f.length for f in flown), 2) for pick in (min, max)],
        "wall_s": round(wall, 1),
    }


def main() -> None:
    figures = measure()
    if "--json" in sys.argv[1:]:
        print(json.dumps({"machine": machine(), **figures}, indent=2))
        return
    print(machine())
    print(f"{FLIGHTS} gotos at {SPEED:g} m/s, command noise {NOISE:g}, seeds {figures['seeds']}")
    rows = [
        ("in time", "in_time", f"done within distance / speed + {SPARE_TIME:g} s, dwell included",
         f"least spare {figures['least_spare_s']} s"),
        ("stays there", "stays_there",
         f"{TOLERANCE:g} m, {YAW_TOLERANCE:g} rad, every period for {WATCHED:g} s after done",
         f"at most {figures['max_off_m']} m, {figures['max_yaw_off_rad']} rad"),
        ("no overshoot", "no_overshoot", f"{PAST_TARGET:g} m along the line, all the time watched",
         f"at most {figures['max_past_m']} m"),
    ]  # fmt: skip
    for name, key, meaning, worst in rows:
        print(f"{name:14}{figures[key]:>4} of {figures['flights']}   {worst:36}{meaning}")
    print(f"lengths {figures['length_m'][0]} to {figures['length_m'][1]} m, {figures['wall_s']} s")


if __name__ == "__main__":
    main()
