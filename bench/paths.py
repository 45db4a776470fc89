"""How well paths are flown in the simulator: two tables, or JSON with ``--json``.

- *Over the asked speed*: how much faster than asked for the vehicle is at most, in ``goto``, in a
  ``route`` with corners, and in one with 32 points of a circle, and its mean on that.
- *Figure eight*: x = 2 cos ωt, y = sin 2ωt by ``follow_path``, five laps at some peak speeds: the
  distance of the vehicle from where it is to be at that time, and from the path (the nearest place
  of it), from the moment on at which it is at speed until it slows down at the end.

    python -m bench.paths [--model NAME] [--physics SETTING] [--tilt DEGREES] [--json]

``--tilt`` is the largest tilt, in place of the model's own; ``--physics`` as in ``drone-cli run``.
"""

from __future__ import annotations

import json
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from math import cos, pi, radians, sin
from typing import Any

from behaviors import MissionFrame, Pilot, drone_vocabulary
from bench.machine import machine
from fsm import compile_mission, read_mission_text
from hal import Limits, Observation, Options, Position, VehicleSpec, open_backend
from vencejo.geometry import Point, distance

SPEEDS = (0.5, 1.0, 2.0, 3.0, 5.0)
PEAKS = (1.0, 2.0, 3.0)
LAPS = 5
HEIGHT = 3.0
HERE = Point(0.0, 0.0, 0.0)

MISSION = """
mission: one_path
states:
  takeoff: {{do: takeoff, with: {{altitude: {height}}}, on: {{done: settle}}}}
  settle: {{after: {{2 s: fly}}}}
  fly: {{do: {behavior}, with: {values}, on: {{done: finish, blocked: stray}}}}
  stray: {{type: final, outcome: stray}}
  finish: {{type: final}}
"""


@dataclass(frozen=True)
class Moment:
    """A period of a flight."""

    seen: Observation
    place: Point
    """Where the vehicle is, mission frame."""
    told: Position
    """Where it was to be in this period, mission frame."""


@dataclass(frozen=True)
class Craft:
    """What is flown."""

    model: str | None = None
    """None for the default one."""
    physics: str = "real"
    tilt: float | None = None
    """The largest tilt, degrees; None for the model's own."""


def flown(behavior: str, values: dict[str, Any], craft: Craft) -> Iterator[Moment]:
    """The periods in which a behaviour flies."""
    text = MISSION.format(height=HEIGHT, behavior=behavior, values=json.dumps(values))
    graph = compile_mission(read_mission_text(text, "one_path.yaml"), drone_vocabulary())
    options = Options((VehicleSpec("drone", craft.model),), settings={"physics": craft.physics})
    with open_backend("sim", options) as session:
        (vehicle,) = session.vehicles.values()
        session.wait()
        if craft.tilt is not None:
            vehicle.configure(Limits(max_tilt=radians(craft.tilt)))
        frame = MissionFrame.at_start(vehicle.observe(), session.places, session.geographic)
        pilot = Pilot(graph, vehicle, frame=frame)
        while pilot.outcome is None:
            session.wait()
            pilot.period()
            if pilot.instance.is_active("fly"):
                seen = vehicle.observe()
                told = pilot.channel.setpoint
                assert isinstance(told, Position)
                yield Moment(seen, frame.from_world(seen.position), told)
        if pilot.outcome != "done":
            raise RuntimeError(f"{behavior} ended in {pilot.outcome}: {pilot.reason}")


