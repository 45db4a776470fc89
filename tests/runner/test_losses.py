"""The flying loop when vehicles, links and backends fail: every landing is ordered and told."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hal import Limits
from hal.fake import FakeSession
from hal.vehicle import PERIODS_PER_SECOND, Options
from runner import Plan, Recorder, fly, read_run
from tests.runner.test_loop import HOP, LONG, WAIT, two
from vencejo.errors import UserError, VehicleError


class Failing(FakeSession):
    """Fake vehicles to which something happens at 3 s."""

    def __init__(self, options: Options, happens: Callable[[Failing], None]) -> None:
        super().__init__((each.name for each in options.vehicles), options=options)
        self._happens = happens

    def wait(self) -> float:
        if self.periods == 3 * PERIODS_PER_SECOND:
            self._happens(self)
        return super().wait()


def on_fakes(
    monkeypatch: pytest.MonkeyPatch, happens: Callable[[Failing], None] = lambda session: None
) -> list[Failing]:
    """Let flights fly fake vehicles; the sessions that they will have opened."""
    opened: list[Failing] = []

    def opens(name: str, options: Options) -> Failing:
        opened.append(Failing(options, happens))
        return opened[-1]

    monkeypatch.setattr("runner.loop.open_backend", opens)
    return opened


def test_a_vehicle_whose_link_is_gone_does_not_end_the_flight_of_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def leave(session: Failing) -> None:
        session.vehicles["mouse"].gone = True

    opened = on_fakes(monkeypatch, leave)
    recorder = Recorder(tmp_path)
    summary = fly(two(tmp_path, WAIT, LONG), lambda: recorder)
    recorder.write_summary(summary)
    cat, mouse = summary.vehicles["cat"], summary.vehicles["mouse"]
    assert (cat.outcome, cat.failure) == ("given_up", "")
    assert (mouse.outcome, mouse.reason) == ("failed", "nothing handled link.lost")
    assert mouse.failure == (
        "the link to 'mouse' is gone; a landing was ordered, and the vehicle is left to its own "
        "failsafe"
    )
    assert summary.exit_code == 3
    assert 3 < mouse.mission_time < 10
    (session,) = opened
    assert session.vehicles["mouse"].verbs == ["takeoff", "land"]
    run = read_run(tmp_path)
    assert run.summary is not None and run.summary.exit_code == 3
    ended = [
        (each.vehicle, each.kind) for each in run.events if each.kind in ("landing", "outcome")
    ]
    assert ended == [("mouse", "outcome"), ("mouse", "landing"), ("cat", "outcome")]


def test_a_backend_that_fails_ends_the_run_with_all_landings_ordered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(session: Failing) -> None:
        raise VehicleError("no-radio", "the radio is unplugged")

    opened = on_fakes(monkeypatch, fail)
    recorder = Recorder(tmp_path)
    summary = fly(two(tmp_path, LONG, LONG), lambda: recorder)
    recorder.write_summary(summary)
    for name in ("cat", "mouse"):
        flown = summary.vehicles[name]
        assert (flown.outcome, flown.reason) == ("failed", "the radio is unplugged")
        assert flown.failure == "the radio is unplugged"
        assert flown.mission_time == pytest.approx(3.0)
        assert opened[0].vehicles[name].verbs == ["takeoff", "land"]
    assert (summary.exit_code, summary.interrupted) == (3, False)
    run = read_run(tmp_path)
    assert run.missing == ()
    for name in ("cat", "mouse"):
        last = [each for each in run.events if each.vehicle == name][-2:]
        assert [(each.kind, each.time) for each in last] == [
            ("outcome", pytest.approx(3.0)),
            ("landing", pytest.approx(3.0)),
        ]


def test_who_is_down_already_is_not_lost_with_the_backend(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(session: Failing) -> None:
        raise VehicleError("no-radio", "the radio is unplugged")

    on_fakes(monkeypatch, fail)
    summary = fly(two(tmp_path, HOP, LONG))
    cat, mouse = summary.vehicles["cat"], summary.vehicles["mouse"]
    assert (cat.outcome, cat.failure) == ("done", "")
    assert (mouse.outcome, mouse.failure) == ("failed", "the radio is unplugged")


def test_a_limit_of_the_run_that_the_vehicle_refuses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = on_fakes(monkeypatch)
    both = two(tmp_path, HOP, HOP).assignments
    with pytest.raises(UserError) as refused:
        fly(Plan(both, profile="indoor", limits=Limits(min_altitude=5.0)))
    (fault,) = refused.value.faults
    assert (fault.code, str(fault.where)) == ("bad-limit", "--limit")
    assert fault.message == "'cat': 'min_altitude' (5 m) must be below 'max_altitude' (2.5 m)"
    summary = fly(Plan(both, profile="indoor", limits=Limits(max_speed=0.5)))
    assert summary.exit_code == 0
    for vehicle in opened[-1].vehicles.values():
        assert (vehicle.limits.max_altitude, vehicle.limits.max_speed) == (2.5, 0.5)


def test_a_vehicle_that_is_not_heard_keeps_the_flight_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = on_fakes(monkeypatch)

    class Silent(Failing):
        def wait(self) -> float:
            self.vehicles["mouse"].silent = True
            return super().wait()

    def opens(name: str, options: Options) -> Failing:
        opened.append(Silent(options, lambda session: None))
        return opened[-1]

    monkeypatch.setattr("runner.loop.open_backend", opens)
    with pytest.raises(VehicleError, match="nothing was heard of 'mouse' within"):
        fly(two(tmp_path, HOP, HOP), lambda: pytest.fail("there is nothing to record"))
