"""The stopwatch: stages that follow each other, and stages within stages."""

import pytest

from rtcli.rendering import stopwatch
from rtcli.rendering.stopwatch import Stopwatch


class Clock:
    now = 0.0

    def advance(self, seconds):
        self.now += seconds


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(stopwatch.time, "perf_counter", lambda: clock.now)
    return clock


def test_seconds_of_a_stage_that_runs_twice_add_up(clock):
    watch = Stopwatch(clock.now)
    for seconds in (1, 2):
        with watch.stage("trace"):
            clock.advance(seconds)
    assert watch.seconds == {"trace": 3}


def test_seconds_of_an_inner_stage_do_not_count_for_the_outer_one(clock):
    watch = Stopwatch(clock.now)
    with watch.stage("develop"):
        clock.advance(1)
        for _ in range(2):
            with watch.stage("write"):
                clock.advance(4)
        clock.advance(2)
    assert watch.seconds == {"develop": 3, "write": 8}
