import gc
import json
import math
import re
import subprocess
import sys
import time

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rtcli.scene.diagnostics.problems import SceneError, printable, quoted
from rtcli.scene.diagnostics.rules import YAML_SYNTAX
from rtcli.scene.reading import json_reader, yaml_reader
from rtcli.scene.reading.limits import MAX_DEPTH
from rtcli.scene.reading.parse import decode, parse, parse_bytes
from rtcli.scene.reading.source import HEAD, KEY, VALUE, Source, dotted, pointer
from rtcli.scene.reading.yaml_reader import read_exact
from rtcli.scene.validation.validate import validate

INFINITY = float("inf")


def data_of(text, name="scene.yaml"):
    document = parse(text, name)
    assert document.problems == []
    return document.data


def problems_of(raw, name="scene.yaml"):
    """Return (line, column, message) of every problem that the reader finds."""
    raw = raw.encode() if isinstance(raw, str) else raw
    try:
        problems = parse_bytes(raw, name).problems
    except SceneError as error:
        problems = error.problems
    return [(problem.line, problem.column, problem.message) for problem in problems]


# --- Scalars: YAML 1.2.2, section 10.3.2, the core schema ------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0", 0),
        ("-0", 0),
        ("12", 12),
        ("+1", 1),
        ("-1", -1),
        ("010", 10),  # not octal, as in YAML 1.1
        ("08", 8),
        ("0o17", 15),
        ("0x10", 16),
        ("0xfF", 255),
        ("1e3", 1000.0),  # text in YAML 1.1
        ("1E3", 1000.0),
        ("4.0e+6", 4e6),
        ("4.0e6", 4e6),
        ("1.5", 1.5),
        (".5", 0.5),
        ("5.", 5.0),
        ("-.5e-3", -0.0005),
        ("+1.", 1.0),
        ("1e400", INFINITY),
        (".inf", INFINITY),
        (".Inf", INFINITY),
        (".INF", INFINITY),
        ("+.inf", INFINITY),
        ("-.inf", -INFINITY),
        ("9" * 300, int("9" * 300)),
        ("9" * 5000, INFINITY),  # too long for Python to convert, and larger than any float
        ("true", True),
        ("True", True),
        ("TRUE", True),
        ("false", False),
        ("False", False),
        ("FALSE", False),
        ("null", None),
        ("Null", None),
        ("NULL", None),
        ("~", None),
        ("", None),
    ],
)
def test_plain_scalar_has_the_value_of_the_core_schema(text, value):
    read = data_of(f"key: {text}")["key"]
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize("text", [".nan", ".NaN", ".NAN"])
def test_not_a_number_is_a_float(text):
    assert math.isnan(data_of(f"key: {text}")["key"])


@pytest.mark.parametrize(
    "text",
    [
        *("no", "yes", "on", "off", "y", "n"),  # booleans in YAML 1.1
        *("12:30", "1:30:00", "2001-01-01"),  # sexagesimals and dates in YAML 1.1
        *("0b1", "1_000", "0o8", "0x", "0xg", "+0x10", "-0o7"),
        *("tRUE", "nULL", "nil", "none"),
        *(".", "+", "-.", "e3", "1e", "1.5.2", "1,000", "inf", "nan", "Infinity", "-.nan", "+.nan", ".iNf"),
        *("٣", "１", "1 2", "=", "4x3"),  # noqa: RUF001 - digits of other scripts are not numbers
    ],
)
def test_any_other_plain_scalar_is_text(text):
    assert data_of(f"key: {text}") == {"key": text}


@pytest.mark.parametrize("text", ["'1'", '"1"', "|-\n  1", ">-\n  1"])
def test_quoted_number_stays_text(text):
    assert data_of(f"key: {text}") == {"key": "1"}


@pytest.mark.parametrize("key", ["1", "true", "null", "1e3", "no"])
def test_key_is_always_text(key):
    assert data_of(f"{key}: value") == {key: "value"}


def test_directive_of_an_older_yaml_changes_no_value():
    assert data_of("%YAML 1.1\n---\nkey: no\n") == {"key": "no"}


