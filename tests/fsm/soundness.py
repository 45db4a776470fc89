"""What the safety proof says of random missions, compared with all their flights."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from fsm import prove
from tests.fsm.exhaustive import Flights, TooLargeError
from tests.fsm.random_missions import random_mission


@dataclass(frozen=True)
class Comparison:
    """One mission, what the proof says of it, and what its flights do."""

    seed: int
    codes: tuple[str, ...]
    stays_up: bool | None
    """Whether some flight stays up for ever; None where there are too many flights."""
    handled: bool
    """Whether some state takes the event that must land."""

    @property
    def unsound(self) -> bool:
        return self.stays_up is True and not self.codes

    @property
    def false_alarm(self) -> bool:
        return self.stays_up is False and bool(self.codes)


def compare(seed: int) -> Comparison:
    """Prove and fly one random mission."""
    text, graph = random_mission(seed)
    codes = tuple(sorted({fault.code for fault in prove(graph)}))
    flights = Flights(graph, text)
    try:
        stays_up: bool | None = flights.can_stay_up()
    except TooLargeError:
        stays_up = None
    return Comparison(seed, codes, stays_up, bool(flights.answers))


@dataclass(frozen=True)
class Summary:
    """Many comparisons, counted."""

    missions: int
    too_large: int
    stays_up: int
    sound: int
    """Missions all of whose flights come down, or are landed by the host."""
    sound_and_handled: int
    """Those of them in which some state takes the event."""
    unsound: tuple[int, ...]
    """Seeds of missions that can stay up, and of which the proof says nothing."""
    false_alarms: tuple[int, ...]
    """Seeds of sound missions that are warned of."""
    not_proven: int

    @property
    def alarm_share(self) -> float:
        """The share of the sound missions that is warned of; of those handled, the larger one."""
        return len(self.false_alarms) / max(1, self.sound_and_handled)


def summary(comparisons: Iterable[Comparison]) -> Summary:
    """Count comparisons."""
    found = list(comparisons)
    sound = [each for each in found if each.stays_up is False]
    return Summary(
        missions=len(found),
        too_large=sum(each.stays_up is None for each in found),
        stays_up=sum(each.stays_up is True for each in found),
        sound=len(sound),
        sound_and_handled=sum(each.handled for each in sound),
        unsound=tuple(each.seed for each in found if each.unsound),
        false_alarms=tuple(each.seed for each in found if each.false_alarm),
        not_proven=sum("not-proven" in each.codes for each in found),
    )
