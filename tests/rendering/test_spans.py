"""Where values stand: the compiled reader against the exact readers, which say where everything is."""

import json
import random

import pytest
import two_ways
import yaml
from hypothesis import given
from hypothesis import strategies as st
from worlds import random_scenes

from rtcli.lint.check import check
from rtcli.rendering.spans import plain_spans
from rtcli.scene.reading import json_reader, limits, yaml_reader
from rtcli.scene.reading.source import ContainerSpan, Source

TEXTS = two_ways.texts()


def ends(span):
    """Return the start and end of a value, of its keys, and of all values in it."""
    if not isinstance(span, ContainerSpan):
        return span.start, span.end
    keys = {step: (key.start, key.end) for step, key in span.keys.items()}
    return span.start, span.end, keys, {step: ends(value) for step, value in span.values.items()}


def exact(text, name):
    reader = json_reader if name.endswith(".json") else yaml_reader
    return reader.read_exact(Source(name, text.removeprefix("\ufeff"))).root_span


def agrees(text, name):
    """Return whether the compiled reader gives up, or finds what the exact one does."""
    root = plain_spans(text.encode("utf-8", "surrogatepass"), name)
    return root is None or ends(root) == ends(exact(text, name))


@pytest.mark.parametrize(("name", "text"), TEXTS)
def test_places_of_all_values_and_keys_are_exact(name, text):
    assert agrees(text, name)
    assert (plain_spans(text.encode(), name) is None) == ("intrinsics" in text)


@given(
    random_scenes() | random_scenes(emitters=True),
    st.sampled_from([{"default_flow_style": True}, {"default_flow_style": None}, {}]),
)
def test_places_in_any_scene_are_exact(data, style):
    assert agrees(json.dumps(data, indent=1), "a.json")
    assert agrees(yaml.safe_dump(data, **style), "a.yaml")


@given(st.sampled_from(TEXTS), st.integers(0, 2**32))
def test_places_in_changed_text_are_exact(file, seed):
    name, text = file
    assert agrees(two_ways.changed(text, random.Random(seed)), name)


SCENE = """\
# a comment
camera: {resolution: [4, 3], "fov": 40}   # another

objects:
- type: plane
  name: 'é ü'
  position: &p [0, 0, 0]
  normal: [0, 1, 0]
  color: red
  # between

- {type: sphere, position: *p, radius: 1, color: *c}
lights:
  - position: *p
    intensity: 1
    color: &c [1, 1, 1]
"""


@pytest.mark.parametrize("ends_line", ["\n", "\r\n"])
@pytest.mark.parametrize("before", ["", "\ufeff"])
@pytest.mark.parametrize("more", ["", "é" * 3000])
def test_places_are_counted_in_characters(ends_line, before, more):
    text = SCENE.replace("color: *c}", "color: red}").replace("a comment", more).replace("\n", ends_line)
    assert plain_spans((before + text).encode(), "a.yaml") is not None
    assert agrees(before + text, "a.yaml")


def test_alias_stands_where_its_anchor_does():
    text = SCENE.replace("color: *c}", "color: red}")
    root = plain_spans(text.encode(), "a.yaml")
    span, _ = root.find(("objects", 1, "position", 2))
    assert span.start == text.index("0]\n  normal")


def test_only_what_is_there_is_found():
    root = plain_spans(SCENE.replace("color: *c}", "color: red}").encode(), "a.yaml")
    for loc in [
        ("objects", 2),
        ("objects", "x"),
        ("camera", 0),
        ("image",),
        ("camera", "fov", 0),
        ("objects", 0, "é"),
    ]:
        assert not root.find(loc)[1]
    assert len(root.values["camera"].values) == len(root.values["camera"].keys) == 2
    assert len(root.values["objects"].values) == 2
    assert not root.values["objects"].keys
    with pytest.raises(KeyError):
        root.values["objects"].keys[0]


@pytest.mark.integration
def test_valid_file_with_more_values_than_the_exact_reader_takes_has_warnings_only():
    ball = '{"type": "sphere", "position": [0, 0, -9], "radius": 0.001, "color": [1, 1, 1]}'
    beside = ball.replace("[0, 0, -9]", "[900, 0, -9]")
    count = limits.MAX_EXACT_NODES // 11 + 1
    objects = ",\n".join([*[ball] * count, beside])
    text = '{"camera": {"resolution": [8, 6], "fov": 40},\n"objects": [\n' + objects + "\n]}"
    problems = check(text.encode(), "a.json").problems
    outside = [problem for problem in problems if problem.rule.code == "W005"]
    assert [problem.line for problem in outside] == [count + 3]
    assert all(problem.severity == "warning" for problem in problems)