# --- The text: encodings, line ends, documents -----------------------------------------------------------


@pytest.mark.parametrize("raw", [b"", b"# only a comment\n", b"---\n", b"null", b"\xef\xbb\xbf"])
def test_empty_file_is_null(raw):
    assert parse_bytes(raw, "scene.yaml").data is None


@pytest.mark.parametrize("name", ["scene.yaml", "scene.json"])
def test_byte_order_mark_is_skipped(name):
    assert parse_bytes(b'\xef\xbb\xbf{"key": 1}', name).data == {"key": 1}


def test_windows_line_ends_are_read():
    document = parse("a: 1\r\nb: [2,\r\n  3]\r\n", "scene.yaml")
    assert document.data == {"a": 1, "b": [2, 3]}
    assert (document.span(("b", 1)).line, document.span(("b", 1)).column) == (3, 3)


@pytest.mark.parametrize(
    ("raw", "line", "column"),
    [
        (b"\xff", 1, 1),
        (b"key: \xff", 1, 6),
        (b"a: 1\nb: \xff", 2, 4),
        (b"a: 1\r\nb: \xff", 2, 4),
        ("ä: ".encode() + b"\xff", 1, 4),  # columns count characters
        (b"key: \xc3", 1, 6),
        (b"\xef\xbb\xbfkey: \xff", 1, 6),  # the byte order mark has no column
        (b"\xef\xbb\xbf" + "a: 1\nä: ".encode() + b"\xff", 2, 4),
        (b"key: \xed\xa0\x80", 1, 6),  # a surrogate
    ],
)
def test_invalid_utf_8_is_reported_at_its_byte(raw, line, column):
    [(*position, message)] = problems_of(raw)
    assert position == [line, column]
    assert message.startswith(f"byte 0x{raw[raw.rfind(b' ') + 1]:02x} is not UTF-8")


@pytest.mark.parametrize("character", ["\x00", "\x07", "\x1b", "\x7f", "\x80", "\ufffe"])
def test_control_character_is_refused_and_shown_as_an_escape(character):
    [(line, column, message)] = problems_of(f"a: ä\nb: {character}")
    assert (line, column) == (2, 4)
    assert printable(character) in message
    assert message.isprintable()


def test_second_document_is_refused_where_it_starts():
    [(line, column, message)] = problems_of("a: 1\n---\nb: 2\n---\nc: 3\n")
    assert (line, column) == (2, 1)
    assert message.startswith("expected one document")


@pytest.mark.parametrize("text", ["--- {a: 1}", "---\na: 1\n...\n"])
def test_markers_of_one_document_are_fine(text):
    assert data_of(text) == {"a": 1}


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("a: b: c", 1, 5),
        ("a: 1\n b: 2", 2, 3),
        ("a: [1, 2\nb: 3", 2, 2),
        ("a: 'x", 1, 6),
        ("}", 1, 1),
        ("a: %b", 1, 4),
        ("a:\n\t- 1", 2, 1),
    ],
)
def test_syntax_error_is_reported_at_its_position(text, line, column):
    [(*position, message)] = problems_of(text)
    assert position == [line, column]
    assert message.startswith("not valid YAML: ")


# --- Keys ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "positions"),
    [
        ("a: 1\na: 2", [(2, 1)]),
        ("a: 1\nb: 2\na: 3\na: 4", [(3, 1), (4, 1)]),
        ("a: {b: 1, b: 2}", [(1, 11)]),
        ("- a: 1\n  a: 2", [(2, 3)]),
        ("1: a\n'1': b", [(2, 1)]),
        ("a: {x: 1}\na: {y: 1, y: 2}", [(2, 1), (2, 11)]),
    ],
)
def test_duplicate_key_is_reported_where_it_is_repeated(text, positions):
    found = problems_of(text)
    assert [(line, column) for line, column, _ in found] == positions
    assert all("duplicate key" in message for _, _, message in found)


def test_equal_keys_of_different_mappings_are_fine():
    assert data_of("- {a: 1}\n- {a: 2}") == [{"a": 1}, {"a": 2}]


