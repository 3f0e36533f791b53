"""The reports about wrong scenes.

`tests/data/invalid/` holds wrong files, each beside its exact report.
"""

import json
import re
from pathlib import Path

import expectations
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mutations import VALID, mutated_scenes

from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS, Problem, SceneError, Span
from rtcli.scene.load import load_scene
from rtcli.scene.model import Scene
from rtcli.scene.reading.parse import parse_bytes
from rtcli.scene.validation.validate import validate

INVALID = Path(__file__).parents[2] / "data" / "invalid"
FILES = sorted(path for path in INVALID.iterdir() if path.suffix in {".yaml", ".json"})


def report(raw, name):
    with pytest.raises(SceneError) as refused:
        validate(parse_bytes(raw, name))
    return str(refused.value)


@pytest.mark.parametrize("file", FILES, ids=[file.name for file in FILES])
def test_wrong_file_gets_its_expected_report(file):
    with pytest.raises(SceneError) as refused:
        validate(parse_bytes(file.read_bytes(), file.name))
    expectations.compare(file, refused.value.problems)


def test_each_expectation_has_a_wrong_file_and_a_unique_name():
    expectations = [path.stem for path in INVALID.glob("*.expected")]
    assert sorted(expectations) == [file.stem for file in sorted(FILES, key=lambda file: file.stem)]


# Their files would be large: see tests/scene/test_parse.py.
TOO_LARGE_FOR_THE_CORPUS = {"E002", "E008", "E108"}


def test_each_rule_has_a_wrong_file():
    found = set()
    for file in FILES:
        with pytest.raises(SceneError) as refused:
            validate(parse_bytes(file.read_bytes(), file.name))
        found |= {problem.code for problem in refused.value.problems}
    # Those of templates have theirs in tests/data/template/.
    errors = {rule.code for rule in rules.RULES if rule.code[:2] in ("E0", "E1", "E2", "E3")}
    assert errors - found == TOO_LARGE_FOR_THE_CORPUS


def test_corpus_is_large():
    assert len(FILES) >= 80


def test_problem_holds_its_position_as_data():
    with pytest.raises(SceneError) as refused:
        validate(parse_bytes(b"camera: {resolution: [640, 480], fov: 200}", "scene.yaml"))
    (problem,) = refused.value.problems
    assert problem == Problem(
        rules.OUT_OF_RANGE,
        Span("scene.yaml", line=1, column=39, end_line=1, end_column=42),
        message="must be less than 180, got 200",
        help="Vertical field of view in degrees, between 0 and 180. Example: `fov: 20`",
        pointer="/camera/fov",
        where="camera.fov",
    )
    assert (problem.path, problem.line, problem.column, problem.code) == ("scene.yaml", 1, 39, "E204")


def test_report_names_the_file_as_given(tmp_path):
    file = tmp_path / "wrong.yaml"
    file.write_text("camera: 1\n")
    with pytest.raises(SceneError, match=re.escape(f"{file}:1:9: error: camera: ")):
        load_scene(file)


def test_name_of_a_file_cannot_move_the_cursor():
    assert report(b"camera: 1", "\x1b[2Ja\u202eb.yaml").startswith(r"\x1b[2Ja\u202eb.yaml:1:9: error: ")


@pytest.mark.parametrize("fov", ["180.00001", "180.0000000001"])
def test_refused_number_is_shown_so_that_it_differs_from_its_bound(fov):
    assert report(f"camera: {{resolution: [1, 1], fov: {fov}}}".encode(), "scene.yaml").endswith(
        f"got {fov} [E204]"
    )


@pytest.mark.parametrize("value", ["4.0", "4e0"])
def test_float_where_an_integer_belongs_is_shown_as_a_float(value):
    assert report(f"camera: {{resolution: [{value}, 1], fov: 9}}".encode(), "scene.yaml").endswith(
        f"got {value} [E202]"
    )


@pytest.mark.parametrize("name", ["scene.yaml", "scene.json"])
def test_integer_of_thousands_of_digits_is_too_large(name):
    text = f'{{"camera": {{"resolution": [1, 1], "fov": 1}}, "render": {{"max_depth": {"9" * 5000}}}}}'
    assert "render.max_depth: must be finite, but this number is too large [E203]" in report(text.encode(), name)


# --- Every kind of mistake has a wording ------------------------------------------------------------------

# Phrases of pydantic's own messages.
RAW = re.compile(
    r"Input should|Field required|Extra inputs|valid (tuple|integer|number|string)|pydantic|Traceback"
)


def judge(text, name):
    """Return the scene of a text, or the SceneError that it raises; any other exception fails the test."""
    try:
        return validate(parse_bytes(text.encode(), name))
    except SceneError as error:
        return error


def test_scene_that_is_mutated_below_is_valid():
    assert isinstance(judge(json.dumps(VALID), "scene.json"), Scene)


@given(scene=mutated_scenes(), name=st.sampled_from(["scene.json", "scene.yaml"]))
@example(scene={"camera": {"resolution": [1, 1], "fov": 1}, "image": {"exposure": 10**400}}, name="scene.json")
@example(scene={"version": 10**20, "camera": {"resolution": [1, 1], "fov": 1}}, name="scene.yaml")
@example(scene={"camera": {"resolution": [1, 1], "fov": 1}, "\ud800": 1}, name="scene.json")
@example(scene={"camera": {"resolution": [1, 1], "fov": 1}, "render": {"background": "\ud800"}}, name="scene.json")
@example(
    scene={"camera": {"resolution": [1, 1], "fov": 1, "position": [5e-324, 0, 0], "look_at": [0] * 3}}, name="a"
)
def test_every_mistake_is_reported_in_the_words_of_a_scene_file(scene, name):
    result = judge(json.dumps(scene), name)
    if isinstance(result, SceneError):
        assert result.problems
        for problem in result.problems:
            assert not RAW.search(problem.message)
            assert problem.message.isprintable()
            assert len(problem.message) < 300
            assert problem.line == 1
            assert problem.column >= 1


# --- Many problems ---------------------------------------------------------------------------------------


def test_mistake_repeated_by_a_million_aliases_is_listed_a_limited_number_of_times():
    keys = "".join(f"    k{number}: 1\n" for number in range(90))
    text = (
        "camera: {resolution: [1, 1], fov: 1}\nobjects:\n  - &a\n    type: sphere\n" + keys + "  - *a\n" * 10_000
    )
    lines = report(text.encode(), "scene.yaml").splitlines()
    assert len(lines) == MAX_PROBLEMS + 1
    assert lines[-1] == "scene.yaml:1:1: error: only the first 1,000 problems are listed [E108]"
