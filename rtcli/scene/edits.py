"""Edits of a scene before it is validated: a value at a key path, such as `objects.ball.radius=2`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from rtcli.scene.diagnostics.problems import SceneError, nearest, printable, quoted
from rtcli.scene.key_paths import KeyPathError, KeyPathStep, split, unquoted_name
from rtcli.scene.reading.source import Document, Edit, Loc, Source, SourceSpan, dotted
from rtcli.scene.reading.yaml_reader import read_exact

# A hint shows a longer name by its index instead, since a message would cut the name.
_MAX_NAME_SHOWN = 40


class EditError(ValueError):
    """An edit that cannot be made: its path is malformed, or names nothing in this scene."""


class _QuotesMissingError(EditError):
    """A path with a name that needs quotes and has none."""


def check_expression(expression: str, option: str = "--set") -> None:
    """Raise EditError if an expression is not `KEY=VALUE` for any scene."""
    set_expression(Document(Source("", ""), None), expression, option)


def set_value(document: Document, path: str, value: Any, option: str) -> Document:
    """Return the document with one value replaced or added.

    Parameters
    ----------
    document
        The document, which stays unchanged.
    path
        Keys joined by dots, list items by index or, for objects, by name: `objects.ball.position[0]`. A name with
        a dot, bracket or equals sign needs quotes: `objects."Cube.001".color`.
    value
        Plain data, as in `Document.data`.
    option
        The option that sets it, which messages show instead of the file's name.

    Raises
    ------
    EditError
        If the path is malformed or leads nowhere.
    """
    steps, _ = _split(document, path)
    return _set(document, steps, value, Source(option, option), SourceSpan(0, len(option)))


def set_expression(document: Document, expression: str, option: str = "--set") -> Document:
    """Return the document with `KEY=VALUE` applied; the value is YAML, the other parameters are as in `set_value`.

    Raises
    ------
    EditError
        If the expression is malformed or its path leads nowhere.
    """
    if "=" not in expression:
        raise EditError(f"{quoted(expression)} is not KEY=VALUE")
    steps, end = _split(document, expression)
    if end == len(expression):
        raise EditError(f"{quoted(expression)} is not KEY=VALUE")
    name = f"{option} {expression}"
    start = end + 1
    try:
        # Pad the value to its offset in the expression, so that columns count from the start of the expression.
        read = read_exact(Source(name, " " * start + expression[start:]))
        if read.problems:
            raise SceneError(read.problems)
    except SceneError as error:
        problem = error.problems[0]
        raise EditError(f"{printable(problem.path)}: {problem.message}") from error
    span = read.root_span
    if read.data is None or span is None:
        span = SourceSpan(start, len(expression))
    return _set(document, steps, read.data, Source(name, expression), span)


def _split(document: Document, expression: str) -> tuple[tuple[KeyPathStep, ...], int]:
    """Return the steps of `KEY=VALUE`, and the offset of its equals sign.

    Raises
    ------
    EditError
        If it does not start with a path; the message names the quotes that would make it one in this document.
    """
    try:
        return split(expression)
    except KeyPathError as error:
        try:
            _set(document, error.steps, None, document.source, SourceSpan(0, 0))
        except _QuotesMissingError:
            raise
        except EditError:
            pass  # the path is wrong in any case
        raise EditError(str(error)) from error


def _set(
    document: Document, steps: Sequence[KeyPathStep], value: Any, source: Source, span: SourceSpan
) -> Document:
    if not isinstance(document.data, dict):
        return document  # which validation will refuse
    data, loc = _replaced(document.data, steps, value, ())
    return replace(document, data=data, edits=(*document.edits, Edit(loc, source, span)))


def _replaced(node: Any, steps: Sequence[KeyPathStep], value: Any, loc: Loc) -> tuple[Any, Loc]:
    """Return a copy of the node at `loc` with the value at `steps`, and the value's location.

    The copy shares everything else with the node.
    """
    if not steps:
        return value, loc
    key = _resolve(node, steps, loc)
    child = node.get(key, {}) if isinstance(node, dict) else node[key]
    new_child, value_loc = _replaced(child, steps[1:], value, (*loc, key))
    copy = node.copy()
    copy[key] = new_child
    return copy, value_loc


def _resolve(node: Any, steps: Sequence[KeyPathStep], loc: Loc) -> str | int:
    """Return the key or index in the node at `loc` that the first step means."""
    here = quoted(dotted(loc)) if loc else "the scene"
    key = steps[0].key
    if isinstance(node, dict) and isinstance(key, str):
        return key
    if isinstance(node, list) and isinstance(key, int):
        if key >= len(node):
            raise EditError(f"{here} has {len(node)} items, counted from 0: there is no [{key}]")
        return key
    if isinstance(node, list):
        return _index_of_name(node, steps, loc)
    needed = "a list" if isinstance(key, int) else "a mapping"
    missing = " because the file omits it" if node == {} else ""
    raise EditError(f"{here} is not {needed}{missing}: set the whole value")


def _index_of_name(items: list[Any], steps: Sequence[KeyPathStep], loc: Loc) -> int:
    """Return the index of the item that the first step names, in the list at `loc`."""
    names = [item.get("name") if isinstance(item, dict) else None for item in items]
    known = [name for name in names if isinstance(name, str)]
    name = str(steps[0].key)
    longer = unquoted_name(known, steps[0])
    if name in known:
        index = names.index(name)
        # Without quotes the path is clear only if this item has the key that follows.
        if longer is None or (len(steps) > 1 and steps[1].key in items[index]):
            return index
    if longer is not None:
        raise _QuotesMissingError(
            f"a name that contains `.`, `[`, `]` or `=` needs quotes: did you mean {_item(longer, names, loc)}?"
        )
    close = nearest(name, known)
    hint = (
        "name it in the file, or use its index" if close is None else f"did you mean {_item(close, names, loc)}?"
    )
    raise EditError(f"{quoted(dotted(loc))} has no item named {quoted(name)}: {hint}")


def _item(name: str, names: list[Any], loc: Loc) -> str:
    """Return the path of an item, for pasting: by its name, or by its index if the name would be cut."""
    is_short = len(name) <= _MAX_NAME_SHOWN
    return quoted(dotted((*loc, name if is_short else names.index(name))))
