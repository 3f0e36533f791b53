"""The problems found in each file: the input of all reports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from rtcli.scene.diagnostics.problems import Problem
from rtcli.scene.diagnostics.rules import ERROR


class FileReport(NamedTuple):
    """A file that was checked.

    Parameters
    ----------
    path
        Its name, as given or found.
    problems
        The problems of the scene.
    unreadable
        Why the file could not be read; empty if it could.
    """

    path: str
    problems: tuple[Problem, ...] = ()
    unreadable: str = ""

    @property
    def errors(self) -> list[Problem]:
        """The problems that make the scene invalid."""
        return [problem for problem in self.problems if problem.severity == ERROR]

    @property
    def warnings(self) -> list[Problem]:
        """The other problems."""
        return [problem for problem in self.problems if problem.severity != ERROR]


@dataclass
class Tally:
    """The counts over the file reports that passed through `count`.

    Parameters
    ----------
    scenes, unreadable
        Files that could be read, and files that could not.
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

    def count(self, files: Iterable[FileReport]) -> Iterator[FileReport]:
        """Yield the file reports, counting each."""
        for file in files:
            self.scenes += not file.unreadable
            self.unreadable += bool(file.unreadable)
            self.with_problems += bool(file.problems)
            self.invalid += bool(file.errors)
            self.errors += len(file.errors)
            self.warnings += len(file.warnings)
            yield file
