"""What an unknown word in a scene file probably means: a misspelt one, or one that other renderers use."""

from __future__ import annotations

from collections.abc import Collection

from rtcli.scene.diagnostics.problems import nearest

# For each key of a scene the words that others use for it, in lower case, without hyphens and underscores. A word
# may stand for several keys: the first that the mapping has is meant, and one that is missing comes before others.
_WORDS_FOR_KEYS = {
    "camera": "cam cameras eye viewer viewpoint sensor view perspective resolution fov fieldofview lookat",
    "lights": "light lamp lamps lightsource lightsources pointlight pointlights emitter emitters luminaires",
    "objects": "shape shapes primitive primitives geometry geometries mesh meshes entity entities thing things "
    "item items body bodies model models sphere spheres plane planes box boxes world scene",
    "render": "renderer rendering settings integrator options background samples spp maxdepth eyefalloff",
    "image": "film output picture exposure tone tonemap tonemapping display",
    "version": "format formatversion schemaversion",
    "type": "kind shape primitive geometry class object",
    "position": "center centre location origin pos translate translation point place at offset eye from lookfrom "
    "cameraposition xyz coordinates coords",
    "look_at": "lookat target to at lookto focus aim pointat direction interest viewat",
    "up": "vup upvector updirection worldup",
    "resolution": "size dimensions width height imagesize pixels filmsize res",
    "fov": "angle fieldofview fovy vfov yfov viewangle fovdegrees",
    "intensity": "power energy brightness strength watts wattage emission emitted flux radiance luminosity lumens",
    "color": "colour rgb rgba albedo material diffuse diffusecolor basecolor reflectance reflectivity kd tint "
    "surface paint pigment texture hue",
    "name": "id label title identifier",
    "normal": "n norm direction orientation facing up",
    "size": "dimensions dimension dims dim extent extents scale sides side edge edges lengths halfsize "
    "halfextents halfextent width height depth length",
    "radius": "r rad diameter size scale width",
    "rotation": "rotate rotated rot angle yaw turn heading orientation rotationy rotatey degrees",
    "light": "lights lamp emission emissive emitter emit emits lightsource glow pointlight",
    "samples": "spp samplesperpixel samplecount antialiasing aa rays raysperpixel",
    "background": "sky skycolor backgroundcolor bg backdrop environment ambient",
    "max_depth": "depth bounces maxbounces recursion recursiondepth maxrecursion raydepth",
    "eye_falloff": "falloff attenuation eyeattenuation",
    "exposure": "ev stops brightness gain",
    "tone": "tonemap tonemapping tonemapper tonecurve curve mapping operator filmic",
}
_KEYS_OF_WORD: dict[str, list[str]] = {}
for _key, _words in _WORDS_FOR_KEYS.items():
    for _word in _words.split():
        _KEYS_OF_WORD.setdefault(_word, []).append(_key)

_WORDS_FOR_TYPES = {
    "sphere": "ball orb globe bubble marble bead planet uvsphere icosphere ellipsoid spheroid",
    "plane": "floor ground wall ceiling surface backdrop infiniteplane halfspace sheet quad",
    "box": "cube cuboid block brick crate rectangle rect rectangularprism prism slab rectcuboid hexahedron aabb",
}
_TYPE_OF_WORD = {word: kind for kind, words in _WORDS_FOR_TYPES.items() for word in words.split()}

# One number each, where the key they stand for is a list: their values are no value of it.
_SINGLE_SIDES = frozenset({"width", "height", "depth", "length", "side", "edge"})

# Longer words stand for nothing.
_LONGEST_WORD = 60


def suggested_key(key: str, known: Collection[str], missing: Collection[str] = ()) -> str | None:
    """Return the key that an unknown one probably means, or None.

    Parameters
    ----------
    key
        As the file has it.
    known
        The keys that the mapping may have.
    missing
        Those of them that it needs and does not have.
    """
    word = _plain(key)
    words = _KEYS_OF_WORD.get(word, ())
    meant = [name for name in known if _plain(name) == word] + [name for name in words if name in known]
    if not meant:
        return None if words else nearest(key, known)  # a key of another mapping means none of this one
    return next((name for name in meant if name in missing), meant[0])


def suggested_type(word: str, known: Collection[str]) -> str | None:
    """Return the type of object that an unknown one probably means, or None."""
    meant = _TYPE_OF_WORD.get(_plain(word))
    return meant if meant in known else nearest(word, known)


def is_value_of_another_kind(key: str, meant: str) -> bool:
    """Return whether what a key holds cannot be taken for the value of the key that is meant."""
    if meant == "look_at":
        return _plain(key) == "direction"  # no point, but the way from the eye
    return meant in ("size", "resolution") and _plain(key) in _SINGLE_SIDES


def _plain(word: str) -> str:
    return word[:_LONGEST_WORD].strip().lower().replace("_", "").replace("-", "").replace(" ", "")