@pytest.mark.parametrize(
    ("text", "column"), [("[a]: 1", 1), ("{a: 1}: 1", 1), ("? [a]\n: 1", 3), ("? {a: 1}\n: 1", 3)]
)
def test_key_that_is_not_text_is_refused(text, column):
    assert problems_of(text) == [(1, column, "a key must be text, not a list or a mapping")]


# --- Tags ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "column"),
    [
        ("a: !!int 3", 4),
        ("a: !!str 3", 4),
        ("a: !x {b: 1}", 4),
        ("a: !!python/object/apply:os.system [id]", 4),
        ("a: !<tag:yaml.org,2002:int> 3", 4),
        ("a: ! 3", 4),
        ("!!map {a: 1}", 1),
        ("!!str a: 1", 1),
    ],
)
def test_tag_is_refused(text, column):
    [(line, where, message)] = problems_of(text)
    assert (line, where) == (1, column)
    assert message.startswith("tag `")


# --- Anchors, aliases and merge keys ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("a: &x 1\nb: *x", {"a": 1, "b": 1}),
        ("a: &x [1]\nb: [*x, *x]", {"a": [1], "b": [[1], [1]]}),
        ("a: &x 1\nb: &x 2\nc: *x", {"a": 1, "b": 2, "c": 2}),
        ("a: &x\nb: *x", {"a": None, "b": None}),
        ("&k a: 1\nb: *k", {"a": 1, "b": "a"}),
        ("<<: {a: 1}\nb: 2", {"a": 1, "b": 2}),
        ("a: 0\n<<: {a: 1}", {"a": 0}),
        ("<<: {a: 1}\na: 0", {"a": 0}),
        ("<<: [{a: 1}, {a: 2, b: 3}]", {"a": 1, "b": 3}),
        ("x: &x {a: 1}\ny: {<<: *x, b: 2}", {"x": {"a": 1}, "y": {"a": 1, "b": 2}}),
        ("'<<': 1", {"<<": 1}),
    ],
)
def test_alias_and_merge_key_stand_for_their_anchor(text, data):
    assert data_of(text) == data


@pytest.mark.parametrize(
    ("text", "column", "part"),
    [
        ("a: *x", 4, "no anchor before it"),
        ("a: &x [*x]", 8, "inside its own anchor"),
        ("a: &x {b: [*x]}", 12, "inside its own anchor"),
        ("<<: 3", 5, "merges mappings only"),
        ("<<: [{a: 1}, 3]", 14, "merges mappings only"),
        ("*x : 1", 1, "not an alias"),
    ],
)
def test_alias_or_merge_key_without_a_target_is_refused(text, column, part):
    [(line, where, message)] = problems_of(text)
    assert (line, where) == (1, column)
    assert part in message


# --- Input that is made to hurt --------------------------------------------------------------------------


def _bomb(item):
    levels = "".join(f"k{i}: &k{i} {item(f'*k{i - 1}')}\n" for i in range(1, 30))
    return f"k0: &k0 {{a: 1}}\n{levels}"


@pytest.mark.parametrize(
    "text",
    [
        _bomb(lambda alias: "[" + ", ".join([alias] * 9) + "]"),
        _bomb(lambda alias: "{" + ", ".join(f"{i}: {alias}" for i in range(9)) + "}"),
        "[" * 100_000,
        "{a: " * 100_000,
        "- " * 100_000,
        "[" * (MAX_DEPTH + 1) + "]" * (MAX_DEPTH + 1),
        # Each anchor nests the one before 60 levels deeper: 6,000 in all.
        "".join(f"- &a{n} {'[' * 60}*a{n - 1}{']' * 60}\n" if n else "- &a0 1\n" for n in range(100))
        + "- {a: 1, a: 2}",
    ],
    ids=[
        "lists of aliases",
        "mappings of aliases",
        "lists",
        "mappings",
        "block lists",
        "one too deep",
        "anchors in anchors",
    ],
)
def test_alias_bomb_ends_quickly_with_one_problem(text):
    start = time.perf_counter()
    assert len(problems_of(text)) == 1
    assert time.perf_counter() - start < 60  # without the limits it would take hours


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000])
def test_json_that_exhausts_the_parser_is_a_problem(text):
    assert len(problems_of(text, "scene.json")) == 1


