"""The rules of scene files: each has a code that never changes its meaning, and a remedy.

Codes are grouped: E0 the text, E1 its structure, E2 single values, E3 values that must fit each other, E4
templates; W warnings, which leave a scene valid. `docs/diagnostics.md` is generated from this table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rtcli.scene.diagnostics.synonyms import WORDS_FOR_LIGHTS, WORDS_FOR_SHAPES, plural

ERROR, WARNING = "error", "warning"


@dataclass(frozen=True)
class Rule:
    """A kind of problem that a scene can have.

    Parameters
    ----------
    code
        A stable and unique code: `E204`.
    name
        A short name, also unique: words with hyphens.
    summary
        What breaks the rule, in Markdown, for the documentation.
    remedy
        The general advice; a problem may give a better one.
    in_schema
        Whether the JSON Schema expresses the rule, so that editors report it as well.
    """

    code: str
    name: str
    summary: str
    remedy: str
    in_schema: bool = False

    @property
    def severity(self) -> str:
        """`error`, which makes a scene invalid, or `warning`."""
        return ERROR if self.code.startswith("E") else WARNING


def _series(items: Sequence[str], conjunction: str) -> str:
    return f"{', '.join(items[:-1])} {conjunction} {items[-1]}"


# --- E0: the text ----------------------------------------------------------------------------------------

NOT_UTF8 = Rule("E001", "not-utf-8", "The file is not UTF-8.", "save the file as UTF-8")
FILE_TOO_LARGE = Rule(
    "E002",
    "file-too-large",
    "The file is larger than 128 MiB, which holds a million objects.",
    "split the scene, or remove objects that the camera does not see",
)
CHARACTER = Rule(
    "E003",
    "character-not-allowed",
    "A control character or an unpaired surrogate.",
    "remove it, or write it as an escape in a quoted string",
)
YAML_SYNTAX = Rule("E004", "yaml-syntax", "The file is not valid YAML.", "check the text just before it as well")
JSON_SYNTAX = Rule("E005", "json-syntax", "The file is not valid JSON.", "check the text just before it as well")
SECOND_DOCUMENT = Rule(
    "E006", "second-document", "The file holds more than one YAML document.", "put each scene in its own file"
)
TOO_DEEP = Rule(
    "E007", "nested-too-deep", "Lists and mappings nest more than 64 deep; a scene nests 5.", "flatten it"
)
TOO_MANY_VALUES = Rule(
    "E008",
    "too-many-values",
    "The file holds more than 12,000,000 values, or more than 3,000,000 without being plainly valid; "
    "or aliases add more than 3,000,000.",
    "split the scene; in a small file, look for aliases that multiply each other",
)
TOO_LONG = Rule(
    "E009",
    "text-too-long",
    "A key or value has more than 10,000 characters.",
    "shorten it: no value of a scene is that long",
)
TAG = Rule("E010", "tag", "A YAML tag such as `!!int`.", "remove the tag: values need none")
UNKNOWN_ALIAS = Rule(
    "E011",
    "unknown-alias",
    "An alias without an anchor before it.",
    "put `&name` before the value it refers to",
)
RECURSIVE_ALIAS = Rule("E012", "recursive-alias", "An alias inside the value it refers to.", "write the value out")
MERGE = Rule(
    "E013",
    "merge-key",
    "The merge key `<<` with something that is not a mapping.",
    "use an alias of a mapping, such as `<<: *base`, or a list of such aliases",
)
KEY_NOT_TEXT = Rule(
    "E014", "key-not-text", "A key that is a list, a mapping or an alias.", "write the key as plain text"
)
DUPLICATE_KEY = Rule(
    "E015",
    "duplicate-key",
    "A key that appears twice in one mapping.",
    "remove one of the two",
)
TOO_MANY_KEYS = Rule(
    "E016",
    "too-many-keys",
    "A mapping with more than 100 keys; no part of a scene has more than 9.",
    "remove them",
)

# --- E1: structure ---------------------------------------------------------------------------------------

NOT_A_MAPPING = Rule(
    "E101",
    "not-a-mapping",
    "A value that should be a mapping (`key: value`).",
    "write `key: value` lines, or {key: value, ...}",
    in_schema=True,
)
NOT_A_LIST = Rule(
    "E102",
    "not-a-list",
    "A value that should be a list.",
    "write a list: [a, b, c], or lines that start with `- `",
    in_schema=True,
)
MISSING_KEY = Rule("E103", "missing-key", "A required key is missing.", "add the key", in_schema=True)
UNKNOWN_KEY = Rule(
    "E104",
    "unknown-key",
    "A key that is not allowed here.",
    "correct its name, or remove it",
    in_schema=True,
)
UNKNOWN_TYPE = Rule(
    "E105",
    "unknown-type",
    f"An object whose `type` is not {_series([f'`{shape}`' for shape in WORDS_FOR_SHAPES], 'or')}, "
    f"or a light whose `type` is not {_series([f'`{light}`' for light in WORDS_FOR_LIGHTS], 'or')}.",
    f"build it of {_series([plural(shape) for shape in WORDS_FOR_SHAPES], 'and')}",
    in_schema=True,
)
NO_VALUE = Rule("E106", "no-value", "A key without a value.", "give a value, or remove the key", in_schema=True)
WRONG_LENGTH = Rule(
    "E107", "wrong-length", "A vector, color or resolution with too few or too many numbers.", "", in_schema=True
)
MORE_PROBLEMS = Rule(
    "E108",
    "more-problems",
    "More than 1,000 problems; the rest are not listed.",
    "fix these first, then run the check again",
)

# --- E2: single values -----------------------------------------------------------------------------------

NOT_A_NUMBER = Rule("E201", "not-a-number", "A value that should be a number.", "", in_schema=True)
NOT_AN_INTEGER = Rule(
    "E202",
    "not-an-integer",
    "A value that should be an integer. JSON Schema accepts `4.0` as one; rtcli does not.",
    "write it without a decimal point",
    in_schema=True,
)
NOT_FINITE = Rule(
    "E203", "not-finite", "Infinity, `.nan`, or a number too large for a 64-bit float.", "use a finite number"
)
OUT_OF_RANGE = Rule("E204", "out-of-range", "A number outside the allowed range.", "", in_schema=True)
NOT_A_BOOLEAN = Rule(
    "E205",
    "not-a-boolean",
    "A value that should be `true` or `false`. In YAML 1.2, `yes` and `no` are strings.",
    "write true or false",
    in_schema=True,
)
NOT_TEXT = Rule("E206", "not-text", "A value that should be text.", "quote it", in_schema=True)
EMPTY_TEXT = Rule("E207", "empty-text", "An empty name.", "give a name, or remove the key", in_schema=True)
NOT_A_CHOICE = Rule("E208", "not-a-choice", "A value that is not one of the choices.", "", in_schema=True)
NOT_A_COLOR = Rule(
    "E209",
    "not-a-color",
    "A value that is not a color.",
    'use [r, g, b], linear; a CSS name such as tomato; or "#rrggbb" in quotes',
    in_schema=True,
)
UNKNOWN_COLOR = Rule(
    "E210",
    "unknown-color",
    "Text that is neither a CSS color name nor `#rrggbb`.",
    'use [r, g, b], linear; a CSS name such as tomato; or "#rrggbb" in quotes',
    in_schema=True,
)
# --- E3: values that must fit each other -----------------------------------------------------------------

NAME_TAKEN = Rule(
    "E301", "name-taken", "A name that another object already has.", "choose another name: names must be unique"
)
ZERO_LENGTH = Rule(
    "E302",
    "zero-length",
    "A direction of length 0.",
    "at least one of its numbers must not be 0",
    in_schema=True,
)
NO_DIRECTION = Rule(
    "E303",
    "no-view-direction",
    "A camera whose `look_at` equals its `position`.",
    "change one of them, or remove `look_at` to look along -z",
)
UP_ALONG_VIEW = Rule(
    "E304",
    "up-along-view",
    "An `up` parallel to the viewing direction, which leaves the top of the picture undefined.",
    "choose another `up`, such as [0, 0, -1] for a view straight down",
)

EXCLUDED_KEY = Rule(
    "E305",
    "excluded-key",
    "A camera with two of `fov`, `fov_x`, `intrinsics` and an orthographic `height`, or a matrix beside "
    "`position`, `look_at` or `up`.",
    "remove one of the two",
    in_schema=True,
)
NOT_RIGID = Rule(
    "E306",
    "not-rigid",
    "A matrix of a camera that is no rigid motion: its first three columns must be perpendicular unit vectors, "
    "within 1e-6, and must not mirror the scene.",
    "give a rotation and a translation alone: divide a scale out, and write points as columns",
)
POSES_DIFFER = Rule(
    "E307",
    "poses-differ",
    "Two matrices of a camera that contradict each other.",
    "keep `camera_to_world` of one convention alone",
)
TOO_OBLIQUE = Rule(
    "E308",
    "too-oblique",
    "Intrinsics with a picture farther from the principal point than 1e12 focal lengths.",
    "give the focal lengths and the principal point in pixels",
)

# --- E4: templates of data sets --------------------------------------------------------------------------

NOT_A_DRAW = Rule(
    "E401",
    "not-a-draw",
    "A mapping in place of a value that is not a draw, or a draw that is not allowed there.",
    "write a value, or a draw such as `{uniform: [0, 1]}`",
    in_schema=True,
)
BAD_RANGE = Rule(
    "E402",
    "bad-range",
    "A range that ends before it starts, or has more than a million numbers to choose from.",
    "give the smaller number first",
)
BAD_WEIGHTS = Rule(
    "E403",
    "bad-weights",
    "Weights that are not one for each of the values, or all 0; or a weight beside `choose`.",
    "give one whole number for each value, or leave `weights` out",
)
UNKNOWN_FACTOR = Rule(
    "E404", "unknown-factor", "A factor that the block `dataset` does not define.", "add it to `dataset.factors`"
)
UNKNOWN_TARGET = Rule(
    "E405",
    "unknown-target",
    "A constraint about an object or group that the template does not have, or `rest_on` with a name that is not "
    "that of a plane.",
    "give the `name` of an object or group",
)
NO_REQUIREMENT = Rule(
    "E406",
    "no-requirement",
    "A constraint without a key that names its kind.",
    "add one of `apart`, `in_view`, `min_visible_pixels` and `min_visible_fraction`",
    in_schema=True,
)
NO_LEVELS = Rule(
    "E407",
    "no-levels",
    "A factor without equally frequent levels in a grid or a balanced design.",
    "give it levels, such as `{linspace: [0, 1, 5]}`, or use the design `random` or `sobol`",
)
SPLIT_NAME = Rule(
    "E408",
    "split-name",
    "A name of a split that cannot be the name of a folder on every system.",
    "use at most 64 letters, digits, `_` and `-`",
    in_schema=True,
)
IMPOSSIBLE = Rule(
    "E409",
    "impossible-constraint",
    "A constraint that cannot be met: a margin that leaves nothing of the picture, objects of more pixels than it "
    "has, or more objects at a distance than there is room for.",
    "lower what the constraint asks for",
)

# --- W: warnings -----------------------------------------------------------------------------------------

NO_LIGHT = Rule(
    "W001",
    "no-light",
    "The scene has no light with an intensity and a color above 0.",
    "add one, such as `lights: [{position: [0, 5, 0], intensity: 1000}]`",
)
ENCLOSED_LIGHT = Rule(
    "W002",
    "enclosed-light",
    "A light inside a solid that does not carry it: none of its light comes out. Not reported if the "
    "camera is inside too, or if the object that carries the light reaches outside.",
    "move it out, or let the object carry it: `light: {intensity: ...}`",
)
CAMERA_INSIDE = Rule(
    "W003",
    "camera-inside",
    "The camera is inside a solid that contains no light and no other object. Objects that cross its "
    "surface do not count.",
    "move the camera or the object, or put a light inside if the object is a room",
)
BEHIND_CAMERA = Rule(
    "W004",
    "behind-camera",
    "An object that is entirely behind the camera, carries no light and casts no shadow into the picture.",
    "turn the camera, or remove the object",
)
OUT_OF_VIEW = Rule(
    "W005",
    "out-of-view",
    "An object in front of the camera but entirely outside the picture that carries no light and casts no shadow "
    "into it.",
    "widen `fov`, turn the camera, or remove the object",
)
HIDDEN_INSIDE = Rule(
    "W006",
    "hidden-inside",
    "An object entirely inside another, with the camera outside: it can never be seen.",
    "move it, or remove it",
)
EQUAL_OBJECTS = Rule(
    "W007", "equal-objects", "Two objects that are identical except for their names.", "remove one of the two"
)
BLACK_PICTURE = Rule(
    "W008",
    "black-picture",
    "The whole picture is black at this exposure, according to a quick low-resolution render.",
    "raise `image.exposure` or the lights' intensities, or set `exposure: auto`",
)
WHITE_PICTURE = Rule(
    "W009",
    "white-picture",
    "The whole picture is white at this exposure, according to a quick low-resolution render.",
    "lower `image.exposure` or the lights' intensities, or set `exposure: auto`",
)
BURNT_OUT = Rule(
    "W010",
    "burnt-out",
    "A light so close to a surface that the surface is burnt out in the picture: more than 50 times as bright as "
    "white.",
    "move the light away from it, lower the intensity, or let the object carry the light",
)
MORE_WARNINGS = Rule(
    "W011",
    "more-warnings",
    "More than 1,000 warnings; the rest are not listed.",
    "fix these first, then run the check again",
)
UNKNOWN_IGNORE = Rule(
    "W012",
    "unknown-ignore",
    "A comment `# rtcli: ignore` without a code, or with a code that is not a warning.",
    "list the codes of warnings, as in `# rtcli: ignore W003, W005`",
)
BLOCKED_SUN = Rule(
    "W013",
    "blocked-sun",
    "A sun whose light comes from behind a plane that the camera is before: the plane blocks all of it.",
    "`direction` is where the light goes: with a negative y, such as in [-1, -2, -1], it comes from above",
)
CUT_EMITTER = Rule(
    "W014",
    "cut-emitter",
    "A light with a radius larger than its distance from a surface: the surface cuts the ball that shines, "
    "and what is lit close to it is inaccurate. The object that carries the light does not count.",
    "give it a smaller radius, or move it away from the surface",
)
FINE_CHECKER = Rule(
    "W015",
    "fine-checker",
    "A checker whose squares are all smaller than a pixel: the picture shows noise or a moire pattern.",
    "make the squares larger, or the picture; `samples` of 16 or more blend them",
)

RULES: tuple[Rule, ...] = tuple(value for value in list(globals().values()) if isinstance(value, Rule))
BY_CODE: dict[str, Rule] = {rule.code: rule for rule in RULES}
