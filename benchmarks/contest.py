"""Time contestants in turn: rtcli, povray, mitsuba, rtcli, povray, mitsuba, ...

A disturbance of the machine then affects all of them alike, and medians ignore it.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

# The stages to compare: a whole process, or stages that a program times itself.
PROCESS = "whole process"
TRACE = "trace"
BUILD = "build"
TRACE_DEVELOP = "trace + develop"
READ = "read"

Seconds = dict[str, float]


@dataclass(frozen=True)
class Contestant:
    """A command to time.

    Parameters
    ----------
    name
        Unique in its contest.
    command
        Program and arguments. It may print the seconds of its stages as JSON; see `reported_seconds`.
    environment
        Environment variables that it needs.
    once
        Whether to run it only once, without a warm-up, because it takes so long.
    """

    name: str
    command: tuple[str, ...]
    environment: dict[str, str] = field(default_factory=dict)
    once: bool = False

    def run(self) -> Seconds:
        """Run once, and return the seconds of the process and of the stages that it reports.

        Raises
        ------
        SystemExit
            If it failed; the message holds its output.
        """
        environment = {**_neutral_environment(), **self.environment}
        start = time.perf_counter()
        done = subprocess.run(self.command, capture_output=True, env=environment, check=False)
        process = time.perf_counter() - start
        if done.returncode != 0:
            output = done.stderr.decode(errors="replace")[-2000:]
            sys.exit(f"{self.name} failed with exit code {done.returncode}: {' '.join(self.command)}\n{output}")
        return {PROCESS: process, **reported_seconds(done.stdout)}


@dataclass(frozen=True)
class Contest:
    """Contestants that do the same work.

    Parameters
    ----------
    name
        The name for `--only`.
    work
        A description of the work.
    contestants
        The contestants, in the order of their turns.
    timed
        The stages to compare.
    pixels
        The number of pixels in the picture, to report pixels per second.
    """

    name: str
    work: str
    contestants: tuple[Contestant, ...]
    timed: tuple[str, ...] = (PROCESS,)
    pixels: int | None = None

    def hold(self, rounds: int) -> dict[str, Any]:
        """Run all in turn, and return the `summary` of each; a first round only warms up."""
        runs: dict[str, list[Seconds]] = {contestant.name: [] for contestant in self.contestants}
        for contestant in self._turns(rounds):
            runs[contestant.name].append(contestant.run())
        warm_up_runs = {contestant.name: 0 if contestant.once else 1 for contestant in self.contestants}
        counted = {name: runs[name][skipped:] for name, skipped in warm_up_runs.items()}
        seconds = {name: summary(counted_runs) for name, counted_runs in counted.items()}
        return {"work": self.work, "timed": list(self.timed), "pixels": self.pixels, "seconds": seconds}

    def _turns(self, rounds: int) -> Iterator[Contestant]:
        for turn in range(rounds + 1):
            for contestant in self.contestants:
                if turn == 0 or not contestant.once:
                    yield contestant


def reported_seconds(output: bytes) -> Seconds:
    """Return the seconds of stages that a program prints as JSON; none if it prints something else.

    rtcli's `--stats` lists them under `seconds`; `brute_force.c` prints them at the top level.
    """
    try:
        report = json.loads(output)
    except ValueError:
        return {}
    seconds = report.get("seconds", report)
    return {stage: value for stage, value in seconds.items() if isinstance(value, float)}


def summary(runs: list[Seconds]) -> dict[str, dict[str, float]]:
    """Return the median, minimum and maximum of each stage over the runs.

    `trace + develop` is added if both are reported, since its median is not the sum of theirs.
    """
    stages = {stage: [run[stage] for run in runs] for stage in runs[0]}
    if {"trace", "develop"} <= stages.keys():
        stages[TRACE_DEVELOP] = [run["trace"] + run["develop"] for run in runs]
    return {stage: _spread(values) for stage, values in stages.items()}


def _spread(values: list[float]) -> dict[str, float]:
    spread = {"median": statistics.median(values), "least": min(values), "most": max(values)}
    return {name: round(value, 6) for name, value in spread.items()}


def _neutral_environment() -> dict[str, str]:
    """Return the environment without the variables that set options of rtcli."""
    return {name: value for name, value in os.environ.items() if not name.startswith("RTCLI_")}
