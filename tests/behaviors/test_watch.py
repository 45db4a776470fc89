"""Urgent events from what is observed."""

from __future__ import annotations

import pytest

from behaviors.watch import RECOVERED, Thresholds, Watch
from hal.fake import FakeVehicle
from tests.behaviors.flying import observed

SEEN = observed(FakeVehicle())


def charges(*levels: float, watch: Watch | None = None) -> list[list[str]]:
    """The events of each charge, in order."""
    watch = watch or Watch(Thresholds())
    return [[name for name, _ in watch.events(SEEN._replace(battery=level))] for level in levels]


def test_each_threshold_is_one_event() -> None:
    assert charges(0.5, 0.31, 0.30, 0.29, 0.16, 0.15, 0.1) == [
        [], [], ["battery.low"], [], [], ["battery.critical"], [],
    ]  # fmt: skip


def test_the_more_urgent_of_two_goes_first() -> None:
    assert charges(0.1) == [["battery.critical", "battery.low"]]


def test_a_charge_that_wavers_is_told_once() -> None:
    assert charges(0.30, 0.305, 0.30, 0.31, 0.29) == [["battery.low"], [], [], [], []]
    assert charges(0.30, 0.31 + RECOVERED, 0.30) == [["battery.low"], [], ["battery.low"]]


def test_the_link() -> None:
    watch = Watch(Thresholds(link_lost=2.0))
    ages = [0.0, 1.9, 2.1, 3.0, 0.0, 2.1]
    events = [list(watch.events(SEEN._replace(link_age=age))) for age in ages]
    assert events == [
        [], [], [("link.lost", {"age": 2.1})], [], [("link.restored", {"age": 0.0})],
        [("link.lost", {"age": 2.1})],
    ]  # fmt: skip


def test_thresholds_can_be_set_and_levels_are_told() -> None:
    watch = Watch(Thresholds(battery_low=0.6, battery_critical=0.4))
    assert list(watch.events(SEEN._replace(battery=0.55))) == [
        ("battery.low", {"level": pytest.approx(0.55)})
    ]
