"""A small template, and its samples."""

import pytest
from made import made
from template_texts import TEXT

from rtcli.dataset.sample import draw_sample
from rtcli.template.template import parse_template


def parsed(text):
    """Return a template from its text."""
    return parse_template(text.encode(), "t.yaml")


@pytest.fixture(scope="session")
def template():
    """A template with all constraints."""
    return parsed(TEXT)


@pytest.fixture(scope="session")
def samples(template):
    """Its first samples."""
    return [made(template, index, ("depth", "object_id")) for index in range(12)]


@pytest.fixture
def sample_with():
    """Return a function that draws the sample of an index of a template's text."""

    def draw(text, index=0, labels=("train", True)):
        return draw_sample(parsed(text), index, labels=labels)

    return draw