def over_speed(behavior: str, values: dict[str, Any], craft: Craft) -> dict[str, float]:
    """How fast a behaviour is, beside its speed."""
    asked = values["speed"]
    speeds = [moment.seen.velocity.norm() for moment in flown(behavior, values, craft)]
    middle = speeds[len(speeds) // 4 : -len(speeds) // 4]
    return {
        "over_percent": round(100 * (max(speeds) / asked - 1), 2),
        "mean_m_s": round(sum(middle) / len(middle), 3),
    }


def side(speed: float) -> float:
    """A length on which the vehicle comes to speed, metres."""
    return max(8.0, 6.0 * speed)


def square(speed: float) -> list[list[float]]:
    a = side(speed)
    return [[a, 0, HEIGHT], [a, a, HEIGHT], [0, a, HEIGHT], [0, 0, HEIGHT]]


def ring(speed: float) -> list[list[float]]:
    """32 points of a circle that can be flown at a speed."""
    r = max(4.0, speed * speed)
    angles = [2 * pi * k / 32 for k in range(1, 33)]
    return [[r * sin(a), r * (1 - cos(a)), HEIGHT] for a in angles]


def figure_eight(peak: float, craft: Craft) -> dict[str, float]:
    """The errors of a figure eight at a peak speed, centimetres."""
    values = {
        "shape": "figure_eight", "center": [0, 0, HEIGHT], "length": 4, "width": 2,
        "speed": peak, "laps": LAPS, "heading": "keep",
    }  # fmt: skip
    moments = list(flown("follow_path", values, craft))
    speeds = [(m.told.velocity or HERE).norm() for m in moments]
    # It rests for the last time at the begin of the path.
    begin = max(k for k, speed in enumerate(speeds[: len(speeds) // 2]) if speed < 1e-3)
    fast = [k for k, speed in enumerate(speeds) if speed > 0.98 * max(speeds) and k > begin]
    at_speed = moments[fast[0] : fast[-1] + 1]
    angles = [2 * pi * k / 2000 for k in range(2000)]
    curve = [Point(2 * cos(a), sin(2 * a), HEIGHT) for a in angles]
    in_time = [distance(m.told.xyz, m.place) for m in at_speed]
    beside = [min(distance(m.place, place) for place in curve) for m in at_speed[::4]]
    return {
        "flown_m_s": round(max(m.seen.velocity.norm() for m in at_speed), 3),
        "mean_cm": round(100 * sum(in_time) / len(in_time), 2),
        "max_cm": round(100 * max(in_time), 2),
        "beside_mean_cm": round(100 * sum(beside) / len(beside), 2),
        "beside_max_cm": round(100 * max(beside), 2),
    }


def measure(craft: Craft) -> dict[str, Any]:
    """Fly everything; the figures by job and speed."""
    jobs = {
        "goto": lambda v: {"to": [side(v), 0, HEIGHT]},
        "route": lambda v: {"points": square(v)},
        "route, 32 points of a circle": lambda v: {"points": ring(v)},
    }
    speeds = {
        name: {
            f"{speed:g}": over_speed(name.split(",")[0], {**given(speed), "speed": speed}, craft)
            for speed in SPEEDS
        }
        for name, given in jobs.items()
    }
    return {
        "craft": asdict(craft),
        "over_speed": speeds,
        "figure_eight": {f"{peak:g}": figure_eight(peak, craft) for peak in PEAKS},
    }


def main() -> None:
    given = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    given.add_argument("--model")
    given.add_argument("--physics", default="real")
    given.add_argument("--tilt", type=float)
    given.add_argument("--json", action="store_true")
    arguments = given.parse_args()
    craft = Craft(arguments.model, arguments.physics, arguments.tilt)
    figures = measure(craft)
    if arguments.json:
        print(json.dumps({"machine": machine(), **figures}, indent=2))
        return
    print(machine())
    print(", ".join(f"{name} {value}" for name, value in asdict(craft).items() if value))
    print(f"{'over the speed asked for, %':34}" + "".join(f"{v:>9g} m/s" for v in SPEEDS))
    for name, row in figures["over_speed"].items():
        print(f"  {name:32}" + "".join(f"{each['over_percent']:>+13.1f}" for each in row.values()))
        print(
            f"  {'  mean, m/s':32}" + "".join(f"{each['mean_m_s']:>13.2f}" for each in row.values())
        )
    print("figure eight, cm        flown      in time: mean    max    beside it: mean    max")
    for peak, row in figures["figure_eight"].items():
        print(
            f"  {peak + ' m/s':16}{row['flown_m_s']:>10.2f} m/s{row['mean_cm']:>15.2f}"
            f"{row['max_cm']:>7.2f}{row['beside_mean_cm']:>19.2f}{row['beside_max_cm']:>7.2f}"
        )


if __name__ == "__main__":
    main()
