"""Values that options put into a scene before it is checked: `--set objects.ball.radius=2`, `--size 640x480`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from rtcli.scene.document import Document, Edit, Loc, Place, Source, dotted
from rtcli.scene.problems import Problem, SceneError, did_you_mean, printable, quoted
from rtcli.scene.yaml_reader import read_carefully

_STEP = re.compile(r"(?:^|(?<=.)\.)([^.\[\]]+)|\[([0-9]+)\]")


_NAME_IT = "name it in the file, or use its index"


class EditError(ValueError):
    """An edit that cannot be made: its path is malformed, or names nothing in this scene."""


@dataclass(frozen=True)
class Overrides:
    """What options change of a scene before it is checked.

    Parameters
    ----------
    size
        Width and height in pixels, or None for the scene's.
    samples
        Rays per pixel, or None for the scene's.
    exposure
        Stops or `auto`, or None for the scene's.
    edits
        Expressions of `--set`, in order.
    """

    size: tuple[int, int] | None = None
    samples: int | None = None
    exposure: float | str | None = None
    edits: tuple[str, ...] = ()

    def apply(self, document: Document) -> Document:
        """Return the changed document; `--set` has the last word.

        Raises
        ------
        EditError
            If `--set` is malformed, or names nothing in this scene.
        """
        for path, (option, value) in self._shorthands().items():
            document = set_value(document, path, value, option)
        for expression in self.edits:
            document = set_expression(document, expression)
        return document

    def _shorthands(self) -> dict[str, tuple[str, Any]]:
        shorthands: dict[str, tuple[str, Any]] = {}
        if self.size is not None:
            shorthands["camera.resolution"] = (f"--size {self.size[0]}x{self.size[1]}", list(self.size))
        if self.samples is not None:
            shorthands["render.samples"] = (f"--samples {self.samples}", self.samples)
        if self.exposure is not None:
            shorthands["image.exposure"] = (f"--exposure {self.exposure}", self.exposure)
        return shorthands


def check_expression(expression: str, option: str = "--set") -> None:
    """Raise EditError unless `KEY=VALUE` is one, whatever the scene."""
    set_expression(Document(Source("", ""), None), expression, option)


def set_value(document: Document, path: str, value: Any, option: str) -> Document:
    """Return the document with one value replaced or added.

    Parameters
    ----------
    document
        Left as it is.
    path
        Keys joined by dots, list items by index or, for objects, by name: `objects.ball.position[0]`.
    value
        Plain data, as `parse` gives it.
    option
        The option that asks for it, which stands for the file's name in messages.

    Raises
    ------
    EditError
        If the path is malformed or leads nowhere.
    """
    return _set(document, value, Edit(_steps(path), Source(option, option), Place(0, len(option))))


def set_expression(document: Document, expression: str, option: str = "--set") -> Document:
    """Return the document with `KEY=VALUE` applied, the value being YAML.

    Parameters
    ----------
    document
        Left as it is.
    expression
        `KEY=VALUE`, its path as `set_value` has it.
    option
        The option that asks for it; with the expression it stands for the file's name in messages.

    Raises
    ------
    EditError
        If the expression is malformed or its path leads nowhere.
    """
    path, equals, text = expression.partition("=")
    if not equals:
        raise EditError(f"{quoted(expression)} is not KEY=VALUE")
    name = f"{option} {expression}"
    try:
        # Padded to where the value stands in the expression, so that columns count from its start.
        read = read_carefully(Source(name, " " * (len(path) + 1) + text))
    except SceneError as error:
        raise _not_a_value(error.problems[0]) from error
    if read.problems:
        raise _not_a_value(read.problems[0])
    place = Place(len(path) + 1, len(expression)) if read.data is None or read.places is None else read.places
    return _set(document, read.data, Edit(_steps(path), Source(name, expression), place))


def _not_a_value(problem: Problem) -> EditError:
    return EditError(f"{printable(problem.path)}: {problem.message}")


def _steps(path: str) -> Loc:
    steps: list[str | int] = []
    end = 0
    for match in _STEP.finditer(path):
        if match.start() != end:
            break
        end = match.end()
        steps.append(match[1] if match[1] is not None else int(match[2]))
    if end != len(path) or not steps:
        raise EditError(f"{quoted(path)} is not a path such as `camera.fov` or `objects[2].radius`")
    return tuple(steps)


def _set(document: Document, value: Any, edit: Edit) -> Document:
    if not isinstance(document.data, dict):
        return document  # which validation refuses for that very reason
    data, loc = _replaced(document.data, edit.loc, value, ())
    return replace(document, data=data, edits=(*document.edits, replace(edit, loc=loc)))


def _replaced(node: Any, steps: Sequence[str | int], value: Any, so_far: Loc) -> tuple[Any, Loc]:
    """Return a copy of the node with the value at `steps`, sharing all that stays, and where that is."""
    if not steps:
        return value, so_far
    key = _resolve(node, steps[0], so_far)
    child = node.get(key, {}) if isinstance(node, dict) else node[key]
    new_child, loc = _replaced(child, steps[1:], value, (*so_far, key))
    copy = node.copy()
    copy[key] = new_child
    return copy, loc


def _resolve(node: Any, step: str | int, so_far: Loc) -> str | int:
    """Return the key or index that a step means in a node."""
    here = quoted(dotted(so_far)) if so_far else "the scene"
    if isinstance(node, dict) and isinstance(step, str):
        return step
    if isinstance(node, list) and isinstance(step, int):
        if step >= len(node):
            raise EditError(f"{here} has {len(node)} items, counted from 0: there is no [{step}]")
        return step
    if isinstance(node, list):
        return _index_of_name(node, str(step), here)
    kind = "a list" if isinstance(step, int) else "a mapping"
    missing = " in the file, which leaves it out" if node == {} else ""
    raise EditError(f"{here} is not {kind}{missing}: set the whole of it")


def _index_of_name(items: list[Any], name: str, here: str) -> int:
    names = [item.get("name") if isinstance(item, dict) else None for item in items]
    if name in names:
        return names.index(name)
    hint = did_you_mean(name, [str(known) for known in names if known is not None]) or _NAME_IT
    raise EditError(f"{here} has no item named {quoted(name)}: {hint}")
