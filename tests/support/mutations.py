"""Scene data with mistakes, drawn at random."""

import copy

from hypothesis import assume
from hypothesis import strategies as st

# With every key.
VALID = {
    "version": 1,
    "camera": {"resolution": [4, 3], "fov": 40, "position": [0, 0, 0], "look_at": [0, 0, -1], "up": [0, 1, 0]},
    "lights": [
        {"position": [0, 3, 0], "intensity": 100, "color": "white"},
        {"type": "point", "position": [0, 3, 0], "intensity": 100, "radius": 0.3},
        {"type": "sun", "direction": [1, -3, 0], "irradiance": 2.5, "angle": 0.53, "color": "white"},
    ],
    "objects": [
        {"type": "plane", "name": "floor", "position": [0, -1, 0], "normal": [0, 1, 0], "color": [1, 1, 1]},
        {
            "type": "sphere",
            "name": "lamp",
            "position": [0, 0, -5],
            "radius": 1,
            "color": "#ff0000",
            "light": {"intensity": 1, "color": [2, 1, 0]},
        },
        {
            "type": "box",
            "name": "house",
            "position": [0, 0, -5],
            "size": [1, 1, 1],
            "rotation": 45,
            "color": "red",
            "checker": {"size": 0.5, "color": [0, 1, 0]},
            "light": {"intensity": 0, "radius": 0.5},
        },
        {
            "type": "cone",
            "name": "roof",
            "position": [0, 1, -5],
            "radius": 1,
            "top_radius": 0.5,
            "height": 1,
            "axis": [0, 1, 0],
            "color": "red",
        },
    ],
    "render": {
        "samples": 1,
        "background": [0, 0, 0],
        "ambient": "black",
        "max_depth": 1,
        "shadow_samples": 9,
        "eye_falloff": False,
    },
    "image": {"exposure": 0, "tone": "clip", "alpha": False},
}

KEYS = (
    st.sampled_from(["type", "name", "position", "light", "color", "radius", "camera", "x", "", "a.b"]) | st.text()
)
NUMBERS = st.sampled_from([0, 1, -1, 10**400, -(10**400), 10**5, 0.0, -0.0, 0.5, 1e308, 5e-324, 1e400, -1e400])
WORDS = st.sampled_from(
    ["", "auto", "red", "sphere", "plane", "box", "point", "sun", "1", "#fff", "\ud800", "\x1b", "x" * 200]
)
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.floats() | WORDS | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=6,
)


def containers(node):
    """Yield all mappings and lists in the node that are not empty, itself included."""
    if isinstance(node, (dict, list)) and node:
        yield node
        for child in node.values() if isinstance(node, dict) else node:
            yield from containers(child)


@st.composite
def mutated_scenes(draw):
    """Return the valid scene with one to four values replaced, removed, repeated or renamed."""
    scene = copy.deepcopy(VALID)
    for _ in range(draw(st.integers(1, 4))):
        nodes = list(containers(scene))
        assume(nodes)
        node = draw(st.sampled_from(nodes))
        step = draw(st.sampled_from(list(node) if isinstance(node, dict) else range(len(node))))
        change = draw(st.sampled_from(["replace", "remove", "repeat", "add"]))
        if change == "replace":
            node[step] = draw(VALUES)
        elif change == "remove":
            del node[step]
        elif isinstance(node, list):
            node.append(copy.deepcopy(node[step]) if change == "repeat" else draw(VALUES))
        else:
            node[draw(KEYS)] = copy.deepcopy(node[step]) if change == "repeat" else draw(VALUES)
    return scene


# --- All scenes that are one step from the valid one -------------------------------------------------------

# Values of every kind: valid ones of each key, and some on both sides of each bound.
ODD_NUMBERS = [-1, -5e-324, 0, 5e-324, 0.5, 1, 1.5, 4.0, 179.9, 180, 1024, 1025, 65_535, 65_536, 1e308, 10**400]
ODD_TEXTS = ["", "red", "LightSkyBlue", "Redd", "red\n", "#FF00aa", "#ff0000\n", "#fff", "lamp"]
CHOICES = ["sphere", "plane", "box", "cylinder", "auto", "Auto", "clip", "aces"]
ODD_LISTS = [[], [0, 0, 0], [0, -0.0, 0.0], [0, 0, -1], [2, 0, 0], [1, 1], [1, 1, 1, 1]]
ODD_VALUES = [None, False, True, {}, {"intensity": 1}, *ODD_NUMBERS, *ODD_TEXTS, *CHOICES, *ODD_LISTS]


def neighbours():
    """Yield the valid scene with one value replaced, removed, repeated or added, in every possible way."""
    yield from ODD_VALUES
    for number, original in enumerate(containers(VALID)):
        for step in list(original) if isinstance(original, dict) else range(len(original)):
            for value in ODD_VALUES:
                yield _changed(number, lambda node, step=step, value=value: node.__setitem__(step, value))
            yield _changed(number, lambda node, step=step: node.pop(step))
        if isinstance(original, list):
            yield _changed(number, lambda node: node.append(node[0]))
        else:
            for key in ("x", "light", "radius", "name"):
                yield _changed(number, lambda node, key=key: node.setdefault(key, 1))


def _changed(number, change):
    """Return a copy of the valid scene with a change to one of its mappings or lists, counted in their order."""
    scene = copy.deepcopy(VALID)
    change(list(containers(scene))[number])
    return scene
