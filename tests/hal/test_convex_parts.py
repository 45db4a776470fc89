"""Meshes in convex parts, and what vehicles make of them."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from hal.sim.convex_parts import convex_parts
from tests.hal.engines import ENGINES, run, simulation, vehicle
from vencejo.geometry import Point
from worlds.things import UPRIGHT, Mesh, Part, Thing

FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
GATE = [(-2, 0), (-1, 0), (-1, 2), (1, 2), (1, 0), (2, 0), (2, 3), (-2, 3)]
"""The outline of a gate of 4 m by 3 m with a way of 2 m by 2 m through it, counter-clockwise."""
FRONT = [(0, 1, 2), (0, 2, 7), (2, 3, 6), (2, 6, 7), (3, 4, 5), (3, 5, 6)]


def blocks(*places: float) -> Mesh:
    """Cubes of 1 m along x, each apart from the others."""
    vertices = [
        (x + i, j, k) for x in places for i, j, k in product((0.0, 1.0), (0.0, 1.0), (0.0, 1.0))
    ]
    faces = []
    for number in range(len(places)):
        for a, b, c, d in FACES:
            faces += [[8 * number + k for k in (a, b, c)], [8 * number + k for k in (a, c, d)]]
    return Mesh(np.array(vertices), np.array(faces, np.int32))


def gate() -> Mesh:
    """A gate in one piece, 1 m thick along y."""
    count = len(GATE)
    vertices = [(x, y, z) for y in (-0.5, 0.5) for x, z in GATE]
    faces = [*FRONT, *((count + a, count + c, count + b) for a, b, c in FRONT)]
    for k in range(count):
        after = (k + 1) % count
        faces += [(k, count + after, after), (k, count + k, count + after)]
    return Mesh(np.array(vertices), np.array(faces, np.int32))


def test_what_is_convex_is_one_part() -> None:
    (part,) = convex_parts(blocks(0.0))
    assert sorted(map(tuple, part)) == sorted(product((0.0, 1.0), repeat=3))


def test_what_is_apart_is_a_part_of_its_own() -> None:
    parts = convex_parts(blocks(0.0, 3.0, 9.0))
    assert sorted(part[:, 0].min() for part in parts) == [0.0, 3.0, 9.0]
    assert {len(part) for part in parts} == {8}


def test_what_is_flat_gets_some_thickness_downwards() -> None:
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    (part,) = convex_parts(Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32)))
    assert (part[:, 2].min(), part[:, 2].max()) == (-0.01, 0.0)


def test_no_part_of_a_gate_reaches_into_its_way() -> None:
    parts = convex_parts(gate())
    assert 3 <= len(parts) <= 64
    for part in parts:
        low, high = part.min(axis=0), part.max(axis=0)
        # Its hull lies within its bounds.
        assert high[0] <= -0.95 or low[0] >= 0.95 or low[2] >= 1.95, part
    everything = np.concatenate(parts)
    assert everything.min(axis=0) == pytest.approx((-2, -0.5, 0))
    assert everything.max(axis=0) == pytest.approx((2, 0.5, 3))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("x", "begin", "height"), [(0.0, 1.0, 0.0), (0.0, 3.5, 3.0), (1.5, 4, 3)])
def test_one_stands_under_a_gate_and_on_it(
    engine: str, x: float, begin: float, height: float
) -> None:
    part = Part(gate(), Point(0, 0, 0), UPRIGHT, (90, 90, 90))
    thing = Thing("gate", "mesh", Point(0, 0, 0), UPRIGHT, (part,))
    with simulation(engine, thing) as physics:
        body = vehicle(physics, (x, 0, begin))
        run(physics, 2)
        assert body.state()[0][2] == pytest.approx(height + 0.06, abs=0.002)
        assert {touch.name for touch in body.contacts()} == {"gate" if height else ""}
        (down,) = physics.rays([(x, 0.1, 9)], [(x, 0.1, -1)]).distances
        assert down == pytest.approx(6.0, abs=1e-6)