MEBIBYTE = 2**20
SPHERE = "{type: sphere, position: [0, 0, -5], radius: -1, color: red}"


@pytest.mark.integration
@pytest.mark.parametrize(
    ("name", "make", "code"),
    [
        ("large.yaml", lambda: "#" * (128 * MEBIBYTE + 1), "E002"),
        ("lists.yaml", lambda: "a: [" + "[]," * (20 * MEBIBYTE), "E008"),
        ("lists.json", lambda: '{"a": [' + "[]," * (20 * MEBIBYTE), "E008"),
        ("numbers.json", lambda: "[" + "0," * (30 * MEBIBYTE) + "0]", "E008"),
        ("keys.yaml", lambda: "".join(f"k{number}: 1\n" for number in range(2 * MEBIBYTE)), "E016"),
        ("keys.json", lambda: "{" + ",".join(f'"k{number}":1' for number in range(2 * MEBIBYTE)) + "}", "E016"),
        ("text.yaml", lambda: "a: " + "x" * (60 * MEBIBYTE), "E009"),
        ("key.json", lambda: '{"' + "x" * (60 * MEBIBYTE) + '": 1}', "E009"),
        ("escapes.json", lambda: '["' + "\\ud800" * (10 * MEBIBYTE) + '"]', "E009"),
        ("lines.yaml", lambda: "\n" * (60 * MEBIBYTE), "E101"),
        ("one-line.yaml", lambda: "{objects: [" + f"{SPHERE}, " * 50_000 + "]}", "E108"),
        ("wrong.json", lambda: '{"objects": [' + "0, " * MEBIBYTE + "0]}", "E108"),
        ("open.yaml", lambda: "[" * (60 * MEBIBYTE), "E004"),
        ("questions.yaml", lambda: "? " * (30 * MEBIBYTE), "E014"),
        ("quote.yaml", lambda: "a: 'x\n" + "b: c\n" * (10 * MEBIBYTE), "E004"),
        ("aliases.yaml", lambda: "a: [" + "*a," * MEBIBYTE + "]", "E108"),
        ("repeated.json", lambda: "{" + '"a":1,' * MEBIBYTE + '"a":1}', "E108"),
        ("tags.yaml", lambda: "a: [" + "!a 1," * MEBIBYTE + "]", "E108"),
        ("anchors.yaml", lambda: "a: [" + "".join(f"&a{n} 1, " for n in range(MEBIBYTE)) + "]", "E104"),
    ],
)
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits the memory of a process")
def test_hostile_file_is_refused_with_little_memory_and_time(tmp_path, name, make, code):
    (tmp_path / name).write_text(make())
    program = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))\n"
        "from rtcli.cli import main; main(['validate', sys.argv[1], '--format', 'concise'])"
    )
    result = subprocess.run(
        [sys.executable, "-c", program, name], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert (result.returncode, result.stderr) == (1, "")
    assert f"[{code}]" in result.stdout
    assert len(result.stdout) < 200_000


def test_nesting_up_to_the_limit_is_read():
    assert data_of("[" * MAX_DEPTH + "]" * MAX_DEPTH)


# --- Places ----------------------------------------------------------------------------------------------

SPANS = """\
camera:
  resolution: [640, 480]
lights: []
objects:
  - type: sphere
    position: [0, 1,
      2]
    "color": &red [1, 0, 0]
  - {type: box, color: *red}
"""


@pytest.mark.parametrize(
    ("loc", "line", "column"),
    [
        ((), 1, 1),
        (("camera",), 2, 3),
        (("camera", "resolution"), 2, 15),
        (("camera", "resolution", 1), 2, 21),
        (("lights",), 3, 9),
        (("objects",), 5, 3),
        (("objects", 0), 5, 5),
        (("objects", 0, "position", 2), 7, 7),
        (("objects", 0, "color"), 8, 19),  # without its anchor
        (("objects", 1, "type"), 9, 12),
        (("objects", 1, "color", 1), 8, 23),  # an alias: the span of its anchor's value
        (("objects", 1, "radius"), 9, 5),  # missing: the mapping around it
        (("objects", 7), 5, 3),
    ],
)
def test_span_of_a_value_starts_at_its_first_character(loc, line, column):
    span = parse(SPANS, "scene.yaml").span(loc)
    assert (span.path, span.line, span.column) == ("scene.yaml", line, column)


@pytest.mark.parametrize(
    ("loc", "line", "column"),
    [(("camera",), 1, 1), (("camera", "resolution"), 2, 3), (("objects", 0, "color"), 8, 5), (("none",), 1, 1)],
)
def test_span_of_a_key_starts_at_its_first_character(loc, line, column):
    span = parse(SPANS, "scene.yaml").span(loc, KEY)
    assert (span.line, span.column) == (line, column)


def test_json_values_have_spans():
    span = parse('{\n\t"a": [1,\n  22]}', "scene.json").span(("a", 1))
    assert (span.line, span.column) == (3, 3)


@pytest.mark.parametrize(
    ("loc", "as_pointer", "as_written"),
    [
        ((), "", ""),
        (("camera", "fov"), "/camera/fov", "camera.fov"),
        (("objects", 2, "radius"), "/objects/2/radius", "objects[2].radius"),
        (("a/b", "c~d"), "/a~1b/c~0d", "a/b.c~d"),
    ],
)
def test_location_is_written_as_json_pointer_and_as_path(loc, as_pointer, as_written):
    assert pointer(loc) == as_pointer
    assert dotted(loc) == as_written


# --- Both ends of a span ---------------------------------------------------------------------------------

ENDS = """\
camera: {resolution: [640, 480], fov: 40}  # a camera
objects:
  - type: sphere
    name: 'a ball'
    color: &red [1,
      0, 0]
    light:
      intensity: 9

  - &box !x {type: box}
  - |
    some
    text

  - two
    lines
version:
"""


@pytest.mark.parametrize(
    ("loc", "what", "shown"),
    [
        (("camera",), VALUE, "{resolution: [640, 480], fov: 40}"),
        (("camera", "resolution"), VALUE, "[640, 480]"),
        (("camera", "resolution", 1), VALUE, "480"),
        (("camera", "fov"), KEY, "fov"),
        (("camera", "fov"), VALUE, "40"),
        (("camera",), HEAD, "{"),
        (("camera", "up"), VALUE, "{"),  # missing: the first token of the value around it
        (("objects",), HEAD, "-"),
        (("objects", 0), HEAD, "type"),
        (("objects", 0, "radius"), VALUE, "type"),
        (("objects", 0), VALUE, ENDS[ENDS.index("type: sphere") : ENDS.index("\n\n  - &box")]),
        (("objects", 0, "name"), VALUE, "'a ball'"),
        (("objects", 0, "color"), VALUE, "[1,\n      0, 0]"),
        (("objects", 0, "light"), VALUE, "intensity: 9"),
        (("objects", 1), VALUE, "{type: box}"),
        (("objects", 2), VALUE, "|\n    some\n    text"),
        (("objects", 3), VALUE, "two\n    lines"),
        (("version",), VALUE, ""),
        ((), HEAD, "camera"),
    ],
)
def test_span_holds_exactly_the_token(loc, what, shown):
    assert spanned(read_exact(Source("scene.yaml", ENDS)).span(loc, what), ENDS) == shown


def spanned(span, text):
    """Return the part of a text that a span covers, by its lines and columns."""
    starts = [0, *(match.end() for match in re.finditer(r"\r\n|\r|\n", text))]
    first = starts[span.line - 1] + span.column - 1
    return text[first : starts[span.end_line - 1] + span.end_column - 1]


@given(data=st.deferred(lambda: DATA), indent=st.sampled_from([None, 2]), is_json=st.booleans())
def test_spans_hold_the_text_of_json_values(data, indent, is_json):
    text = json.dumps(data, ensure_ascii=False, indent=indent)
    document = (json_reader if is_json else yaml_reader).read_exact(Source("scene", text))
    for loc, value in all_values(data, ()):
        assert repr(json.loads(spanned(document.span(loc), text))) == repr(value)
        if loc and isinstance(loc[-1], str):
            assert json.loads(spanned(document.span(loc, KEY), text)) == loc[-1]


def all_values(node, loc):
    """Yield the location and value of a node and of every node in it."""
    yield loc, node
    for step, child in (
        node.items() if isinstance(node, dict) else enumerate(node if isinstance(node, list) else ())
    ):
        yield from all_values(child, (*loc, step))


@pytest.mark.parametrize("separator", ["\x85", "\u2028", "\u2029"])
def test_line_separators_that_editors_do_not_count_are_not_counted(separator):
    text = f'a: "x{separator}y"\nb: {{c: 1, c: 2}}\n'
    assert [(line, column) for line, column, _ in problems_of(text)] == [(2, 11)]


# --- JSON ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("", 1, 1),
        ("[1", 1, 3),
        ('{"a" 1}', 1, 6),
        ('{"a": 1}\nx', 2, 1),
        ("{'a': 1}", 1, 2),
        ("a: 1", 1, 1),
        ('// comment\n{"a": 1}', 1, 1),
    ],
)
def test_json_syntax_error_is_reported_at_its_position(text, line, column):
    [(*position, message)] = problems_of(text, "scene.json")
    assert position == [line, column]
    assert message.startswith("not valid JSON: ")


