"""Urgent events from observations: battery, link, late periods, and the vehicle's own events."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from hal.vehicle import PERIOD, Observation


@dataclass(frozen=True)
class Thresholds:
    """The thresholds at which a run raises urgent events."""

    battery_low: float = 0.30
    """Charge, 0 to 1, at which ``battery.low`` is raised."""
    battery_critical: float = 0.15
    """Charge, 0 to 1, at which ``battery.critical`` is raised."""
    link_lost: float = 3.0
    """Seconds of silence after which ``link.lost`` is raised."""


LATE = 1.5
"""A step of more than this many periods is late."""
RECOVERED = 0.02
"""Hysteresis: the rise above a threshold, 0 to 1, after which a charge can be low again."""


class Watch:
    """Compares each observation with the thresholds and gives one event for each crossing."""

    def __init__(self, thresholds: Thresholds) -> None:
        self.thresholds = thresholds
        self._highest = max(thresholds.battery_low, thresholds.battery_critical)
        """Above this charge nothing is low."""
        self._below: set[str] = set()
        self._lost = False

    def progress(self) -> dict[str, Any]:
        """The thresholds that are crossed at present, as JSON."""
        return {"below": sorted(self._below), "lost": self._lost}

    def go_on(self, progress: Mapping[str, Any]) -> None:
        """Continue from the progress of another watch."""
        self._below, self._lost = set(progress["below"]), progress["lost"]

    def events(
        self, seen: Observation, step: float = PERIOD
    ) -> Iterator[tuple[str, Mapping[str, Any]]]:
        """The events of this period, by name with their fields.

        They are crossings of thresholds, events that the vehicle reports, and ``vehicle.late`` if
        ``step``, the seconds since the last period, was too long.
        """
        if self._below or seen.battery <= self._highest:
            yield from self._crossings(seen.battery)
        lost = seen.link == "gone" or seen.link_age > self.thresholds.link_lost
        if lost != self._lost:
            self._lost = lost
            yield ("link.lost" if lost else "link.restored"), {"age": seen.link_age}
        yield from seen.events
        if step > LATE * PERIOD:
            yield "vehicle.late", {"step": step}

    def _crossings(self, battery: float) -> Iterator[tuple[str, Mapping[str, Any]]]:
        """The thresholds that the charge has just fallen below."""
        limits = self.thresholds
        for name, level in (
            ("battery.critical", limits.battery_critical),
            ("battery.low", limits.battery_low),
        ):
            if battery > level + RECOVERED:
                self._below.discard(name)
            elif battery <= level and name not in self._below:
                self._below.add(name)
                yield name, {"level": battery}
