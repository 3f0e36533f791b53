"""Check a scene file: report its errors or, if it is valid, its warnings."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING, NamedTuple

from rtcli.lint.ignores import Ignores, ignores_of
from rtcli.lint.probe import Probe
from rtcli.lint.scene import LintWarning, SceneIndex, burnt_spots, lint
from rtcli.rendering.load import read_packed
from rtcli.rendering.pack import PackedScene, pack_scene
from rtcli.rendering.spans import plain_document
from rtcli.rendering.stopwatch import Stopwatch
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS, Problem, SceneError
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.reading.source import HEAD, Document

if TYPE_CHECKING:
    from rtcli.template.template import Template


class CheckResult(NamedTuple):
    """The result of checking a scene file.

    Parameters
    ----------
    problems
        Its problems, in the order of the file.
    left_out
        The rules that were not applied to all of it, because the scene is too much work.
    template
        The template if the file is one; its warnings are those of its samples, which `check` does not draw.
    """

    problems: tuple[Problem, ...]
    left_out: tuple[Rule, ...] = ()
    template: Template | None = None


def check(raw: bytes, name: str, ignore: Collection[Rule] = ()) -> CheckResult:
    """Return the problems of a scene file; those of a template are errors only.

    Parameters
    ----------
    raw
        The bytes of the file.
    name
        Its name; the suffix decides whether it is read as YAML or JSON.
    ignore
        Warnings to ignore, in addition to those that comments in the file name.
    """
    scene = read_packed(raw, name, [], Stopwatch())
    if scene is None:
        return _check_by_models(raw, name, ignore)
    return _warned(scene, plain_document(raw, name), ignore)


def _check_by_models(raw: bytes, name: str, ignore: Collection[Rule]) -> CheckResult:
    from rtcli.scene.reading.parse import parse_bytes
    from rtcli.scene.validation.validate import validate
    from rtcli.template.template import is_template, template_of

    try:
        document = parse_bytes(raw, name)
        if is_template(document):
            return CheckResult((), template=template_of(document, raw))
        scene = pack_scene(validate(document))
    except SceneError as error:
        return CheckResult(error.problems)
    return _warned(scene, document, ignore)


def _warned(scene: PackedScene, document: Document, ignore: Collection[Rule]) -> CheckResult:
    """Return the warnings about a valid scene."""
    ignores = ignores_of(document.source, ignore)
    left_out: set[Rule] = set()
    placed = itertools.chain(ignores.problems, _placed(document, warnings_of(scene, ignores, left_out)))
    wanted = (problem for problem in placed if problem.rule not in ignores.on_line(problem.line))
    found = list(itertools.islice(wanted, MAX_PROBLEMS + 1))
    problems = sorted(found[:MAX_PROBLEMS], key=document.order)
    if len(found) > MAX_PROBLEMS:
        message = f"only the first {MAX_PROBLEMS:,} warnings are listed"
        problems.append(document.problem(rules.MORE_WARNINGS, (), message, at=HEAD))
    return CheckResult(
        tuple(problems), tuple(rule for rule in rules.RULES if rule in left_out - ignores.everywhere)
    )


def _placed(document: Document, warnings: Iterator[LintWarning]) -> Iterator[Problem]:
    """Yield warnings at their locations; one about an omitted key is at the start of the mapping around it."""
    for warning in warnings:
        loc = document.nearest(warning.loc)
        at = warning.at if loc == warning.loc else HEAD
        yield document.problem(warning.rule, loc, warning.message, at=at)


def warnings_of(scene: PackedScene, ignores: Ignores, left_out: set[Rule]) -> Iterator[LintWarning]:
    """Yield the warnings about a scene that are not ignored everywhere, and add the rules that are left out.

    Parameters
    ----------
    scene
        The scene.
    ignores
        The ignored rules.
    left_out
        Takes the rules that are not applied to all of the scene.
    """
    index = SceneIndex(scene)
    for warning in itertools.chain(lint(index), _picture(scene, index, ignores)):
        if warning.rule not in ignores.everywhere:
            yield warning
    left_out |= index.left_out


_OF_PICTURE = {rules.BLACK_PICTURE, rules.WHITE_PICTURE, rules.BURNT_OUT}


def _picture(scene: PackedScene, index: SceneIndex, ignores: Ignores) -> Iterator[LintWarning]:
    """Yield the warnings that a small picture gives rise to, unless all of them are ignored."""
    if ignores.everywhere >= _OF_PICTURE:
        return
    probe = Probe(scene)
    seen = probe.exposure()
    if seen is None:
        index.left_out |= _OF_PICTURE
        return
    exposure = ("image", "exposure")
    if seen.is_black and index.shining:  # a scene without a light has its own warning
        yield LintWarning(rules.BLACK_PICTURE, exposure, "the whole picture is black")
    if seen.is_white:
        yield LintWarning(rules.WHITE_PICTURE, exposure, "the whole picture is white")
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
