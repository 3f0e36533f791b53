"""Warnings about a template: those that hold for each of some samples."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rtcli.dataset.sample import SampleError, SampleRequest, draw_sample
from rtcli.lint.check import CheckResult, warnings_of
from rtcli.lint.ignores import Ignores, ignores_of
from rtcli.lint.scene import LintWarning
from rtcli.rendering.pack import pack_scene
from rtcli.scene.diagnostics.rules import Rule
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.reading.source import HEAD, Loc
from rtcli.template.template import Template
from rtcli.tracer.engines import default_threads

# The samples to look at, spread over all indices.
SAMPLES = 5
# A sample that takes more tries is not looked at: their number squared bounds the time for each object.
MOST_TRIES = 20


def lint_template(template: Template, ignore: Collection[Rule] = ()) -> CheckResult:
    """Return the warnings that hold for each of some samples, at their places in the template.

    Parameters
    ----------
    template
        The template.
    ignore
        Warnings to ignore, in addition to those that comments in the file name.
    """
    document = parse_bytes(template.raw, template.name)
    ignores, left_out = ignores_of(document.source, ignore), set[Rule]()
    found: list[dict[tuple[Rule, Loc], LintWarning]] = []
    for index in _indices(template):
        warnings = _warnings(template, index, ignores, left_out)
        if warnings is not None:
            found.append({(each.rule, document.nearest(each.loc)): each for each in warnings})
    always = set.intersection(*map(set, found)) if found else set()
    problems = [*ignores.problems]
    for (rule, loc), warning in found[0].items() if found else ():
        if (rule, loc) in always:
            at = warning.at if loc == warning.loc else HEAD
            message = f"{warning.message}, as in each of {len(found)} samples"
            problems.append(document.problem(rule, loc, message, at=at))
    wanted = [problem for problem in problems if problem.rule not in ignores.on_line(problem.line)]
    return CheckResult(tuple(sorted(wanted, key=document.order)))


def _indices(template: Template) -> list[int]:
    count = template.dataset.count
    return sorted({number * count // SAMPLES for number in range(SAMPLES)})


def _warnings(
    template: Template, index: int, ignores: Ignores, left_out: set[Rule]
) -> Iterator[LintWarning] | None:
    """Return the warnings about a sample, at their places in the template; None if a few tries do not find it."""
    try:
        sample, _ = draw_sample(template, index, SampleRequest(threads=default_threads(), tries=MOST_TRIES))
    except SampleError:
        return None

    def in_template(loc: Loc) -> Loc:
        return (*sample.groups[int(loc[1])].loc, *loc[2:]) if loc[:1] == ("objects",) and len(loc) > 1 else loc

    found = warnings_of(pack_scene(sample.scene), ignores, left_out)
    return (warning._replace(loc=in_template(warning.loc)) for warning in found)
