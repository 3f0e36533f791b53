"""Values that options put into a scene before it is checked: `--set objects.ball.radius=2`, `--size 640x480`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from rtcli.scene.diagnostics.problems import Problem, SceneError, nearest, printable, quoted
from rtcli.scene.paths import PathError, PathStep, split, unquoted_name
from rtcli.scene.reading.source import Document, Edit, Loc, Source, SourceSpan, dotted
from rtcli.scene.reading.yaml_reader import read_carefully

_NAME_IT = "name it in the file, or use its index"
# Of a name in a hint: longer ones would be cut.
_LONGEST_SHOWN = 40


class EditError(ValueError):
    """An edit that cannot be made: its path is malformed, or names nothing in this scene."""


class _QuotesMissingError(EditError):
    """A path with a name that needs quotes and has none."""


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
    option
        What gave them, as messages call it: `--set`, or the name of a variable.
    """

    size: tuple[int, int] | None = None
    samples: int | None = None
    exposure: float | str | None = None
    edits: tuple[str, ...] = ()
    option: str = "--set"

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
            document = set_expression(document, expression, self.option)
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
        Keys joined by dots, list items by index or, for objects, by name: `objects.ball.position[0]`. What has a
        dot, bracket or equals sign in it stands in quotes: `objects."Cube.001".color`.
    value
        Plain data, as `parse` gives it.
    option
        The option that asks for it, which stands for the file's name in messages.

    Raises
    ------
    EditError
        If the path is malformed or leads nowhere.
    """
    steps, end = _split(document, path)
    if end < len(path):
        raise EditError(f"{quoted(path)} is not a path: it has a value")
    return _set(document, value, steps, Edit((), Source(option, option), SourceSpan(0, len(option))))


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
    if "=" not in expression:
        raise EditError(f"{quoted(expression)} is not KEY=VALUE")
    steps, end = _split(document, expression)
    if end == len(expression):
        raise EditError(f"{quoted(expression)} is not KEY=VALUE")
    name = f"{option} {expression}"
    start = end + 1
    try:
        # Padded to where the value stands in the expression, so that columns count from its start.
        read = read_carefully(Source(name, " " * start + expression[start:]))
    except SceneError as error:
        raise _not_a_value(error.problems[0]) from error
    if read.problems:
        raise _not_a_value(read.problems[0])
    place = SourceSpan(start, len(expression)) if read.data is None or read.places is None else read.places
    return _set(document, read.data, steps, Edit((), Source(name, expression), place))


def _not_a_value(problem: Problem) -> EditError:
    return EditError(f"{printable(problem.path)}: {problem.message}")


def _split(document: Document, expression: str) -> tuple[tuple[PathStep, ...], int]:
    """Return the steps of `KEY=VALUE`, and the offset of its equals sign.

    Raises
    ------
    EditError
        If it does not start with a path; it tells which quotes would make it one in this document.
    """
    try:
        return split(expression)
    except PathError as error:
        _refuse_missing_quotes(document, error.steps)
        raise EditError(str(error)) from error


def _refuse_missing_quotes(document: Document, steps: Sequence[PathStep]) -> None:
    """Raise EditError if the start of a path, which goes wrong after it, names an item that needs quotes."""
    try:
        _set(document, None, steps, Edit((), document.source, SourceSpan(0, 0)))
    except _QuotesMissingError:
        raise
    except EditError:
        pass  # the path is wrong anyway


def _set(document: Document, value: Any, steps: Sequence[PathStep], edit: Edit) -> Document:
    if not isinstance(document.data, dict):
        return document  # which validation refuses for that very reason
    data, loc = _replaced(document.data, steps, value, ())
    return replace(document, data=data, edits=(*document.edits, replace(edit, loc=loc)))


def _replaced(node: Any, steps: Sequence[PathStep], value: Any, so_far: Loc) -> tuple[Any, Loc]:
    """Return a copy of the node with the value at `steps`, sharing all that stays, and where that is."""
    if not steps:
        return value, so_far
    key = _resolve(node, steps, so_far)
    child = node.get(key, {}) if isinstance(node, dict) else node[key]
    new_child, loc = _replaced(child, steps[1:], value, (*so_far, key))
    copy = node.copy()
    copy[key] = new_child
    return copy, loc


def _resolve(node: Any, steps: Sequence[PathStep], so_far: Loc) -> str | int:
    """Return the key or index that the first of several steps means in a node."""
    here = quoted(dotted(so_far)) if so_far else "the scene"
    key = steps[0].key
    if isinstance(node, dict) and isinstance(key, str):
        return key
    if isinstance(node, list) and isinstance(key, int):
        if key >= len(node):
            raise EditError(f"{here} has {len(node)} items, counted from 0: there is no [{key}]")
        return key
    if isinstance(node, list):
        return _index_of_name(node, steps, so_far)
    kind = "a list" if isinstance(key, int) else "a mapping"
    missing = " in the file, which leaves it out" if node == {} else ""
    raise EditError(f"{here} is not {kind}{missing}: set the whole of it")


def _index_of_name(items: list[Any], steps: Sequence[PathStep], so_far: Loc) -> int:
    """Return the index of the item that a step names."""
    names = [item.get("name") if isinstance(item, dict) else None for item in items]
    known = [name for name in names if isinstance(name, str)]
    name = str(steps[0].key)
    longer = unquoted_name(known, steps[0])
    if longer is not None and not (name in known and _has(items[names.index(name)], steps[1:])):
        raise _QuotesMissingError(
            f"a name with `.`, `[`, `]` or `=` in it needs quotes: did you mean {_item(longer, names, so_far)}?"
        )
    if name in known:
        return names.index(name)
    close = nearest(name, known)
    hint = _NAME_IT if close is None else f"did you mean {_item(close, names, so_far)}?"
    raise EditError(f"{quoted(dotted(so_far))} has no item named {quoted(name)}: {hint}")


def _has(item: dict[str, Any], steps: Sequence[PathStep]) -> bool:
    """Return whether an item has the key that a path goes on with, so that nothing else can be meant."""
    return bool(steps) and steps[0].key in item


def _item(name: str, names: list[Any], so_far: Loc) -> str:
    """Return an item as a hint shows it, to be pasted: by its name, or by its index if that would be cut."""
    is_short = len(name) <= _LONGEST_SHOWN
    return quoted(dotted((*so_far, name if is_short else names.index(name))))
