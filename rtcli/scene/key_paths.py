"""Key paths into a scene, as `--set` takes and messages show them: `camera.fov`, `objects."Cube.001".radius`."""

from __future__ import annotations

import json
import re
from typing import NamedTuple

from rtcli.scene.diagnostics.quoting import quoted

# An index, or a key or name: in double quotes, in single quotes, or plain, and after a dot unless it comes first.
_STEP = re.compile(
    r"""(?:^|(?<=.)\.)(?:(?P<double>"(?:[^"\\]|\\.)*")|'(?P<single>(?:[^']|'')*)'|(?P<plain>[^.\[\]="'][^.\[\]=]*))"""
    r"""|\[(?P<index>[0-9]{1,1000})\]""",
    re.DOTALL,
)


class KeyPathError(ValueError):
    """A text that is not a key path, with the steps before the error, and an empty one if a key is missing."""

    def __init__(self, message: str, steps: tuple[KeyPathStep, ...]) -> None:
        super().__init__(message)
        self.steps = steps


class KeyPathStep(NamedTuple):
    """One step of a key path.

    Parameters
    ----------
    key
        A key, the name of an object, or an index.
    is_quoted
        Whether it is in quotes, and so cannot mean anything else.
    rest
        The text of the key path from the start of this step.
    """

    key: str | int
    is_quoted: bool = False
    rest: str = ""


def split(expression: str) -> tuple[tuple[KeyPathStep, ...], int]:
    """Return the steps of `KEY=VALUE`, and the offset of its equals sign, or its end if there is none.

    Raises
    ------
    KeyPathError
        If it does not start with a key path.
    """
    steps, end = list[KeyPathStep](), 0
    while match := _STEP.match(expression, end):
        start = match.start() + expression.startswith(".", match.start())
        is_quoted = match["double"] is not None or match["single"] is not None
        steps.append(KeyPathStep(_key(match), is_quoted, expression[start:]))
        end = match.end()
    if end == 0 or expression[end : end + 1] not in ("", "="):
        path = expression.partition("=")[0]
        if expression[end : end + 1] == "." or end == 0:
            steps.append(KeyPathStep("", rest=expression[end:].removeprefix(".")))
        message = (
            f'{quoted(path)} is not a path such as `camera.fov`, `objects[2].radius` or `objects."a.b".radius`'
        )
        raise KeyPathError(message, tuple(steps))
    return tuple(steps), end


def keys_of(path: str) -> tuple[str | int, ...]:
    """Return the keys and indices of a key path, without quotes.

    Raises
    ------
    KeyPathError
        If it is not a key path.
    """
    return tuple(step.key for step in split(path)[0])


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
    from rtcli.scene.diagnostics.problems import SceneError
    from rtcli.scene.reading.source import Source
    from rtcli.scene.reading.yaml_reader import read_exact  # few names need it

    try:
        return str(read_exact(Source("", text)).data)
    except SceneError as error:
        raise KeyPathError(
            f"{quoted(text)} is not a string in double quotes: {error.problems[0].message}", ()
        ) from error


def unquoted_name(names: list[str], step: KeyPathStep) -> str | None:
    """Return the longest name that a path contains at this step without the quotes it needs, or None."""
    if step.is_quoted or isinstance(step.key, int):
        return None
    longer = [
        name
        for name in names
        if len(name) > len(step.key) and step.rest.startswith(name) and step.rest[len(name) :][:1] in ("", *".[=")
    ]
    return max(longer, key=len, default=None)
