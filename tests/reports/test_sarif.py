"""SARIF 2.1.0, checked by its JSON Schema and by the rules of the standard that a schema cannot express."""

import copy
import json
import os
import re
import shutil
import subprocess
from pathlib import Path, PurePath
from urllib.parse import unquote_to_bytes, urlsplit

import jsonschema
import pytest
import random_problems
from click.testing import CliRunner
from hypothesis import given

from rtcli import __version__
from rtcli.cli import main
from rtcli.lint.check import check
from rtcli.reports import sarif
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import Problem, Span
from rtcli.scene.diagnostics.rules import BY_CODE, ERROR, OUT_OF_RANGE, RULES

# It ships the unchanged schema of OASIS.
CRATE, CRATE_VERSION = "serde-sarif", "0.8.0"
MANIFEST = f"""
[package]
name = "schema"
version = "0.0.0"
edition = "2021"
[lib]
path = "lib.rs"
[dependencies]
{CRATE} = {{ version = "={CRATE_VERSION}", default-features = false }}
"""

TESTS = Path(__file__).parents[1] / "data"
CORPUS = sorted(
    path
    for folder in ("invalid", "lint")
    for path in (TESTS / folder).glob("*")
    if path.suffix in {".yaml", ".json"}
)

# RFC 3986, appendix A, as far as a path goes: a reference without a scheme has no colon in its first segment.
_PCHAR = r"[A-Za-z0-9\-._~!$&'()*+,;=@:]|%[0-9A-F]{2}"
_SEGMENT_WITHOUT_COLON = rf"(?:(?!:)(?:{_PCHAR}))+"
URI = re.compile(rf"https?://[a-z0-9.\-]+(?:/(?:{_PCHAR})*)*|file://(?:/(?:{_PCHAR})*)+")
RELATIVE = re.compile(rf"{_SEGMENT_WITHOUT_COLON}(?:/(?:{_PCHAR})*)*")

FORMATS = jsonschema.FormatChecker()


# The checker supports these two only with another package.
@FORMATS.checks("uri")
def is_uri(text):
    return URI.fullmatch(text) is not None


@FORMATS.checks("uri-reference")
def is_uri_reference(text):
    return is_uri(text) or RELATIVE.fullmatch(text) is not None


@pytest.fixture(scope="session")
def schema(pytestconfig, tmp_path_factory):
    """Return the schema, fetched once with cargo: the repository does not hold it."""
    kept = pytestconfig.cache.mkdir(f"{CRATE}-{CRATE_VERSION}") / "schema.json"
    if not kept.exists():
        if not (cargo := shutil.which("cargo")):
            pytest.skip("cargo, which fetches the schema of SARIF, is not installed: reports are not checked")
        folder = tmp_path_factory.mktemp("schema")
        (folder / "Cargo.toml").write_text(MANIFEST, encoding="utf-8")
        (folder / "lib.rs").touch()
        result = subprocess.run([cargo, "vendor"], cwd=folder, capture_output=True, text=True)
        if result.returncode:
            pytest.skip(f"the schema of SARIF cannot be fetched: reports are not checked: {result.stderr}")
        # In one step, since tests in other processes may look for it meanwhile.
        shutil.copy(folder / "vendor" / CRATE / "src" / "schema.json", folder / "schema.json")
        (folder / "schema.json").replace(kept)
    return json.loads(kept.read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def validate(schema):
    """Raise jsonschema.ValidationError for a log that is not SARIF."""
    return jsonschema.Draft7Validator(schema, format_checker=FORMATS).validate


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def logged(*arguments, **options):
    """Return the log that `rtcli validate` writes."""
    result = CliRunner().invoke(main, ["validate", *arguments, "--format", "sarif"], **options)
    return json.loads(result.stdout)


def log_of(*checks):
    return json.loads("".join(sarif.report(checks, __version__)))


def results_of(log):
    (run,) = log["runs"]
    return run["results"]


def uri_of(result):
    return result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]


def region_of(result):
    return result["locations"][0]["physicalLocation"]["region"]


def problem(message="wrong", help="", path="a.yaml"):
    return Problem(OUT_OF_RANGE, Span(path, 1, 1, 1, 2), message, help)


# --- The schema ------------------------------------------------------------------------------------------


def test_log_without_problems_is_sarif(validate, folder):
    (folder / "scenes").mkdir()
    log = logged("scenes")
    validate(log)
    assert results_of(log) == []
    assert log["version"] == "2.1.0"


