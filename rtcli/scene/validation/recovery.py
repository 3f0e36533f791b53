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


class Family(NamedTuple):
    """The types that the items of a list may have.

    Parameters
    ----------
    kind, item
        The words for a type and for an item.
    types
        The models by type.
    usual
        The type of an item that names none; None if it must name one.
    any_item
        Stands in for an item whose type cannot be guessed: the item's own values replace these before the check.
    """

    kind: str
    item: str
    types: dict[str, type[Any]]
    usual: str | None
    any_item: _Mapping

    @property
    def any_model(self) -> _Model:
        """The model of `any_item`."""
        model: _Model = self.types[self.any_item["type"]]
        return model

    @property
    def keys(self) -> set[str]:
        """The keys that any type has."""
        return {key for kind in self.types.values() for key in kind.model_fields}

    @property
    def common_keys(self) -> frozenset[str]:
        """The keys that all types have."""
        return frozenset.intersection(*(frozenset(kind.model_fields) for kind in self.types.values()))


# By the key of the list.
FAMILIES = {
    "lights": Family(
        "light", "light", model.LIGHTS, model.USUAL_LIGHT, {"type": "point", "position": [0, 0, 0], "intensity": 1}
    ),
    "objects": Family(
        "shape",
        "object",
        model.SHAPES,
        None,
        {"type": "sphere", "position": [0, 0, 0], "radius": 1, "color": "white"},
    ),
}


class MistakenKey(NamedTuple):
    """An unknown key of a mapping that lacks the key it probably means.

    Parameters
    ----------
    loc
        The location of the key in the file.
    meant
        The key that is meant.
    around
        The model of the mapping, or None for an object or light of unknown type.
    """

    loc: Loc
    meant: str
    around: _Model | None


class MistakenType(NamedTuple):
    """An object or a light whose type is unknown or missing.

    Parameters
    ----------
    loc
        The location of the type, or of the item if the type is missing.
    found
        The value in the file; None if it is missing.
    meant
        The type that the word probably means, or None.
    checked_as
        The type that follows from the item's keys, if none does from the word; or None.
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
        for key, family in FAMILIES.items():
            if isinstance(scene.get(key), list):
                scene[key] = [
                    self._item((key, index), item, family) if isinstance(item, dict) else item
                    for index, item in enumerate(scene[key])
                ]
        return scene if self.mistakes else data

    def _camera(self, loc: Loc, item: _Mapping) -> _Mapping:
        item = self._with_keys(loc, item, model.Camera)
        for key in ("opencv", "opengl"):
            if isinstance(item.get(key), dict):
                item = {**item, key: self._with_keys((*loc, key), item[key], model.Pose)}
        return item

    def _item(self, loc: Loc, item: _Mapping, family: Family) -> _Mapping:
        kind = item.get("type")
        if not isinstance(kind, str) or kind not in family.types:
            item = self._typed(loc, item, family)
            kind = item.get("type", family.usual)
            if kind not in family.types:
                return item
        item = self._with_keys(loc, item, family.types[kind])
        for key, part in model.PARTS.items():
            if isinstance(item.get(key), dict):
                known = self._with_keys((*loc, key), item[key], part)
                item = item if known is item[key] else {**item, key: known}
        return item

    # --- Keys --------------------------------------------------------------------------------------------

    def _with_keys(self, loc: Loc, mapping: _Mapping, around: _Model, named: bool = True) -> _Mapping:
        """Return a mapping with each unknown key replaced by the key that it means, if the mapping lacks that.

        Messages do not name the model unless it is `named`.
        """
        fields = around.model_fields
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
                self.mistakes.append(MistakenKey((*self.in_file(loc), key), meant, around if named else None))
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

    def _typed(self, loc: Loc, item: _Mapping, family: Family) -> _Mapping:
        """Return an item with the likeliest type, and report its own."""
        if not self._may_look():
            return item
        key = "type" if "type" in item else self._key_of_type(item, family)
        if key is None:
            return self._untyped(loc, item, family)
        found = item[key]
        is_known = isinstance(found, str) and found in family.types
        nearest = found if is_known else self._unknown_type((*loc, key), item, family)
        if key != "type":
            around = family.types[nearest] if nearest else None
            self.mistakes.append(MistakenKey((*loc, key), "type", around))
            item = self._renamed(loc, item, {key: "type"})
        return {**item, "type": nearest} if nearest else self._of_any_type(loc, item, family)

    def _untyped(self, loc: Loc, item: _Mapping, family: Family) -> _Mapping:
        """Return an item without a type with the one that its keys imply, unless that is the usual one."""
        nearest = self._type_by_keys(item, family)
        if nearest is None or nearest == family.usual:
            return item
        self.mistakes.append(MistakenType(loc, None, checked_as=nearest, is_missing=True))
        return {**item, "type": nearest}

    def _key_of_type(self, item: _Mapping, family: Family) -> str | None:
        unknown = (key for key in item if key not in family.keys)
        return next((key for key in unknown if self._suggested(key, family.keys, ("type",)) == "type"), None)

    def _unknown_type(self, loc: Loc, item: _Mapping, family: Family) -> str | None:
        """Return the likeliest type for an unknown one, from its word or else from the item's keys."""
        found = item[str(loc[-1])]
        meant = suggested_type(found, family.types) if isinstance(found, str) else None
        by_keys = None if meant else self._type_by_keys(item, family)
        self.mistakes.append(MistakenType(loc, found, meant, by_keys))
        return meant or by_keys

    def _of_any_type(self, loc: Loc, item: _Mapping, family: Family) -> _Mapping:
        """Return an item reduced to the keys of the type of `any_item`, and lacking none."""
        item = self._with_keys(loc, item, family.any_model, named=False)
        common = family.any_model.model_fields
        kept = {key: value for key, value in item.items() if key in common}
        return {**family.any_item, **kept, "type": family.any_item["type"]}

    def _type_by_keys(self, item: _Mapping, family: Family) -> str | None:
        """Return the type that the item's keys fit best, or those that they mean; None if several fit alike."""
        own = family.keys - family.common_keys
        known = [key for key in item if key in own]
        if not known:
            meant = (self._suggested(key, family.keys) for key in item if key not in family.common_keys)
            known = [key for key in meant if key in own]
        fits = {type: _fit(kind, known, own) for type, kind in family.types.items()}
        best = max(fits, key=lambda type: fits[type])
        return best if [*fits.values()].count(fits[best]) == 1 else None


def _fit(kind: _Model, known: list[str], own: set[str]) -> tuple[int, int, int]:
    """Rank a type by the keys it has, the required keys it lacks, and the position of the first it has."""
    fields = kind.model_fields
    has = [index for index, key in enumerate(known) if key in fields]
    lacks = sum(fields[key].is_required() for key in fields.keys() & own - set(known))
    return len(has), -lacks, -min(has, default=0)