def test_json_duplicate_key_is_reported_where_it_is_repeated():
    [(line, column, message)] = problems_of('{"a": 1,\n "b": 2,\n "a": 3}', "scene.json")
    assert (line, column) == (3, 2)
    assert message.startswith("duplicate key `a`")


@pytest.mark.parametrize(
    "text", ['{"camera": NaN}', '{"camera": 1e400}', '{"camera": -Infinity}', f'{{"camera": {"9" * 5_000}}}']
)
def test_json_number_that_is_not_finite_is_left_to_the_models(text):
    assert not math.isfinite(data_of(text, "scene.json")["camera"])


@pytest.mark.parametrize("name", ["scene.json", "SCENE.JSON"])
def test_json_is_recognized_by_its_suffix(name):
    assert problems_of("a: 1", name)


@given(data=st.deferred(lambda: DATA), indent=st.sampled_from([None, 2]), ascii_only=st.booleans())
def test_both_readers_of_json_agree(data, indent, ascii_only):
    source = Source("scene.json", json.dumps(data, ensure_ascii=ascii_only, indent=indent))
    assert repr(json_reader.read_exact(source).data) == repr(json.loads(source.text))


JSON_PIECES = [
    '"a"',
    "1",
    "-0.5e3",
    ":",
    ",",
    "[",
    "]",
    "{",
    "}",
    " ",
    "\n",
    "true",
    "null",
    "NaN",
    '"',
    "\\",
    "01",
    "-",
]


