"""Error recovery: replace mistaken keys and types by their likeliest corrections, and check the result.

Without recovery, a misspelt required key would count as missing and as unknown; values that depend on a misspelt
optional key would be checked against its default; and an object of unknown type would hide all its other mistakes.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, NamedTuple, TypeAlias

from pydantic import BaseModel

from rtcli.scene import model
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS
from rtcli.scene.diagnostics.suggestions import is_value_of_another_kind, suggested_key, suggested_type
from rtcli.scene.reading.limits import UNREADABLE
from rtcli.scene.reading.source import Loc

_Mapping: TypeAlias = dict[str, Any]
_Model: TypeAlias = type[BaseModel]

# Stands in for an object whose type cannot be guessed: the object's own values replace these before the check.
_ANY_TYPE = "sphere"
_ANY_OBJECT = {"type": _ANY_TYPE, "position": [0, 0, 0], "radius": 1, "color": "white"}
# The keys that all types of object have.
_COMMON_KEYS = frozenset.intersection(*(frozenset(shape.model_fields) for shape in model.SHAPES.values()))
# The keys that any type has, and those that only some have.
_KEYS = {key for shape in model.SHAPES.values() for key in shape.model_fields}
_TYPE_KEYS = _KEYS - _COMMON_KEYS


class MistakenKey(NamedTuple):
    """An unknown key of a mapping that lacks the key it probably means.

    Parameters
    ----------
    loc
        The location of the key in the file.
    meant
        The key that is meant.
    around
        The model of the mapping, or None for an object of unknown type.
    """

    loc: Loc
    meant: str
    around: _Model | None


class MistakenType(NamedTuple):
    """An object whose type is unknown or missing.

    Parameters
    ----------
    loc
        The location of the type, or of the object if the type is missing.
    found
        The value in the file; None if it is missing.
    meant
        The type that the word probably means, or None.
    checked_as
        The type that follows from the object's keys, if none does from the word; or None.
    is_missing
        Whether the type is missing.
    """

    loc: Loc
    found: Any
    meant: str | None = None
    checked_as: str | None = None
    is_missing: bool = False


class Recovery:
    """A scene's data with mistaken keys and types replaced by their likeliest corrections, and the mistakes.

    Mistakes beyond the first `MAX_PROBLEMS` stay, since they are not listed.

    Parameters
    ----------
    data
        The scene's data, which stays unchanged.

    Attributes
    ----------
    data
        The corrected data, which shares everything that is not replaced with the scene's.
    mistakes
        The replaced keys and types: each is a problem of its own.
    """

    def __init__(self, data: _Mapping) -> None:
        self.mistakes: list[MistakenKey | MistakenType] = []
        # For the location of a mapping in `data`, its replaced keys and their names in the file.
        self._names_in_file: dict[Loc, dict[str, str]] = {}
        # The unknown keys and types that may still be looked up, since each search takes some time.
        self._left = MAX_PROBLEMS
        self.data = self._scene(data)

    def in_file(self, loc: Loc) -> Loc:
        """Return the location in the file of a location in `data`."""
        return tuple(
            self._names_in_file.get(loc[:depth], {}).get(str(step), step) for depth, step in enumerate(loc)
        )

    def _scene(self, data: _Mapping) -> _Mapping:
        scene = dict(self._with_keys((), data, model.Scene))
        if isinstance(scene.get("camera"), dict):
            scene["camera"] = self._camera(("camera",), scene["camera"])
        for key, replaced in (("lights", self._light), ("objects", self._object)):
            if isinstance(scene.get(key), list):
                scene[key] = [
                    replaced((key, index), item) if isinstance(item, dict) else item
                    for index, item in enumerate(scene[key])
                ]
        return scene if self.mistakes else data

    def _camera(self, loc: Loc, item: _Mapping) -> _Mapping:
        item = self._with_keys(loc, item, model.Camera)
        for key in ("opencv", "opengl"):
            if isinstance(item.get(key), dict):
                item = {**item, key: self._with_keys((*loc, key), item[key], model.Pose)}
        return item

    def _light(self, loc: Loc, item: _Mapping) -> _Mapping:
        return self._with_keys(loc, item, model.PointLight)

    def _object(self, loc: Loc, item: _Mapping) -> _Mapping:
        shape = item.get("type")
        if not isinstance(shape, str) or shape not in model.SHAPES:
            item = self._typed(loc, item)
            shape = item.get("type")
            if shape not in model.SHAPES:
                return item
        item = self._with_keys(loc, item, model.SHAPES[shape])
        for key, part in model.PARTS.items():
            if isinstance(item.get(key), dict):
                known = self._with_keys((*loc, key), item[key], part)
                item = item if known is item[key] else {**item, key: known}
        return item

    # --- Keys --------------------------------------------------------------------------------------------

    def _with_keys(self, loc: Loc, mapping: _Mapping, around: _Model | None) -> _Mapping:
        """Return a mapping with each unknown key replaced by the key that it means, if the mapping lacks that."""
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
                self.mistakes.append(MistakenKey((*self.in_file(loc), key), meant, around))
        return self._renamed(loc, mapping, renamed) if renamed else mapping

    def _renamed(self, loc: Loc, mapping: _Mapping, renamed: dict[str, str]) -> _Mapping:
        self._names_in_file.setdefault(loc, {}).update({meant: key for key, meant in renamed.items()})
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
        """Return an object with the likeliest type, and report its own."""
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
            self.mistakes.append(MistakenKey((*loc, key), "type", around))
            item = self._renamed(loc, item, {key: "type"})
        return {**item, "type": nearest} if nearest else self._of_any_type(loc, item)

    def _untyped(self, loc: Loc, item: _Mapping) -> _Mapping:
        """Return an object without a type with the one that its keys imply, or unchanged if they imply none."""
        nearest = self._type_by_keys(item)
        if nearest is None:
            return item
        self.mistakes.append(MistakenType(loc, None, checked_as=nearest, is_missing=True))
        return {**item, "type": nearest}

    def _key_of_type(self, item: _Mapping) -> str | None:
        unknown = (key for key in item if key not in _KEYS)
        return next((key for key in unknown if self._suggested(key, _KEYS, ("type",)) == "type"), None)

    def _unknown_type(self, loc: Loc, found: Any, item: _Mapping) -> str | None:
        """Return the likeliest type for an unknown one, from its word or else from the object's keys."""
        meant = suggested_type(found, model.SHAPES) if isinstance(found, str) else None
        by_keys = None if meant else self._type_by_keys(item)
        self.mistakes.append(MistakenType(loc, found, meant, by_keys))
        return meant or by_keys

    def _of_any_type(self, loc: Loc, item: _Mapping) -> _Mapping:
        """Return an object reduced to the keys of `_ANY_OBJECT`'s type, and lacking none."""
        item = self._with_keys(loc, item, None)
        common = model.SHAPES[_ANY_TYPE].model_fields
        kept = {key: value for key, value in item.items() if key in common}
        return {**_ANY_OBJECT, **kept, "type": _ANY_TYPE}

    def _type_by_keys(self, item: _Mapping) -> str | None:
        """Return the type that the object's keys fit best, or those that they mean; None if several fit alike."""
        known = [key for key in item if key in _TYPE_KEYS]
        if not known:
            meant = (self._suggested(key, _KEYS) for key in item if key not in _COMMON_KEYS)
            known = [key for key in meant if key in _TYPE_KEYS]
        fits = {type: _fit(shape, known) for type, shape in model.SHAPES.items()}
        best = max(fits, key=lambda type: fits[type])
        return best if [*fits.values()].count(fits[best]) == 1 else None


def _fit(shape: _Model, known: list[str]) -> tuple[int, int, int]:
    """Rank a type by the keys it has, the required keys it lacks, and the position of the first it has."""
    fields = shape.model_fields
    has = [index for index, key in enumerate(known) if key in fields]
    lacks = sum(fields[key].is_required() for key in fields.keys() & _TYPE_KEYS - set(known))
    return len(has), -lacks, -min(has, default=0)