def test_log_of_all_wrong_files_of_the_tests_is_sarif(validate):
    assert len(CORPUS) > 50
    log = logged(*map(str, CORPUS))
    validate(log)
    assert len(results_of(log)) > 100


@given(checks=random_problems.checks())
def test_log_of_any_problems_is_sarif(validate, checks):
    validate(log_of(*checks))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("version",), "2.0.0"),
        (("runs", 0, "columnKind"), "bytes"),
        (("runs", 0, "results", 0, "level"), "fatal"),
        (("runs", 0, "results", 0, "message"), "wrong"),
        (("runs", 0, "results", 0, "column"), 1),
        (("runs", 0, "results", 0, "locations", 0, "physicalLocation", "region", "startLine"), 0),
        (("runs", 0, "results", 0, "locations", 0, "physicalLocation", "artifactLocation", "uri"), "a b.yaml"),
        (("runs", 0, "results", 0, "locations", 0, "physicalLocation", "artifactLocation", "uri"), "c:/b.yaml"),
        (("runs", 0, "tool", "driver", "rules", 0, "id"), None),
    ],
)
def test_log_with_a_mistake_is_refused(validate, path, value):
    log = log_of(FileReport("a.yaml", (problem(),)))
    validate(log)
    broken = copy.deepcopy(log)
    *way, last = path
    node = broken
    for step in way:
        node = node[step]
    node[last] = value
    with pytest.raises(jsonschema.ValidationError):
        validate(broken)


# --- Rules -----------------------------------------------------------------------------------------------


def test_rule_index_of_each_result_is_right():
    log = logged(*map(str, CORPUS))
    rules = log["runs"][0]["tool"]["driver"]["rules"]
    assert [rule["id"] for rule in rules] == list(BY_CODE)
    for result in results_of(log):
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]


def test_rules_have_the_properties_that_code_scanning_requires():
    """GitHub's "SARIF support for code scanning": none is empty, none longer than 1024 characters."""
    for rule in log_of()["runs"][0]["tool"]["driver"]["rules"]:
        for key in ("shortDescription", "fullDescription", "help"):
            assert 0 < len(rule[key]["text"]) <= 1024


def test_level_of_a_rule_is_its_severity():
    levels = {
        rule["id"]: rule["defaultConfiguration"]["level"]
        for rule in log_of()["runs"][0]["tool"]["driver"]["rules"]
    }
    assert levels == {rule.code: rule.severity for rule in RULES}


def test_strict_warnings_are_errors(validate, folder):
    (folder / "dark.yaml").write_text("camera: {resolution: [4, 3], fov: 40}\n")
    (loose,), (strict,) = results_of(logged("dark.yaml")), results_of(logged("dark.yaml", "--strict"))
    assert (loose["ruleId"], loose["level"]) == ("W001", "warning")
    assert strict == {**loose, "level": "error"}
    validate(logged("dark.yaml", "--strict"))


# --- Messages --------------------------------------------------------------------------------------------


def shown(message):
    """Return the text of a message without arguments, as the standard displays it (section 3.11.5)."""
    text = message["text"]
    assert not re.search(r"(?<!\{)(?:\{\{)*\{(?!\{)|(?<!\})(?:\}\})*\}(?!\})", text), "a brace stands alone"
    return text.replace("{{", "{").replace("}}", "}")


def test_braces_in_a_message_are_not_placeholders():
    (result,) = results_of(log_of(FileReport("a.yaml", (problem("got {0}", help="light: {intensity: {}}"),))))
    assert shown(result["message"]) == "got {0}\nhelp: light: {intensity: {}}"


def test_braces_in_the_texts_of_rules_are_not_placeholders():
    rules = log_of()["runs"][0]["tool"]["driver"]["rules"]
    for described, rule in zip(rules, RULES, strict=True):
        assert shown(described["shortDescription"]) == rule.summary
        assert shown(described["help"]) == (rule.remedy or rule.summary)


# --- Places ----------------------------------------------------------------------------------------------


def text_of(region, text):
    """Return the part of a text that a region selects, by the standard (section 3.30), line by line."""
    lines = re.split(r"\r\n|\r|\n", text)[region["startLine"] - 1 : region["endLine"]]
    assert len(lines) == region["endLine"] - region["startLine"] + 1
    assert 1 <= region["startColumn"] <= len(lines[0]) + 1
    assert 1 <= region["endColumn"] <= len(lines[-1]) + 1
    lines[-1] = lines[-1][: region["endColumn"] - 1]  # the column after the last one
    lines[0] = lines[0][region["startColumn"] - 1 :]
    return "\n".join(lines)