@given(text=st.lists(st.sampled_from(JSON_PIECES), max_size=12).map("".join))
@example(text='{"a":1,}')
@example(text="[1,]")
@example(text='["\t"]')
@example(text="-Infinity")
@example(text="[1]]")
@example(text="1.")
@example(text="\x0c1")
def test_exact_reader_of_json_refuses_what_pythons_parser_refuses(text):
    try:
        expected = repr(json.loads(text))
    except ValueError:
        expected = None
    refused = refusal(json_reader.read_exact, Source("scene.json", text))
    assert (refused is None) == (expected is not None)
    if refused is None and "duplicate" not in str(json_reader.read_exact(Source("a", text)).problems):
        assert repr(json_reader.read_exact(Source("scene.json", text)).data) == expected


def test_surrogate_pair_of_json_is_a_character():
    assert parse('"\\ud83d\\ude00"', "a.json").data == "😀"


# --- Text in messages ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("tall box", "tall box"),
        ("größe ☃", "größe ☃"),
        ("a\x1b[31mb", r"a\x1b[31mb"),
        ("a\nb\tc", r"a\nb\tc"),
        ("a\u202eb", r"a\u202eb"),
        ("a\u2066b", r"a\u2066b"),
        ("a\u200bb", r"a\u200bb"),
        ("a\ud800b", r"a\ud800b"),
        ("a\x9bb", r"a\x9bb"),
        ("\U000e0041", r"\U000e0041"),
    ],
)
def test_quoted_text_is_safe_for_a_terminal(text, shown):
    assert printable(text) == shown
    assert quoted(text) == f"`{shown}`"


