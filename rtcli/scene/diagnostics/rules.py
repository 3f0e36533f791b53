"""The rules of scene files: each has a code that never changes its meaning, and a remedy.

Codes are grouped: E0 the text, E1 its structure, E2 single values, E3 values that must fit each other; W warnings,
which leave a scene valid. `docs/diagnostics.md` is generated from this table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rtcli.scene.diagnostics.synonyms import WORDS_FOR_SHAPES, plural

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
    "The file is larger than 64 MiB, which holds half a million objects.",
    "split the scene, or leave out what the camera does not see",
)
CHARACTER = Rule(
    "E003",
    "character-not-allowed",
    "A control character, or half of a surrogate pair.",
    "remove it, or write it as an escape in a quoted text",
)
YAML_SYNTAX = Rule("E004", "yaml-syntax", "The text is not YAML.", "see what stands just before as well")
JSON_SYNTAX = Rule("E005", "json-syntax", "The text is not JSON.", "see what stands just before as well")
SECOND_DOCUMENT = Rule(
    "E006", "second-document", "The file holds more than one YAML document.", "use a file for each scene"
)
TOO_DEEP = Rule(
    "E007", "nested-too-deep", "Lists and mappings nest more than 64 deep; a scene nests 5.", "flatten it"
)
TOO_MANY_VALUES = Rule(
    "E008",
    "too-many-values",
    "The file holds more than 3,000,000 values, counted with all aliases and merge keys expanded.",
    "split the scene; if it is small, its aliases multiply each other",
)
TOO_LONG = Rule(
    "E009", "text-too-long", "A key or value has more than 10,000 characters.", "no value of a scene is that long"
)
TAG = Rule("E010", "tag", "A YAML tag such as `!!int`.", "remove the tag: values have their types without it")
UNKNOWN_ALIAS = Rule(
    "E011",
    "unknown-alias",
    "An alias without an anchor before it.",
    "put `&name` before the value that it stands for",
)
RECURSIVE_ALIAS = Rule(
    "E012", "recursive-alias", "An alias inside the very value that it stands for.", "write the value out"
)
MERGE = Rule(
    "E013",
    "merge-key",
    "The merge key `<<` with something that is not a mapping.",
    "give an alias of a mapping, such as `<<: *base`, or a list of them",
)
KEY_NOT_TEXT = Rule(
    "E014", "key-not-text", "A key that is a list, a mapping or an alias.", "write the key as plain text"
)
DUPLICATE_KEY = Rule(
    "E015",
    "duplicate-key",
    "A key given twice in one mapping.",
    "keep one of the two",
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
    "Something else where a mapping (`key: value`) belongs.",
    "write `key: value` lines, or {key: value, ...}",
    in_schema=True,
)
NOT_A_LIST = Rule(
    "E102",
    "not-a-list",
    "Something else where a list belongs.",
    "write a list: [a, b, c], or lines that start with `- `",
    in_schema=True,
)
MISSING_KEY = Rule("E103", "missing-key", "A required key is not there.", "add the key", in_schema=True)
UNKNOWN_KEY = Rule(
    "E104",
    "unknown-key",
    "A key that a scene does not have at this place.",
    "correct its name, or remove it",
    in_schema=True,
)
UNKNOWN_TYPE = Rule(
    "E105",
    "unknown-type",
    f"An object whose `type` is not {_series([f'`{shape}`' for shape in WORDS_FOR_SHAPES], 'or')}.",
    f"build it of {_series([plural(shape) for shape in WORDS_FOR_SHAPES], 'and')}",
    in_schema=True,
)
NO_VALUE = Rule("E106", "no-value", "A key without a value.", "give a value, or leave the key out", in_schema=True)
WRONG_LENGTH = Rule(
    "E107", "wrong-length", "A vector, color or resolution with too few or too many numbers.", "", in_schema=True
)
MORE_PROBLEMS = Rule(
    "E108",
    "more-problems",
    "There are more than 1,000 problems; the others are not listed.",
    "mend the listed ones first, and check again",
)

# --- E2: single values -----------------------------------------------------------------------------------

NOT_A_NUMBER = Rule("E201", "not-a-number", "Something else where a number belongs.", "", in_schema=True)
NOT_AN_INTEGER = Rule(
    "E202",
    "not-an-integer",
    "Something else where an integer belongs. A JSON Schema takes `4.0` for one, rtcli does not.",
    "write it without a decimal point",
    in_schema=True,
)
NOT_FINITE = Rule(
    "E203", "not-finite", "Infinity, `.nan`, or a number too large for a 64-bit float.", "give an ordinary number"
)
OUT_OF_RANGE = Rule("E204", "out-of-range", "A number that is too large or too small.", "", in_schema=True)
NOT_A_BOOLEAN = Rule(
    "E205",
    "not-a-boolean",
    "Something else where `true` or `false` belongs. In YAML 1.2 `yes` and `no` are texts.",
    "write true or false",
    in_schema=True,
)
NOT_TEXT = Rule("E206", "not-text", "Something else where a text belongs.", "put it in quotes", in_schema=True)
EMPTY_TEXT = Rule("E207", "empty-text", "An empty name.", "give a name, or leave the key out", in_schema=True)
NOT_A_CHOICE = Rule("E208", "not-a-choice", "A value that is not one of those there are.", "", in_schema=True)
NOT_A_COLOR = Rule(
    "E209",
    "not-a-color",
    "A value that is no color.",
    'give [r, g, b], linear; a CSS name such as tomato; or "#rrggbb" in quotes',
    in_schema=True,
)
UNKNOWN_COLOR = Rule(
    "E210",
    "unknown-color",
    "A text that is neither a CSS color name nor `#rrggbb`.",
    'give [r, g, b], linear; a CSS name such as tomato; or "#rrggbb" in quotes',
    in_schema=True,
)
# --- E3: values that must fit each other -----------------------------------------------------------------

NAME_TAKEN = Rule(
    "E301", "name-taken", "A name that another object has already.", "names are unique: give another"
)
ZERO_LENGTH = Rule(
    "E302",
    "zero-length",
    "A direction of length 0.",
    "give a direction: at least one of its numbers is not 0",
    in_schema=True,
)
NO_DIRECTION = Rule(
    "E303",
    "no-view-direction",
    "A camera that looks at the point where it stands.",
    "move one of the two, or leave `look_at` out to look along -z",
)
UP_ALONG_VIEW = Rule(
    "E304",
    "up-along-view",
    "An `up` along the view, so that no side of the picture is its top.",
    "choose another `up`, such as [0, 0, -1] for a view straight down",
)

EXCLUDED_KEY = Rule(
    "E305",
    "excluded-key",
    "A camera with two of `fov`, `fov_x` and `intrinsics`, or a matrix beside `position`, `look_at` or `up`.",
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

# --- W: warnings -----------------------------------------------------------------------------------------

NO_LIGHT = Rule(
    "W001",
    "no-light",
    "No light shines: there is none, or none with an intensity and a color above 0.",
    "add one, such as `lights: [{position: [0, 5, 0], intensity: 1000}]`",
)
ENCLOSED_LIGHT = Rule(
    "W002",
    "enclosed-light",
    "A light inside a sphere or box that does not carry it: none of its light comes out. Not reported where the "
    "camera is inside as well, or where the object that carries the light looks out.",
    "move it out, or let the object carry it: `light: {intensity: ...}`",
)
CAMERA_INSIDE = Rule(
    "W003",
    "camera-inside",
    "The camera is inside a sphere or box in which no light shines and no object stands. Objects that cross its "
    "surface do not count.",
    "move the camera or the object, or put a light inside if it is a room",
)
BEHIND_CAMERA = Rule(
    "W004",
    "behind-camera",
    "An object that is wholly behind the camera, carries no light, and casts no shadow into the picture.",
    "turn the camera, or remove the object",
)
OUT_OF_VIEW = Rule(
    "W005",
    "out-of-view",
    "An object in front of the camera, but wholly outside the picture, that carries no light and casts no shadow "
    "into it.",
    "widen `fov`, turn the camera, or remove the object",
)
HIDDEN_INSIDE = Rule(
    "W006",
    "hidden-inside",
    "An object wholly inside another, and the camera outside: it can never be seen.",
    "move it, or remove it",
)
EQUAL_OBJECTS = Rule(
    "W007", "equal-objects", "Two objects that are equal in all but their names.", "remove one of the two"
)
BLACK_PICTURE = Rule(
    "W008",
    "black-picture",
    "The whole picture comes out black at this exposure, as a quick rendering of it in small shows.",
    "raise `image.exposure` or the lights' intensities, or set `exposure: auto`",
)
WHITE_PICTURE = Rule(
    "W009",
    "white-picture",
    "The whole picture comes out white at this exposure, as a quick rendering of it in small shows.",
    "lower `image.exposure` or the lights' intensities, or set `exposure: auto`",
)
BURNT_OUT = Rule(
    "W010",
    "burnt-out",
    "A light so close to a surface that the picture shows it burnt out there: more than fifty times as bright as "
    "white.",
    "move the light away from it, lower the intensity, or let the object carry the light",
)
MORE_WARNINGS = Rule(
    "W011",
    "more-warnings",
    "There are more than 1,000 warnings; the others are not listed.",
    "mend the listed ones first, and check again",
)
UNKNOWN_IGNORE = Rule(
    "W012",
    "unknown-ignore",
    "A comment `# rtcli: ignore` with a code that is not that of a warning, or without a code.",
    "name warnings by their codes, as in `# rtcli: ignore W003, W005`",
)

RULES: tuple[Rule, ...] = tuple(value for value in list(globals().values()) if isinstance(value, Rule))
BY_CODE: dict[str, Rule] = {rule.code: rule for rule in RULES}
