"""Trim and reset: what is for a vehicle on the ground."""

from __future__ import annotations

import pytest

from tests.behaviors.flying import Solo


@pytest.mark.parametrize("name", ["trim", "reset"])
def test_it_is_done_on_the_ground(name: str) -> None:
    solo = Solo(name, grounded=True)
    solo.run(1)
    assert solo.word == "done"
    assert solo.vehicle.verbs == [name]
    assert solo.vehicle.position == (0, 0, 0)


@pytest.mark.parametrize(
    ("name", "reason"),
    [("trim", "the motors are running"), ("reset", "the vehicle is in the air")],
)
def test_it_fails_in_the_air(name: str, reason: str) -> None:
    solo = Solo(name)
    solo.run(1)
    assert solo.outcome is not None
    assert (solo.word, solo.outcome.fields) == ("failed", {"reason": f"{name} refused: {reason}"})


@pytest.mark.parametrize(("name", "usual"), [("trim", 10.0), ("reset", 30.0)])
@pytest.mark.parametrize("given", [None, 2.5])
def test_it_waits_for_its_timeout_at_most(name: str, usual: float, given: float | None) -> None:
    solo = Solo(name, {} if given is None else {"timeout": given}, grounded=True)
    solo.vehicle.silent = True
    began = solo.time
    solo.run(60)
    assert solo.outcome is not None and solo.word == "failed"
    reason = solo.outcome.fields["reason"]
    assert reason == f"{name} took too long" or reason.startswith(f"{name} lost")
    assert solo.time - began <= (usual if given is None else given) + 0.1


@pytest.mark.parametrize("name", ["trim", "reset"])
def test_what_it_has_waited_counts_after_an_interruption(name: str) -> None:
    solo = Solo(name, {"timeout": 3.0}, grounded=True, progress={"waited": 2.9})
    solo.vehicle.silent = True
    assert solo.activity.progress() == {"waited": pytest.approx(2.9)}
    solo.run(0.2)
    assert solo.outcome is not None
    assert solo.outcome.fields["reason"] == f"{name} took too long"