def test_long_text_is_cut():
    assert quoted("x" * 10_000) == "`" + "x" * 59 + "…`"


# --- What holds for every text ---------------------------------------------------------------------------

# Characters that json.dumps leaves alone and YAML refuses or folds: lone surrogates, C1 controls, line separators.
CHARACTERS = st.characters(
    exclude_categories=("Cs", "Zl", "Zp"),
    exclude_characters=[*map(chr, range(0x7F, 0xA0)), "\ufeff", "\ufffe", "\uffff"],
)
TEXTS = st.text(CHARACTERS, max_size=20)
LEAVES = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | TEXTS
DATA = st.recursive(LEAVES, lambda inner: st.lists(inner) | st.dictionaries(TEXTS, inner), max_leaves=20)


@given(data=DATA, indent=st.sampled_from([None, 2]))
def test_both_formats_read_json_text_as_the_same_data(data, indent):
    text = json.dumps(data, ensure_ascii=False, indent=indent)
    for name in ("scene.json", "scene.yaml"):
        assert repr(data_of(text, name)) == repr(data)  # repr distinguishes 1 from 1.0 and True


PIECES = ["a", "1", ": ", "- ", "\n", " ", "[", "]", "{", "}", ",", "&x ", "*x", "<<", "'", '"', "!x ", "? ", "|"]
YAML_LIKE = st.lists(st.sampled_from(PIECES), max_size=30).map("".join)


def reading(read, text):
    """Return everything that a reader finds in a text: data, problems, and the location of the last value."""
    try:
        document = read(text, "scene.yaml")
    except SceneError as error:
        return error.problems
    loc, data = (), document.data
    while isinstance(data, (dict, list)) and data:
        step = list(data)[-1] if isinstance(data, dict) else len(data) - 1
        loc, data = (*loc, step), data[step]
    return repr(document.data), document.problems, document.problem(YAML_SYNTAX, loc, "here")


def carefully(text, name):
    return read_exact(Source(name, text))


@pytest.mark.parametrize(
    "text",
    [
        *("a: 1\nb: [2, {c: 'd'}]", "[]", "{}", "x", "--- x\n...", "'<<'", "- |\n  a\n", "!", "! a", "a: ! 'b'"),
        *("", "# c", "---", "--- a\n--- b", "--- a\n--- [", "a: [", "a: \x00", "a: \ud800", "'a': 1\na: 2"),
        *("&x a", "&x [1]", "&x a: 1", "&x a: 1\nb: *x", "*x", "? *x\n: 1", "a: &x {b: 1}\nc: *x"),
        *("<<: {a: 1}", "'<<': {a: 1}", "<<: {a: 1}\n<<: {b: 1}", "<<: {a: 1}\n'<<': 2", "'<<': 2\n<<: {a: 1}"),
        *("<<: 3", "<<: [{a: 1}, 3]", "x: &x [{a: 1}, {a: 2, b: 3}]\ny: {<<: *x, a: 0}", "<<: {a: 1}\na: 0"),
        *("a: &x {b: &x 1, c: *x}", "a: &x [1]\nb: &x [*x]", "a: &x 1\nb: &x [*x]", "&x a: 1\nb: [*x, *x]"),
        *("{" + "".join(f"k{number}: 1, " for number in range(count)) + "<<: {a: 1}}" for count in (98, 99, 100)),
        *("!x a", "!x a: 1", "!x [1]", "!x {a: 1}", "[a]: 1", "? {a: 1}\n: 1"),
        *("[" * depth + "]" * depth for depth in (MAX_DEPTH, MAX_DEPTH + 1)),
        *("{a: " * depth + "1" + "}" * depth for depth in (MAX_DEPTH, MAX_DEPTH + 1)),
    ],
)
def test_fast_reader_agrees_with_the_exact_one(text):
    assert reading(parse, text) == reading(carefully, text)


