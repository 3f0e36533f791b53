"""Paths into a scene, as `--set` takes them and messages show them: `camera.fov`, `objects."Cube.001".radius`."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import NamedTuple

from rtcli.scene.diagnostics.problems import SceneError, quoted
from rtcli.scene.reading.source import Source
from rtcli.scene.reading.yaml_reader import read_carefully

# A key or name, behind a dot unless it is the first step: in double quotes, in single quotes, or plain. An index.
_STEP = re.compile(
    r"""(?:^|(?<=.)\.)(?:(?P<double>"(?:[^"\\]|\\.)*")|'(?P<single>(?:[^']|'')*)'|(?P<plain>[^.\[\]="'][^.\[\]=]*))"""
    r"""|\[(?P<index>[0-9]+)\]""",
    re.DOTALL,
)


class PathError(ValueError):
    """What is no path.

    Parameters
    ----------
    message
        What is wrong with it.
    steps
        Those before the place where it goes wrong, and there an empty one if a key or name would have to follow.
    """

    def __init__(self, message: str, steps: tuple[PathStep, ...]) -> None:
        super().__init__(message)
        self.steps = steps


class PathStep(NamedTuple):
    """One step of a path.

    Parameters
    ----------
    key
        A key, the name of an object, or an index.
    is_quoted
        Whether it stands in quotes, so that nothing else can be meant.
    rest
        The text from where it starts, to its end and past it.
    """

    key: str | int
    is_quoted: bool = False
    rest: str = ""


def split(expression: str) -> tuple[tuple[PathStep, ...], int]:
    """Return the steps of `KEY=VALUE`, and the offset of its equals sign, or its end if there is none.

    Raises
    ------
    PathError
        If it does not start with a path.
    """
    steps: list[PathStep] = []
    end = 0
    for step, after in _steps(expression):
        steps.append(step)
        end = after
    if end == 0 or expression[end : end + 1] not in ("", "="):
        path = expression.partition("=")[0]
        if expression[end : end + 1] == "." or end == 0:
            steps.append(PathStep("", rest=expression[end:].removeprefix(".")))
        message = (
            f'{quoted(path)} is not a path such as `camera.fov`, `objects[2].radius` or `objects."a.b".radius`'
        )
        raise PathError(message, tuple(steps))
    return tuple(steps), end


def keys_of(path: str) -> tuple[str | int, ...]:
    """Return the keys and indices of a path, however it quotes them.

    Raises
    ------
    PathError
        If it is none.
    """
    return tuple(step.key for step in split(path)[0])


def _steps(text: str) -> Iterator[tuple[PathStep, int]]:
    """Yield the steps at the start of a text, each with the offset after it."""
    match = _STEP.match(text)
    while match:
        start = match.start() + text.startswith(".", match.start())
        is_quoted = match["double"] is not None or match["single"] is not None
        yield PathStep(_key(match), is_quoted, text[start:]), match.end()
        match = _STEP.match(text, match.end())


def _key(match: re.Match[str]) -> str | int:
    if match["index"] is not None:
        return int(match["index"])
    if match["double"] is not None:
        return _unescaped(match["double"])
    return str(match["plain"] or match["single"].replace("''", "'"))


def _unescaped(text: str) -> str:
    """Return the value of a text in double quotes, with the escapes of JSON or YAML."""
    try:
        return str(json.loads(text, strict=False))
    except ValueError:
        pass
    try:
        return str(read_carefully(Source("", text)).data)
    except SceneError as error:
        raise PathError(
            f"{quoted(text)} is not a text in double quotes: {error.problems[0].message}", ()
        ) from error


def unquoted_name(names: list[str], step: PathStep) -> str | None:
    """Return the longest of several names that a path has without quotes, where it needs them; or None."""
    if step.is_quoted or isinstance(step.key, int):
        return None
    longer = [
        name
        for name in names
        if len(name) > len(step.key) and step.rest.startswith(name) and step.rest[len(name) :][:1] in ("", *".[=")
    ]
    return max(longer, key=len, default=None)
