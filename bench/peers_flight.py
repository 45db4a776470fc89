"""Hover and a square in other simulators; run by bench.flight with a Python that has one of them.

    python peers_flight.py pyflyt|rotorpy

240 physics steps a second, rotors and drag as each has them by default, no pictures, nothing
recorded. Prints JSON: the version, and job → times real time, CPU time, median of three.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import version
from statistics import median
from time import process_time

RATE = 240
ROUNDS = 3
HEIGHT, SIDE, LEG = 2.0, 2.0, 4.0
"""Of the flights, metres; and seconds for each side of the square."""
HOVER = ((0.0, 0.0),) * 4
SQUARE = ((SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE), (0.0, 0.0))
Corners = Sequence[tuple[float, float]]


def pyflyt(corners: Corners) -> Callable[[], None]:
    """A QuadX, told each corner in turn; its position controller flies there."""
    import numpy as np
    from PyFlyt.core import Aviary

    aviary = Aviary(
        start_pos=np.array([[0.0, 0.0, HEIGHT]]),
        start_orn=np.zeros((1, 3)),
        drone_type="quadx",
        physics_hz=RATE,
    )
    aviary.set_mode(7)

    def fly() -> None:
        for x, y in corners:
            aviary.set_setpoint(0, np.array([x, y, 0.0, HEIGHT]))
            due = aviary.physics_steps + LEG * RATE
            while aviary.physics_steps < due:
                aviary.step()
        x, y, z = aviary.state(0)[3]
        assert abs(x) < 0.5 and abs(y) < 0.5 and abs(z - HEIGHT) < 0.5, (x, y, z)

    return fly


def rotorpy(corners: Corners) -> Callable[[], None]:
    """A Crazyflie along a minimum-snap trajectory, with its SE(3) controller."""
    import numpy as np
    from rotorpy.controllers.quadrotor_control import SE3Control
    from rotorpy.environments import Environment
    from rotorpy.trajectories.hover_traj import HoverTraj
    from rotorpy.trajectories.minsnap import MinSnap
    from rotorpy.vehicles.crazyflie_params import quad_params
    from rotorpy.vehicles.multirotor import Multirotor

    start = np.array([0.0, 0.0, HEIGHT])
    if corners is HOVER:
        trajectory = HoverTraj(x0=start)
    else:
        points = np.array([start, *((x, y, HEIGHT) for x, y in corners)])
        trajectory = MinSnap(points, v_avg=SIDE / LEG, verbose=False)
    environment = Environment(
        Multirotor(quad_params), SE3Control(quad_params), trajectory, sim_rate=RATE
    )
    environment.vehicle.initial_state["x"] = start

    def fly() -> None:
        flown = environment.run(t_final=LEG * len(corners))
        x, y, z = flown["state"]["x"][-1]
        assert abs(x) < 0.5 and abs(y) < 0.5 and abs(z - HEIGHT) < 0.5, (x, y, z)

    return fly


PEERS = {"pyflyt": pyflyt, "rotorpy": rotorpy}


def factor(flight: Callable[[], None], seconds: float) -> float:
    began = process_time()
    flight()
    return seconds / (process_time() - began)


if __name__ == "__main__":
    name = sys.argv[1]
    jobs = {"hover": HOVER, "square": SQUARE}
    factors = {
        job: median(factor(PEERS[name](corners), LEG * 4) for _ in range(ROUNDS))
        for job, corners in jobs.items()
    }
    print(json.dumps({"version": version(name), "factors": factors}))
