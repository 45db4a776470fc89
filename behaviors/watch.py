"""Events of the vehicle: what its observations say that a mission must not miss."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from hal.vehicle import PERIOD, Observation


@dataclass(frozen=True)
class Thresholds:
    """When a run raises its urgent events."""

    battery_low: float = 0.30
    """Charge (0 to 1) of the advice ``battery.low``."""
    battery_critical: float = 0.15
    """Charge of ``battery.critical``."""
    link_lost: float = 3.0
    """Seconds of silence of ``link.lost``."""


LATE = 1.5
"""Periods after which the next one is late."""
RECOVERED = 0.02
"""How far above its threshold a charge must rise before it can be low again: estimates waver."""


class Watch:
    """Compares each observation with the thresholds; every crossing is one event."""

    def __init__(self, thresholds: Thresholds) -> None:
        self.thresholds = thresholds
        self._highest = max(thresholds.battery_low, thresholds.battery_critical)
        """Above this charge nothing is low."""
        self._below: set[str] = set()
        self._lost = False

    def progress(self) -> dict[str, Any]:
        """What it has said already, as JSON."""
        return {"below": sorted(self._below), "lost": self._lost}

    def go_on(self, progress: Mapping[str, Any]) -> None:
        """Go on where another watch had come to."""
        self._below, self._lost = set(progress["below"]), progress["lost"]

    def events(
        self, seen: Observation, step: float = PERIOD
    ) -> Iterator[tuple[str, Mapping[str, Any]]]:
        """The events of this period, which came ``step`` seconds after the last: crossings of
        thresholds, what the vehicle tells by itself, and whether the period was late.
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