@given(text=YAML_LIKE)
def test_fast_reader_agrees_with_the_exact_one_on_any_text(text):
    assert reading(parse, text) == reading(carefully, text)


@pytest.mark.parametrize(
    "text",
    [
        "- {a: 1, b: [2, 3]}\n- 4",
        "- &a [1, &b 2]\n- *a\n- &c {x: *a, y: *b}\n- [*c, *c]",
        "- &a {x: 1, y: [2]}\n- &b {<<: *a, z: 3}\n- {<<: [*a, *b]}\n- *b",
    ],
)
@pytest.mark.parametrize("bound", range(1, 40))
def test_both_readers_have_the_same_limit_on_values(monkeypatch, bound, text):
    for limit in ("MAX_NODES", "MAX_EXACT_NODES"):
        monkeypatch.setattr(f"rtcli.scene.reading.limits.{limit}", bound)
    assert reading(parse, text) == reading(carefully, text)


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("a: 1", True),
        ("- {a: [1, 'b']}", True),
        ("[" * MAX_DEPTH + "]" * MAX_DEPTH, True),
        ("a: &x 1\nb: *x", True),
        ("<<: {a: 1}\nb: 2", True),
        ("a: 1\na: 2", False),
        ("a: *x", False),
        ("a: &x [*x]", False),
    ],
)
def test_only_a_text_that_needs_the_exact_reader_gets_it(text, plain):
    assert (parse(text, "scene.yaml").root_span is None) is plain


def refusal(read, *arguments, **options):
    """Return the SceneError that a reader raises, or None; any other exception fails the test."""
    try:
        read(*arguments, **options)
    except SceneError as error:
        return error
    return None


@given(text=st.text() | YAML_LIKE, name=st.sampled_from(["scene.yaml", "scene.json"]))
@example(text="\ud800", name="scene.yaml")
@example(text='{"\\ud800": 1}', name="scene.json")
def test_reader_raises_nothing_but_scene_errors_for_any_text(text, name):
    error = refusal(lambda: validate(parse(text, name)))
    assert error is not None
    assert all(problem.message.isprintable() for problem in error.problems)


@given(
    raw=st.binary() | st.binary().map(lambda tail: b"\xef\xbb\xbf" + tail), name=st.sampled_from(["a", "a.json"])
)
@example(raw=b"\xef\xbb\xbf\xc3\xa4: \xff", name="a")
def test_reader_raises_nothing_but_scene_errors_for_any_bytes(raw, name):
    error = refusal(parse_bytes, raw, name)
    assert error is None or error.problems


# --- The rest --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("running", [True, False])
def test_garbage_collector_is_paused_while_parsing_and_then_restored(monkeypatch, running):
    seen = []
    monkeypatch.setattr("rtcli.scene.reading.yaml_reader.plain_scalar", lambda text: seen.append(gc.isenabled()))
    was_running = gc.isenabled()
    try:
        (gc.enable if running else gc.disable)()
        parse("a: 1", "scene.yaml")
        assert gc.isenabled() is running
    finally:
        (gc.enable if was_running else gc.disable)()
    assert seen == [False]


def test_merged_key_keeps_its_span():
    document = parse("base: &base\n  kind: 1\nother:\n  <<: *base\n", "scene.yaml")
    span = document.span(("other", "kind"), KEY)
    assert (span.line, span.column) == (2, 3)


@pytest.mark.parametrize("line_end", [b"\n", b"\r", b"\r\n"])
def test_bad_byte_is_located_with_any_line_ends(line_end):
    with pytest.raises(SceneError) as refused:
        decode(b"a: 1" + line_end + b"b: \xff", "scene.yaml")
    assert [(problem.line, problem.column) for problem in refused.value.problems] == [(2, 4)]


def test_merge_keys_that_multiply_are_refused():
    keys = ", ".join(f"k{number}: 1" for number in range(90))
    text = f"a: &a {{{keys}}}\nb:\n" + "  - {<<: *a}\n" * 25_000
    with pytest.raises(SceneError, match="with all aliases expanded"):
        parse(text, "scene.yaml")
