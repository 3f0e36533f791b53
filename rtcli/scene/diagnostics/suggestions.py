"""The likeliest meaning of an unknown word in a scene file: a slip, or the word that other programs use."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rtcli.scene.diagnostics.problems import nearest
from rtcli.scene.diagnostics.synonyms import (
    WORDS_FOR_CHOICES,
    WORDS_FOR_KEYS,
    WORDS_FOR_LIGHTS,
    WORDS_FOR_SHAPES,
)

# Words for a single number, where the key that they stand for holds a list: their values do not fit it.
_SINGLE_SIDES = frozenset({"width", "height", "depth", "length", "side", "edge"})

# Words for numbers of K.
_NUMBERS_OF_K = frozenset({"focal", "focallength", "f", "fx", "fy", "flx", "fly", "cx", "cy", "principalpoint"})

# Words for a camera of some kind, such as `ortho: true`.
_FLAGS = frozenset({"ortho", "orthographic", "parallel", "isometric", "perspective"})

# Longer words have no meaning.
_LONGEST_WORD = 60


def suggested_key(key: str, known: Collection[str], missing: Collection[str] = ()) -> str | None:
    """Return the key that an unknown one probably means, or None.

    Parameters
    ----------
    key
        The key in the file.
    known
        The keys that the mapping may have.
    missing
        The required keys that it lacks.
    """
    word = _plain(key)
    named = _named(word, WORDS_FOR_KEYS)
    meant = [name for name in known if _plain(name) == word] + [name for name in named if name in known]
    if not meant:
        return None if named else nearest(key, known)  # the word is for keys of another mapping
    return next((name for name in meant if name in missing), meant[0])


def suggested_type(word: str, known: Collection[str]) -> str | None:
    """Return the type of object or light that an unknown one probably means, or None."""
    meant = [kind for kind in _named(_plain(word), WORDS_FOR_SHAPES | WORDS_FOR_LIGHTS) if kind in known]
    return meant[0] if meant else nearest(word, known)


def suggested_choice(word: str, known: Collection[str]) -> str | None:
    """Return the one of a few words that an unknown one probably means, or None."""
    meant = [choice for choice in _named(_plain(word), WORDS_FOR_CHOICES) if choice in known]
    return meant[0] if meant else nearest(word, known)


def is_value_of_another_kind(key: str, meant: str) -> bool:
    """Return whether the value of a misnamed key does not fit the key that is meant."""
    if meant == "look_at":
        return _plain(key) == "direction"  # not a point
    if meant in ("opencv", "opengl"):
        # Nearly all are words for a matrix, where the key holds a mapping.
        return _plain(key) not in ("cv", "gl") and _plain(key) in WORDS_FOR_KEYS[meant].split()
    if meant == "projection":
        return _plain(key) in _FLAGS
    if meant == "intrinsics":
        return _plain(key) in _NUMBERS_OF_K
    return meant in ("size", "resolution") and _plain(key) in _SINGLE_SIDES


def _named(word: str, words: Mapping[str, str]) -> list[str]:
    """Return the keys or shapes that other programs call by a word."""
    return [name for name, others in words.items() if word in others.split()]


def _plain(word: str) -> str:
    return word[:_LONGEST_WORD].strip().lower().replace("_", "").replace("-", "").replace(" ", "")
