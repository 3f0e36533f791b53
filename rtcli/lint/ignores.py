"""Comments of a scene file that ignore warnings, such as `# rtcli: ignore W003`.

A comment on a line of its own before the first key holds for the whole file; one at the end of a line, for that
line; one on a line of its own elsewhere, for the next line that is no comment.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS, Problem, nearest, quoted
from rtcli.scene.diagnostics.rules import WARNING, Rule
from rtcli.scene.files import JSON_SUFFIX
from rtcli.scene.reading.source import Source, SourceSpan

# A file without this text has no such comment, and is not scanned.
_MARK = "rtcli:"
_COMMENT = re.compile(r"(?:^|(?<=[\r\n \t]))#[ \t]*rtcli:[ \t]*ignore\b:?(?P<codes>[^\r\n#]*)")
_CODE = re.compile(r"[^\s,]+")
# The rest of a line, and the lines below it that are comments.
_REST_AND_COMMENTS = re.compile(r"[^\r\n]*(?:\r\n|\r|\n|\Z)(?:[ \t]*#[^\r\n]*(?:\r\n|\r|\n))*")


def warning_of(code: str) -> Rule:
    """Return the warning with a code.

    Raises
    ------
    ValueError
        If there is no such rule, or it is an error.
    """
    rule = rules.BY_CODE.get(code.upper())
    if rule is None:
        raise ValueError(f"there is no rule {quoted(code)}{_hint(code)}")
    if rule.severity != WARNING:
        raise ValueError(f"{rule.code} is an error: only warnings (W...) can be ignored")
    return rule


def _hint(code: str) -> str:
    """Return a question that suggests the warning with a similar code or name, or nothing."""
    warnings = [rule for rule in rules.RULES if rule.severity == WARNING]
    by_text = {text: rule for rule in warnings for text in (rule.code.lower(), rule.name)}
    padded = code[:1].lower() + code[1:].zfill(3)  # W3 is W003 rather than W013
    close = padded if padded in by_text else nearest(code, by_text)
    return f": did you mean {by_text[close].code}?" if close else ""


@dataclass
class Ignores:
    """The ignored rules.

    Parameters
    ----------
    everywhere
        The rules ignored in the whole file.
    lines
        The rules ignored on single lines, by line number.
    problems
        The problems of the comments themselves.
    """

    everywhere: set[Rule]
    lines: dict[int, set[Rule]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def on_line(self, line: int) -> set[Rule]:
        """Return the rules ignored on a line."""
        return self.everywhere | self.lines.get(line, set())


def ignores_of(source: Source, everywhere: Collection[Rule] = ()) -> Ignores:
    """Return the rules that the comments of a valid scene ignore, and those ignored everywhere."""
    ignores = Ignores(set(everywhere))
    if _MARK not in source.text or source.name.lower().endswith(JSON_SUFFIX):
        return ignores
    below = -1  # the end of the block of comment lines around the previous comment
    for comment, is_first in _comments(source.text):
        named = set(_named(source, comment, ignores.problems))
        if not _is_alone(source.text, comment.start()):
            line = source.span(comment.start()).line
        elif is_first:
            ignores.everywhere |= named
            continue
        else:
            below = _below(source.text, comment.end()) if comment.end() > below else below
            line = source.span(below).line
        ignores.lines.setdefault(line, set()).update(named)
    return ignores


def _comments(text: str) -> Iterator[tuple[re.Match[str], bool]]:
    """Yield the comments to rtcli, those that are not part of a text, and whether each precedes all values."""
    import yaml

    from rtcli.scene.reading.yaml_reader import YamlParser

    waiting = _COMMENT.finditer(text)
    comment = next(waiting, None)
    begun = False
    for token in yaml.scan(text, Loader=YamlParser):
        while comment is not None and comment.start() < token.start_mark.index:
            yield comment, not begun
            comment = next(waiting, None)
        while comment is not None and comment.start() < token.end_mark.index:
            comment = next(waiting, None)
        if comment is None:
            return
        begun = begun or not isinstance(
            token, (yaml.StreamStartToken, yaml.DirectiveToken, yaml.DocumentStartToken)
        )


def _named(source: Source, comment: re.Match[str], problems: list[Problem]) -> Iterator[Rule]:
    """Yield the rules that a comment names, and append its problems."""
    codes = list(_CODE.finditer(source.text, *comment.span("codes")))
    if not codes:
        _add(problems, source, "the comment lists no warning", comment.span())
    for code in codes:
        try:
            yield warning_of(code[0])
        except ValueError as error:
            _add(problems, source, str(error), code.span())


def _add(problems: list[Problem], source: Source, message: str, span: tuple[int, int]) -> None:
    if len(problems) <= MAX_PROBLEMS:
        problems.append(source.problem(rules.UNKNOWN_IGNORE, message, SourceSpan(*span)))


def _is_alone(text: str, offset: int) -> bool:
    """Return whether only blanks stand on the line before an offset."""
    start = max(text.rfind("\n", 0, offset), text.rfind("\r", 0, offset)) + 1
    return not text[start:offset].strip()


def _below(text: str, offset: int) -> int:
    """Return the start of the next line that is not a comment."""
    lines = _REST_AND_COMMENTS.match(text, offset)
    assert lines is not None
    return lines.end()