@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
def test_region_is_the_wrong_value_in_characters(folder, line_end):
    scene = "camera: {resolution: [4, 3], fov: 200}\n# 日本 😀\n'日本😀': 1\nobjects: [{type: 😀é}]\n"
    (folder / "a.yaml").write_bytes(scene.replace("\n", line_end).encode())
    log = logged("a.yaml")
    assert log["runs"][0]["columnKind"] == "unicodeCodePoints"
    assert line_end in log["runs"][0]["newlineSequences"]
    assert [text_of(region_of(result), scene) for result in results_of(log)] == ["200", "'日本😀'", "😀é"]


def test_regions_of_all_wrong_files_of_the_tests_are_within_them():
    for path in CORPUS:
        raw = path.read_bytes()
        log = log_of(FileReport(path.name, check(raw, path.name).problems))
        for result in results_of(log):
            text_of(region_of(result), raw.decode("utf-8-sig", errors="replace"))


def test_location_in_the_scene_is_the_logical_location(folder):
    (folder / "a.yaml").write_text("camera: {resolution: [4, 3], fov: 200}\n")
    (result,) = results_of(logged("a.yaml"))
    assert result["locations"][0]["logicalLocations"] == [{"fullyQualifiedName": "camera.fov"}]


# --- Paths -----------------------------------------------------------------------------------------------

NAMES = [
    "plain.yaml",
    "with spaces.yaml",
    "#1.yaml",
    "100%.yaml",
    "%41.yaml",
    "brüder-日本.yaml",
    "a;b,c&d=e+f@g!h$i'j(k).yaml",
    "{0}[a](b).yaml",
    "sub/deeper/a.yaml",
]
POSIX_NAMES = ["why?.yaml", "c:a.yaml", "c:/a.yaml", "\x1b[2J\n.yaml", 'a"<b>|*\\.yaml', "\udcff.yaml"]


def path_of(uri):
    """Return the path of a URI reference (RFC 3986, section 2; RFC 8089)."""
    parts = urlsplit(uri)
    assert (parts.query, parts.fragment, parts.netloc) == ("", "", "")
    return os.fsdecode(unquote_to_bytes(parts.path))


@pytest.mark.parametrize("name", NAMES if os.name == "nt" else NAMES + POSIX_NAMES, ids=ascii)
def test_uri_resolves_to_the_file_whatever_its_name(folder, name):
    try:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("3")
    except OSError as error:
        pytest.skip(f"this system has no such names: {error}")
    (result,) = results_of(logged(name))
    assert is_uri_reference(uri_of(result))
    assert not urlsplit(uri_of(result)).scheme
    assert path_of(uri_of(result)) == name


@given(path=random_problems.PATHS)
def test_uri_resolves_to_any_path(path):
    (result,) = results_of(log_of(FileReport(path, (problem(path=path),))))
    assert is_uri_reference(uri_of(result))
    assert PurePath(path_of(uri_of(result))) == PurePath(path)


def test_uri_of_an_absolute_path_is_a_file_uri(validate, folder):
    (folder / "a b.yaml").write_text("3")
    log = logged(str(folder / "a b.yaml"))
    validate(log)
    (result,) = results_of(log)
    assert uri_of(result) == (folder / "a b.yaml").as_uri()
    assert uri_of(result).startswith("file:///")


def test_problems_of_standard_input_have_a_uri(validate):
    log = logged("-", input="3")
    validate(log)
    (result,) = results_of(log)
    assert path_of(uri_of(result)) == "<stdin>"


# --- Files that cannot be read ---------------------------------------------------------------------------


def test_file_that_cannot_be_read_is_a_notification(validate, folder):
    (folder / "wrong.yaml").write_text("3")
    log = logged("lost {0}.yaml", "wrong.yaml")
    validate(log)
    (run,) = log["runs"]
    (invocation,) = run["invocations"]
    assert invocation["executionSuccessful"] is False
    (notification,) = invocation["toolExecutionNotifications"]
    assert notification["level"] == ERROR
    assert notification["message"]["text"] == os.strerror(2)
    assert path_of(uri_of(notification)) == "lost {0}.yaml"
    assert [uri_of(result) for result in run["results"]] == ["wrong.yaml"]


def test_execution_is_successful_if_all_files_can_be_read(folder):
    (folder / "wrong.yaml").write_text("3")
    (invocation,) = logged("wrong.yaml")["runs"][0]["invocations"]
    assert invocation == {"executionSuccessful": True, "toolExecutionNotifications": []}
