"""How long contestants take, in turn: rtcli, povray, mitsuba, rtcli, povray, mitsuba, ...

What disturbs the machine for a while then disturbs all of them alike, and medians forget it.
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

# What is compared: the seconds of a whole process, or what a program tells of its own stages.
PROCESS = "whole process"
TRACE = "trace"
TRACE_DEVELOP = "trace + develop"
READ = "read"

Seconds = dict[str, float]


@dataclass(frozen=True)
class Contestant:
    """A command to be timed.

    Parameters
    ----------
    name
        Unique in its contest.
    command
        Program and arguments. If it prints JSON, that tells seconds of its own; see `told_seconds`.
    environment
        Variables it needs.
    once
        It takes so long that one run must do, without a warm-up.
    """

    name: str
    command: tuple[str, ...]
    environment: dict[str, str] = field(default_factory=dict)
    once: bool = False

    def run(self) -> Seconds:
        """Run once and return its seconds, from start to end and as it tells them itself.

        Raises
        ------
        SystemExit
            With what it said, if it failed.
        """
        environment = {**_neutral_environment(), **self.environment}
        start = time.perf_counter()
        done = subprocess.run(self.command, capture_output=True, env=environment, check=False)
        process = time.perf_counter() - start
        if done.returncode != 0:
            said = done.stderr.decode(errors="replace")[-2000:]
            sys.exit(f"{self.name} failed with exit code {done.returncode}: {' '.join(self.command)}\n{said}")
        return {PROCESS: process, **told_seconds(done.stdout)}


@dataclass(frozen=True)
class Contest:
    """Contestants at the same work.

    Parameters
    ----------
    name
        For `--only`.
    work
        What they do, in words.
    contestants
        In the order of their turns.
    timed
        The stages that are compared.
    pixels
        Of the picture, where pixels per second are of interest.
    """

    name: str
    work: str
    contestants: tuple[Contestant, ...]
    timed: tuple[str, ...] = (PROCESS,)
    pixels: int | None = None

    def hold(self, rounds: int) -> dict[str, Any]:
        """Let all run in turn and return what `summary` makes of it; a first round only warms up."""
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


def told_seconds(output: bytes) -> Seconds:
    """Return the seconds that a program prints as JSON, none if it prints something else.

    rtcli's `--stats` holds them under `seconds`, `brute_force.c` prints little else.
    """
    try:
        told = json.loads(output)
    except ValueError:
        return {}
    seconds = told.get("seconds", told)
    return {stage: value for stage, value in seconds.items() if isinstance(value, float)}


def summary(runs: list[Seconds]) -> dict[str, dict[str, float]]:
    """Return median, least and most of each stage over the runs.

    `trace + develop` is added where both are told: its median is not the sum of theirs.
    """
    stages = {stage: [run[stage] for run in runs] for stage in runs[0]}
    if {"trace", "develop"} <= stages.keys():
        stages[TRACE_DEVELOP] = [run["trace"] + run["develop"] for run in runs]
    return {stage: _spread(values) for stage, values in stages.items()}


def _spread(values: list[float]) -> dict[str, float]:
    spread = {"median": statistics.median(values), "least": min(values), "most": max(values)}
    return {name: round(value, 6) for name, value in spread.items()}


def _neutral_environment() -> dict[str, str]:
    """Return the environment without what would set options of rtcli."""
    return {name: value for name, value in os.environ.items() if not name.startswith("RTCLI_")}
