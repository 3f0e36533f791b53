"""What a check found in files: the input of all reports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rtcli.scene.diagnostics.problems import Problem
from rtcli.scene.diagnostics.rules import ERROR


@dataclass(frozen=True)
class FileReport:
    """One file that was checked.

    Parameters
    ----------
    path
        Its name, as it was given or found.
    problems
        What is wrong with it.
    unreadable
        Why it could not be read; empty if it could.
    """

    path: str
    problems: tuple[Problem, ...] = ()
    unreadable: str = ""

    @property
    def has_errors(self) -> bool:
        """Whether the scene is not valid."""
        return any(problem.severity == ERROR for problem in self.problems)


@dataclass
class Tally:
    """Counts of what went through `count`.

    Parameters
    ----------
    scenes, unreadable
        Files that were read, and that could not be.
    with_problems, invalid
        Scenes with any problem, and with errors.
    errors, warnings
        Problems of each severity.
    """

    scenes: int = 0
    unreadable: int = 0
    with_problems: int = 0
    invalid: int = 0
    errors: int = 0
    warnings: int = 0

    def count(self, checks: Iterable[FileReport]) -> Iterator[FileReport]:
        """Yield what was checked, and count it on the way."""
        for checked in checks:
            errors = sum(problem.severity == ERROR for problem in checked.problems)
            self.scenes += not checked.unreadable
            self.unreadable += bool(checked.unreadable)
            self.with_problems += bool(checked.problems)
            self.invalid += checked.has_errors
            self.errors += errors
            self.warnings += len(checked.problems) - errors
            yield checked
