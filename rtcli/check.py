"""All that can be said of a scene file: errors, by which it is not valid; else warnings of the improbable."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from rtcli.pipeline import glance
from rtcli.scene import lint, rules
from rtcli.scene.diagnostics import place_in_file, validate
from rtcli.scene.document import HEAD, Document
from rtcli.scene.lint import LintWarning, Look
from rtcli.scene.model import Scene
from rtcli.scene.parse import parse_bytes
from rtcli.scene.problems import MAX_PROBLEMS, Problem, SceneError


def check(raw: bytes, name: str) -> tuple[Problem, ...]:
    """Return what is wrong with a scene file, in the order of the file.

    Parameters
    ----------
    raw
        The whole file.
    name
        Its name, by whose suffix it is read as YAML or JSON.
    """
    try:
        document = parse_bytes(raw, name)
        scene = validate(document)
    except SceneError as error:
        return error.problems
    found = itertools.islice(_warnings(scene), MAX_PROBLEMS + 1)
    return tuple(_listed([_placed(document, warning) for warning in found], document))


def _placed(document: Document, warning: LintWarning) -> Problem:
    """Return a warning at its place; of what the file leaves out, at the start of what is around it."""
    loc = document.nearest(warning.loc)
    at = warning.at if loc == warning.loc else HEAD
    return document.problem(warning.rule, loc, warning.message, at=at)


def _warnings(scene: Scene) -> Iterator[LintWarning]:
    look = Look(scene)
    yield from lint.lint(look)
    seen = glance(scene)
    if seen is None:
        return
    place = ("image", "exposure")
    if seen.is_black and look.shines:  # without a light it is no wonder, and was told
        yield LintWarning(rules.BLACK_PICTURE, place, "the whole picture comes out black")
    if seen.is_white:
        yield LintWarning(rules.WHITE_PICTURE, place, "the whole picture comes out white")
    else:
        yield from lint.burnt_out(look, seen.exposure)


def _listed(problems: list[Problem], document: Document) -> Iterator[Problem]:
    yield from sorted(problems[:MAX_PROBLEMS], key=lambda problem: place_in_file(problem, document))
    if len(problems) > MAX_PROBLEMS:
        message = f"only the first {MAX_PROBLEMS:,} warnings are listed"
        yield document.problem(rules.MORE_WARNINGS, (), message, at=HEAD)
