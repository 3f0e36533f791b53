"""Error recovery: replace mistaken keys and types by what they most likely mean, and check what they hold.

Without it a misspelt required key would count twice, as missing and as unknown; what depends on a misspelt
optional one would be checked with its default; and an object of unknown type would hide all other mistakes in it.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from pydantic import BaseModel

from rtcli.scene import model
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS
from rtcli.scene.diagnostics.suggestions import is_value_of_another_kind, suggested_key, suggested_type
from rtcli.scene.reading.limits import UNREADABLE
from rtcli.scene.reading.source import Loc

_Mapping: TypeAlias = dict[str, Any]
_Model: TypeAlias = type[BaseModel]

# As this an object is checked when nothing tells which type is nearest: with what it has itself in place.
_ANY_TYPE = "sphere"
_ANY_OBJECT = {"type": _ANY_TYPE, "position": [0, 0, 0], "radius": 1, "color": "white"}
# The keys by which the type of an object can be told.
_TELLING = {"radius": "sphere", "normal": "plane", "size": "box", "rotation": "box"}


@dataclass(frozen=True)
class MistakenKey:
    """An unknown key where the one that is meant is not given.

    Parameters
    ----------
    loc
        Of the key, as the file has it.
    meant
        The key that is meant.
    around
        The model of the mapping, or None for an object that could be any.
    """

    loc: Loc
    meant: str
    around: _Model | None


@dataclass(frozen=True)
class MistakenType:
    """An object whose type is unknown, or missing.

    Parameters
    ----------
    loc
        Of the type, or of the object that has none.
    found
        What the file gives for it; None if it is missing.
    meant
        The type that the word probably means, or None.
    checked_as
        The type that the object's keys tell, if its word does not; or None.
    is_missing
        Whether there is none.
    """

    loc: Loc
    found: Any
    meant: str | None = None
    checked_as: str | None = None
    is_missing: bool = False


@dataclass
class Recovery:
    """A scene's data with mistaken keys and types replaced, and which they were.

    Parameters
    ----------
    data
        The data, sharing with the document all that is not replaced.
    mistakes
        What was replaced: each is a problem of its own.
    renamed
        For the location of a mapping in `data`, its replaced keys and what the file has for them.
    """

    data: _Mapping
    mistakes: list[MistakenKey | MistakenType] = field(default_factory=list)
    renamed: dict[Loc, dict[str, str]] = field(default_factory=dict)

    def in_file(self, loc: Loc) -> Loc:
        """Return a location in `data` as the file has it."""
        return tuple(
            self.renamed[loc[:depth]].get(str(step), step) if loc[:depth] in self.renamed else step
            for depth, step in enumerate(loc)
        )


def recover(data: _Mapping) -> Recovery:
    """Return a scene's data with mistaken keys and types replaced by what they most likely mean.

    Where they are very many, the last of them stay: more problems than `MAX_PROBLEMS` are not listed.
    """
    recovery = Recovery(data)
    recovery.data = _Recovering(recovery).scene(data)
    return recovery


class _Recovering:
    """Goes through a scene, replacing in copies; what has no mistake is shared."""

    def __init__(self, recovery: Recovery) -> None:
        self._recovery = recovery
        # Unknown keys and types that may still be looked at, since the search for what is meant takes its time.
        self._left = MAX_PROBLEMS

    def scene(self, data: _Mapping) -> _Mapping:
        scene = dict(self._with_keys((), data, model.Scene))
        if isinstance(scene.get("camera"), dict):
            scene["camera"] = self._with_keys(("camera",), scene["camera"], model.Camera)
        for key, replaced in (("lights", self._light), ("objects", self._object)):
            if isinstance(scene.get(key), list):
                scene[key] = [
                    replaced((key, index), item) if isinstance(item, dict) else item
                    for index, item in enumerate(scene[key])
                ]
        return scene if self._recovery.mistakes else data

    def _light(self, loc: Loc, item: _Mapping) -> _Mapping:
        return self._with_keys(loc, item, model.PointLight)

    def _object(self, loc: Loc, item: _Mapping) -> _Mapping:
        kind = item.get("type")
        if not isinstance(kind, str) or kind not in model.SHAPES:
            item = self._typed(loc, item)
            kind = item.get("type")
            if kind not in model.SHAPES:
                return item
        item = self._with_keys(loc, item, model.SHAPES[kind])
        if isinstance(item.get("light"), dict):
            light = self._with_keys((*loc, "light"), item["light"], model.CarriedLight)
            item = item if light is item["light"] else {**item, "light": light}
        return item

    # --- Keys --------------------------------------------------------------------------------------------

    def _with_keys(self, loc: Loc, mapping: _Mapping, around: _Model | None) -> _Mapping:
        """Return a mapping with unknown keys replaced by those that they mean and that it does not have."""
        fields = (around or model.SHAPES[_ANY_TYPE]).model_fields
        if mapping.keys() <= fields.keys():
            return mapping
        free = {name for name in fields if name not in mapping}
        renamed: dict[str, str] = {}
        for key in mapping:
            missing = {name for name in free if fields[name].is_required()}
            meant = None if key in fields or not free else self._suggested(key, fields, missing)
            if meant in free:
                free.remove(meant)
                renamed[key] = meant
                self._recovery.mistakes.append(MistakenKey((*self._recovery.in_file(loc), key), meant, around))
        return self._renamed(loc, mapping, renamed) if renamed else mapping

    def _renamed(self, loc: Loc, mapping: _Mapping, renamed: dict[str, str]) -> _Mapping:
        written = self._recovery.renamed.setdefault(loc, {})
        written.update({meant: key for key, meant in renamed.items()})
        return {
            renamed.get(key, key): UNREADABLE
            if key in renamed and is_value_of_another_kind(key, renamed[key])
            else value
            for key, value in mapping.items()
        }

    def _suggested(self, key: str, known: Collection[str], missing: Collection[str] = ()) -> str | None:
        return suggested_key(key, known, missing) if self._may_look() else None

    def _may_look(self) -> bool:
        self._left -= 1
        return self._left >= 0

    # --- Types -------------------------------------------------------------------------------------------

    def _typed(self, loc: Loc, item: _Mapping) -> _Mapping:
        """Return an object with the type that is nearest to what it has, and report what it has."""
        if not self._may_look():
            return item
        key = "type" if "type" in item else self._key_of_type(item)
        if key is None:
            return self._untyped(loc, item)
        found = item[key]
        is_known = isinstance(found, str) and found in model.SHAPES
        nearest = found if is_known else self._unknown_type((*loc, key), found, item)
        if key != "type":
            around = model.SHAPES[nearest] if nearest else None
            self._recovery.mistakes.append(MistakenKey((*loc, key), "type", around))
            item = self._renamed(loc, item, {key: "type"})
        return {**item, "type": nearest} if nearest else self._of_any_type(loc, item)

    def _untyped(self, loc: Loc, item: _Mapping) -> _Mapping:
        """Return an object that has no type with that which its keys tell; without such it stays."""
        nearest = self._type_by_keys(item)
        if nearest is None:
            return item
        self._recovery.mistakes.append(MistakenType(loc, None, checked_as=nearest, is_missing=True))
        return {**item, "type": nearest}

    def _key_of_type(self, item: _Mapping) -> str | None:
        known = {key for shape in model.SHAPES.values() for key in shape.model_fields}
        unknown = (key for key in item if key not in known)
        return next((key for key in unknown if self._suggested(key, known, ("type",)) == "type"), None)

    def _unknown_type(self, loc: Loc, found: Any, item: _Mapping) -> str | None:
        """Return the type that is nearest to an unknown one, by its word or else by the object's keys."""
        meant = suggested_type(found, model.SHAPES) if isinstance(found, str) else None
        by_keys = None if meant else self._type_by_keys(item)
        self._recovery.mistakes.append(MistakenType(loc, found, meant, by_keys))
        return meant or by_keys

    def _of_any_type(self, loc: Loc, item: _Mapping) -> _Mapping:
        """Return an object reduced to the keys that all types have, lacking none: its own type may want others."""
        item = self._with_keys(loc, item, None)
        common = model.SHAPES[_ANY_TYPE].model_fields
        kept = {key: value for key, value in item.items() if key in common}
        return {**_ANY_OBJECT, **kept, "type": _ANY_TYPE}

    def _type_by_keys(self, item: _Mapping) -> str | None:
        """Return the type of which an object has a key, or else one that means it; None if it has neither."""
        exact = next((_TELLING[key] for key in item if key in _TELLING), None)
        if exact is not None:
            return exact
        common = model.SHAPES[_ANY_TYPE].model_fields.keys()
        meant = (self._suggested(key, {*_TELLING, *common}) for key in item if key not in common)
        return next((_TELLING[key] for key in meant if key in _TELLING), None)
