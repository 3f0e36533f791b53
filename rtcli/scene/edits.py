"""Values that options put into a scene before it is checked: `--set objects.ball.radius=2`, `--size 640x480`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from rtcli.scene.parse import Document, Edit, Loc, Place, dotted, parse_yaml
from rtcli.scene.problems import SceneError, did_you_mean, quoted

_STEP = re.compile(r"(?:^|(?<=.)\.)([^.\[\]]+)|\[([0-9]+)\]")


_NAME_IT = "name it in the file, or use its index"


class EditError(ValueError):
    """An edit that cannot be made: its path is malformed, or names nothing in this scene."""


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
    return _set(document, _steps(path), value, Place(option, 1, 1))


def set_expression(document: Document, expression: str) -> Document:
    """Return the document with `KEY=VALUE` applied, the value being YAML.

    Raises
    ------
    EditError
        If the expression is malformed or its path leads nowhere.
    """
    path, equals, text = expression.partition("=")
    if not equals:
        raise EditError(f"{quoted(expression)} is not KEY=VALUE")
    try:
        # Padded to where the value stands in the expression, so that columns count from its start.
        value = parse_yaml(" " * (len(path) + 1) + text, f"--set {expression}")
    except SceneError as error:
        raise EditError(str(error.problems[0])) from error
    if value.problems:
        raise EditError(str(value.problems[0]))
    place = Place(value.source, 1, len(path) + 2) if value.data is None or value.places is None else value.places
    return _set(document, _steps(path), value.data, place)


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


def _set(document: Document, steps: Loc, value: Any, place: Place) -> Document:
    if not isinstance(document.data, dict):
        return document  # which validation refuses for that very reason
    data, loc = _replaced(document.data, steps, value, ())
    return replace(document, data=data, edits=(*document.edits, Edit(loc, place)))


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
