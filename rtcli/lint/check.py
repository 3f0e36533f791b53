"""All that can be said of a scene file: errors, by which it is not valid; else warnings of the improbable."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator
from typing import NamedTuple

from rtcli.lint.ignores import Ignores, ignores_of
from rtcli.lint.probe import Probe
from rtcli.lint.scene import LintWarning, SceneIndex, burnt_spots, lint
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS, Problem, SceneError
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.model import Scene
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.reading.source import HEAD, Document
from rtcli.scene.validation.validate import order_in_file, validate


class CheckResult(NamedTuple):
    """What is wrong with a scene file.

    Parameters
    ----------
    problems
        In the order of the file.
    left_out
        The rules that were not applied to all of it, because the scene is too much work.
    """

    problems: tuple[Problem, ...]
    left_out: tuple[Rule, ...] = ()


def check(raw: bytes, name: str, ignore: Collection[Rule] = ()) -> CheckResult:
    """Return what is wrong with a scene file.

    Parameters
    ----------
    raw
        The whole file.
    name
        Its name, by whose suffix it is read as YAML or JSON.
    ignore
        Warnings that are not wanted, beside those that comments of the file name.
    """
    try:
        document = parse_bytes(raw, name)
        scene = validate(document)
    except SceneError as error:
        return CheckResult(error.problems)
    ignores = ignores_of(document, ignore)
    left_out: set[Rule] = set()
    placed = _wanted(_placed(document, _warnings(scene, ignores, left_out)), ignores)
    found = list(itertools.islice(placed, MAX_PROBLEMS + 1))
    problems = tuple(_listed(found, document))
    return CheckResult(problems, tuple(rule for rule in rules.RULES if rule in left_out - ignores.everywhere))


def _placed(document: Document, warnings: Iterator[LintWarning]) -> Iterator[Problem]:
    """Yield warnings at their places; of what the file leaves out, at the start of what is around it."""
    for warning in warnings:
        loc = document.nearest(warning.loc)
        at = warning.at if loc == warning.loc else HEAD
        yield document.problem(warning.rule, loc, warning.message, at=at)


def _wanted(problems: Iterator[Problem], ignores: Ignores) -> Iterator[Problem]:
    """Yield the problems that no comment on their line ignores, those of the comments first."""
    for problem in itertools.chain(ignores.problems, problems):
        if problem.rule not in ignores.on_line(problem.line):
            yield problem


def _warnings(scene: Scene, ignores: Ignores, left_out: set[Rule]) -> Iterator[LintWarning]:
    index = SceneIndex(scene)
    for warning in itertools.chain(lint(index), _picture(scene, index, ignores)):
        if warning.rule not in ignores.everywhere:
            yield warning
    left_out |= index.left_out


_OF_PICTURE = {rules.BLACK_PICTURE, rules.WHITE_PICTURE, rules.BURNT_OUT}


def _picture(scene: Scene, index: SceneIndex, ignores: Ignores) -> Iterator[LintWarning]:
    """Yield what a picture in small shows, unless nobody wants to know."""
    if ignores.everywhere >= _OF_PICTURE:
        return
    probe = Probe(scene)
    seen = probe.exposure()
    if seen is None:
        index.left_out |= _OF_PICTURE
        return
    place = ("image", "exposure")
    if seen.is_black and index.shining:  # without a light it is no wonder, and was told
        yield LintWarning(rules.BLACK_PICTURE, place, "the whole picture comes out black")
    if seen.is_white:
        yield LintWarning(rules.WHITE_PICTURE, place, "the whole picture comes out white")
    else:
        yield from _burnt_out(probe, index, seen.exposure)


def _burnt_out(probe: Probe, index: SceneIndex, exposure: float) -> Iterator[LintWarning]:
    for spot in burnt_spots(index, exposure):
        burnt = probe.sees_burnt(spot, exposure)
        if burnt is None:
            index.left_out.add(rules.BURNT_OUT)
            return
        if burnt:
            yield spot.warning


def _listed(problems: list[Problem], document: Document) -> Iterator[Problem]:
    yield from sorted(problems[:MAX_PROBLEMS], key=lambda problem: order_in_file(problem, document))
    if len(problems) > MAX_PROBLEMS:
        message = f"only the first {MAX_PROBLEMS:,} warnings are listed"
        yield document.problem(rules.MORE_WARNINGS, (), message, at=HEAD)
