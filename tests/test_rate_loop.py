"""A loop at a constant rate: on time, without drift, and honest about what was late."""

from __future__ import annotations

import logging
import time

import pytest

from hqp import InvalidInput
from tasks import loop
from tasks.control.rate_loop import RateLoop


class Clock:
    """A clock that goes on as it is told, and wakes up late."""

    def __init__(self, late: float = 0.0) -> None:
        self.now, self.late = 5.0, late

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds + self.late


def test_ticks_are_due_at_multiples_of_the_period_however_late_the_clock_wakes_up() -> None:
    clock = Clock(late=1e-4)
    begun = []
    for tick in RateLoop(200.0, 1.0, clock, clock.sleep):
        begun.append(clock.now - 5.0 - tick.t)
        clock.now += 1e-3
    assert len(begun) == 200
    assert max(begun) < 2e-4  # delays do not add up


def test_what_takes_too_long_is_counted_and_told(caplog) -> None:
    clock = Clock()
    ours = RateLoop(100.0, 0.1, clock, clock.sleep)
    with caplog.at_level(logging.WARNING, logger="hqp"):
        ticks = []
        for tick in ours:
            ticks.append(tick)
            clock.now += {2: 0.013, 5: 0.0345}.get(tick.k, 0.001)
    assert [tick.k for tick in ticks] == [0, 1, 2, 3, 4, 5, 8, 9]
    assert [round(tick.dt * 100) for tick in ticks] == [1, 1, 1, 1, 1, 1, 3, 1]
    assert sum(tick.dt for tick in ticks) == pytest.approx(0.1)
    assert (ours.overruns, ours.left_out, ours.ticks) == (2, 2, 8)
    assert ours.worst == pytest.approx(0.0245)
    assert [record.getMessage() for record in caplog.records] == [
        "loop at 100 Hz: 2 of 8 ticks took too long, the latest by 24.5 ms; 2 were left out"
    ]


def test_a_loop_that_is_left_tells_too(caplog) -> None:
    clock = Clock()
    with caplog.at_level(logging.WARNING, logger="hqp"):
        for _ in RateLoop(100.0, clock=clock, sleep=clock.sleep):
            clock.now += 0.015
            if clock.now > 5.1:
                break
    assert "took too long" in caplog.text


def test_real_time_goes_on() -> None:
    began = time.perf_counter()
    last = max(tick.k for tick in loop(rate=500.0, duration=0.01))
    assert last <= 4
    assert time.perf_counter() - began >= 0.008


@pytest.mark.parametrize("wrong", [{"rate": 0.0}, {"rate": 200.0, "duration": -1.0}, {"rate": float("nan")}])
def test_rates_and_durations_are_positive(wrong) -> None:
    with pytest.raises(InvalidInput, match="must be positive"):
        loop(**wrong)


def test_a_wait_longer_than_a_clock_takes_is_cut() -> None:
    now, slept = [0.0], list[float]()

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        now[0] += seconds

    ticks = iter(RateLoop(1e-7, clock=lambda: now[0], sleep=sleep))
    assert [next(ticks).k, next(ticks).k] == [0, 1]
    assert now[0] == pytest.approx(1e7)
    assert max(slept) <= 1e6
