"""The limit on the time of a call, by a clock of the test instead of a timer."""

from __future__ import annotations

import signal
import threading
from typing import NoReturn

import pytest

from behaviors import CodeFailed, TookTooLong
from runner.call_limit import GRACE, CallLimit


class Clock:
    """Goes on when it is told to."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


class GivenUp(Exception):
    """Stands for the end of the process."""


def give_up(failure: CodeFailed) -> NoReturn:
    raise GivenUp(str(failure))


def test_a_call_is_ended_when_its_time_is_up() -> None:
    clock = Clock()
    limit = CallLimit(5.0, give_up, clock)
    lasted: list[float] = []

    def endless() -> None:
        for _ in range(100):
            clock.now += 0.25
            lasted.append(clock.now - 100.0)
            limit.look(None)

    with pytest.raises(CodeFailed) as raised:
        limit.calls.run(endless)
    assert raised.value.message == "the call took longer than 5 s (--call-limit)"
    assert lasted[-1] == 5.0


def test_each_call_has_its_own_time_and_between_calls_none_passes() -> None:
    clock = Clock()
    limit = CallLimit(1.0, give_up, clock)

    def some() -> None:
        clock.now += 0.75
        limit.look(None)

    for _ in range(3):
        limit.calls.run(some)
        clock.now += 50.0
        limit.look(None)


def test_one_that_goes_on_all_the_same_is_given_up() -> None:
    clock = Clock()
    limit = CallLimit(5.0, give_up, clock)
    told: list[float] = []

    def stubborn() -> None:
        while True:
            clock.now += 0.25
            try:
                limit.look(None)
            except TookTooLong:
                told.append(clock.now - 100.0)

    with pytest.raises(CodeFailed) as raised:
        limit.calls.run(stubborn)
    assert "GivenUp: the call took longer than 5 s and could not be ended" in str(raised.value)
    assert told == [5.0, 5.25, 5.5, 5.75]
    assert told[-1] < 5.0 + GRACE


def test_one_that_comes_back_late_from_a_library_is_told_to_end_first() -> None:
    clock = Clock()
    limit = CallLimit(5.0, give_up, clock)

    def busy() -> None:
        clock.now += 3600.0
        limit.look(None)

    with pytest.raises(CodeFailed, match=r"took longer than 5 s \(--call-limit\)"):
        limit.calls.run(busy)


def test_without_a_limit_nothing_is_ended() -> None:
    clock = Clock()
    limit = CallLimit(None, give_up, clock)

    def long() -> None:
        clock.now += 1e9
        limit.look(None)

    limit.calls.run(long)


def test_without_an_end_of_the_program_it_is_told_for_ever() -> None:
    clock = Clock()
    limit = CallLimit(5.0, None, clock)
    told = []

    def stubborn() -> None:
        while len(told) < 50:
            clock.now += 1.0
            try:
                limit.look(None)
            except TookTooLong as error:
                told.append(error)

    limit.calls.run(stubborn)
    assert clock.now == 100.0 + 4.0 + 50.0


def test_the_timer_and_its_signal_are_as_before_afterwards() -> None:
    handler, timer = signal.getsignal(signal.SIGALRM), signal.getitimer(signal.ITIMER_REAL)
    with CallLimit(60.0) as limit:
        assert signal.getsignal(signal.SIGALRM) != handler
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        limit.renew()
        assert signal.getitimer(signal.ITIMER_REAL)[1] > 0.0
    assert signal.getsignal(signal.SIGALRM) == handler
    assert signal.getitimer(signal.ITIMER_REAL)[1] == timer[1]


def test_in_another_thread_there_is_no_timer() -> None:
    handlers = []

    def run() -> None:
        with CallLimit(60.0) as limit:
            limit.renew()
            handlers.append(signal.getsignal(signal.SIGALRM))

    handler = signal.getsignal(signal.SIGALRM)
    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert handlers == [handler]


@pytest.mark.slow
def test_the_timer_ends_what_sleeps_and_what_computes() -> None:
    import time

    def sleep() -> None:
        time.sleep(60.0)

    def compute() -> None:
        while True:
            pass

    with CallLimit(0.1) as limit:
        for function in (sleep, compute):
            began = time.monotonic()
            with pytest.raises(CodeFailed, match="took longer than"):
                limit.calls.run(function)
            assert 0.1 <= time.monotonic() - began < 5.0
