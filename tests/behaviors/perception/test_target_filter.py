"""The track of a target: its prediction, its gate, and its re-identification."""

from __future__ import annotations

import json
from math import cos, inf, sin
from random import Random

import numpy as np
import pytest

from behaviors.perception.target_filter import REIDENTIFIED, TargetFilter
from vencejo.geometry import Point, distance

PERIOD = 0.05
CLEAR = np.eye(3) * 0.05**2


def line(time: float) -> Point:
    return Point(1 + 1.2 * time, 2 - 0.5 * time, 3 + 0.1 * time)


def tracked(
    track: TargetFilter, seconds: float, start: float = 0.0, noise: float = 0.05, seed: int = 1
) -> float:
    """Show a filter a target on a line with noise; the time after."""
    random = Random(seed)
    steps = round(seconds / PERIOD)
    for k in range(steps):
        time = start + k * PERIOD
        seen = line(time).plus((random.gauss(0, noise), random.gauss(0, noise), 0.0))
        assert track.update(seen, CLEAR, time)
    return start + (steps - 1) * PERIOD


def test_nothing_is_known_before_the_first_sight() -> None:
    track = TargetFilter()
    assert not track.is_known
    assert track.age(5.0) == inf
    assert track.nearest([], 0.0) is None
    assert track.nearest([(line(0), CLEAR), (line(1), CLEAR)], 0.0) == 0


def test_the_velocity_is_the_surer_the_longer_a_target_was_seen() -> None:
    track = TargetFilter(acceleration=0.5)
    track.update(line(0.0), CLEAR, 0.0)
    assert track.speed_deviation == pytest.approx(2.0)
    last = tracked(track, 0.5, PERIOD)
    assert 0.1 < track.speed_deviation < 0.5
    tracked(track, 3.0, last + PERIOD)
    assert track.speed_deviation < 0.12


def test_a_target_on_a_line_is_predicted_through_an_occlusion() -> None:
    track = TargetFilter(acceleration=0.5)
    last = tracked(track, 4.0)
    assert track.velocity == pytest.approx((1.2, -0.5, 0.1), abs=0.12)
    assert track.age(last + 1) == pytest.approx(1.0)
    assert distance(track.position_at(last + 1), line(last + 1)) < 0.15
    assert track.deviation_at(last + 1) > 2 * track.deviation_at(last)


def test_the_filter_is_better_than_what_it_is_told() -> None:
    track, random, errors = TargetFilter(acceleration=1.0), Random(3), []
    for k in range(400):
        time = k * PERIOD
        truth = Point(3 * cos(0.3 * time), 3 * sin(0.3 * time), 2.0)
        seen = truth.plus(tuple(random.gauss(0, 0.1) for _ in range(3)))
        track.update(seen, np.eye(3) * 0.01, time)
        errors.append(distance(track.position_at(time), truth))
    assert np.mean(errors[40:]) < 0.09  # that of what it is told is 0.16


def test_its_uncertainty_is_true_to_its_errors() -> None:
    """The normalised squared error of a target of the model's kind is three on average."""
    squares = []
    for seed in range(60):
        random, track = Random(seed), TargetFilter(acceleration=1.0)
        place, velocity = np.zeros(3), np.array([random.gauss(0, 1) for _ in range(3)])
        for k in range(60):
            seen = place + [random.gauss(0, 0.1) for _ in range(3)]
            if k == 59:
                squares.append(track.distance(seen, np.eye(3) * 0.01, k * PERIOD))
            track.update(seen, np.eye(3) * 0.01, k * PERIOD)
            push = np.array([random.gauss(0, 1.0) for _ in range(3)])
            place, velocity = (
                place + velocity * PERIOD + push * PERIOD**2 / 2,
                velocity + push * PERIOD,
            )
    assert 2.2 < np.mean(squares) < 3.8


def test_what_is_far_from_the_track_is_not_the_target() -> None:
    track = TargetFilter()
    last = tracked(track, 2.0)
    before = track.position_at(last)
    assert not track.update(line(last).plus((5, 0, 0)), CLEAR, last + PERIOD)
    assert track.position_at(last) == before
    near, far = line(last + PERIOD), line(last + PERIOD).plus((4, 4, 0))
    assert track.nearest([(far, CLEAR), (near, CLEAR)], last + PERIOD) == 1
    assert track.nearest([(far, CLEAR)], last + PERIOD) is None


def test_it_is_found_again_elsewhere_when_several_sights_agree() -> None:
    track = TargetFilter()
    last = tracked(track, 2.0)
    elsewhere = Point(9, 9, 9)
    taken = [track.update(elsewhere, CLEAR, last + 1 + k * PERIOD) for k in range(REIDENTIFIED)]
    assert taken == [*[False] * (REIDENTIFIED - 1), True]
    assert distance(track.position_at(last + 1.2), elsewhere) < 0.2


def test_scattered_sights_elsewhere_do_not_take_it_over() -> None:
    track = TargetFilter()
    last = tracked(track, 2.0)
    for k in range(20):
        where = Point(9 + 5 * (k % 3), 9 - 6 * (k % 2), 9)
        assert not track.update(where, CLEAR, last + PERIOD * (k % 2 + 1))


def test_it_goes_on_from_its_progress() -> None:
    track, other = TargetFilter(), TargetFilter()
    last = tracked(track, 1.0)
    other.go_on(json.loads(json.dumps(track.progress())))
    assert other.position_at(last + 0.5) == track.position_at(last + 0.5)
    assert other.velocity == track.velocity
    other.go_on(TargetFilter().progress())
    assert not other.is_known


def test_a_picture_out_of_order_does_not_move_it_back() -> None:
    track = TargetFilter()
    last = tracked(track, 1.0)
    assert track.update(line(last), CLEAR, last - 0.1)
    assert track.time == last
