"""The report of a data set as a page: its content, and its safety with any text."""

import re
from html.parser import HTMLParser

import pytest

from rtcli.reports.dataset_page import ReportedSample, dataset_page
from rtcli.reports.dataset_page.histogram import INTERVALS, MAX_LEVELS, histograms

HOSTILE = "</style><script>alert(1)</script><img src=x onerror=alert(2)>\"'&amp;\u2028\u202e\x00${title}"

SUMMARY = {
    "software": "rtcli 1.2.3",
    "seed": 7,
    "design": "random",
    "splits": {"train": 1900, "test": 98},
    "rejections": {"apart": {"checked": 4000, "refused": 1000}},
    "failures": [{"index": 5, "reason": "apart: a and b"}, {"index": 9, "reason": "apart: a and c"}],
    "template": "dataset:\n  seed: 7\n",
}
PICTURES = [ReportedSample(42, {"hue": 0.25, "sky": "white"}, b"png")]
VALUES = {
    "factors": {"hue": [0.25, 0.5, 0.5]},
    "drawn": {"camera.fov": [30 + 0.1 * number for number in range(100)]},
    "visible_pixels": {"things: visible_pixels": [100, 200, 200]},
}


class Page(HTMLParser):
    """A parsed page: its tags with their attributes, and its text."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.text = [], ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text += data

    def all(self, tag):
        return [attributes for each, attributes in self.tags if each == tag]


def page_of(name="set", read=1998, **changes):
    return dataset_page(name, {**SUMMARY, **changes}, PICTURES, VALUES, read)


def test_page_tells_size_seed_and_version():
    page = Page(page_of())
    assert "1,998 samples · train 1,900 · test 98 · seed 7 · design random · rtcli 1.2.3" in page.text


def test_pictures_stand_in_the_page_with_their_factors():
    page = Page(page_of())
    assert page.all("img") == [{"src": "data:image/png;base64,cG5n", "alt": "Sample 42"}]
    assert "42 hue 0.25, sky white" in page.text


def test_constraints_have_their_share_and_failures_their_reason():
    text = " ".join(Page(page_of()).text.split())
    assert "apart4,0001,00025.0 %" in text
    assert "2 samples left out Sample 5: apart: a and b Sample 9: apart: a and c" in text
    assert "Every index has a sample." in Page(page_of(failures=[])).text
    assert "The template has no constraints." in Page(page_of(rejections={})).text


def test_very_many_failures_are_counted():
    failures = [{"index": index, "reason": "apart"} for index in range(1020)]
    page = Page(page_of(failures=failures))
    assert page.text.count("Sample ") == 20
    assert "1,000 more: see dataset.json" in page.text


def test_share_of_samples_that_was_read_is_told():
    assert "Values of 500 of 1,998 samples" in Page(page_of(read=500)).text
    assert "Values of" not in Page(page_of()).text.replace("Values that", "")


def test_page_has_no_script_and_loads_nothing():
    page = Page(page_of())
    assert not page.all("script")
    [policy] = [each["content"] for each in page.all("meta") if "http-equiv" in each]
    assert policy.startswith("default-src 'none'; ")
    addresses = [attributes[key] for _, attributes in page.tags for key in ("src", "href") if key in attributes]
    assert all(address.startswith("data:") for address in addresses)


def test_texts_are_escaped():
    summary = {key: HOSTILE for key in ("software", "design", "template")}
    failures = [{"index": 0, "reason": HOSTILE}]
    text = dataset_page(
        HOSTILE,
        {**SUMMARY, **summary, "splits": {HOSTILE: 1}, "failures": failures},
        [ReportedSample(0, {HOSTILE: HOSTILE}, b"")],
        {"factors": {HOSTILE: [HOSTILE, "b"]}, "drawn": {HOSTILE: [0.5, 1]}, "visible_pixels": {}},
        1,
    )
    page = Page(text)
    assert not page.all("script")
    assert len(page.all("img")) == 1
    assert not re.search("[\u2028\u202e\x00]", text)
    assert "<script>alert(1)</script>" in page.text


# --- Histograms ---------------------------------------------------------------------------------------------


def test_few_values_are_counted_one_by_one():
    [found] = histograms("n", [3, 1, 3, 2.5, 3])
    assert (found.values, found.counts, found.is_range) == ([1, 2.5, 3], [1, 1, 3], False)


def test_values_that_differ_by_rounding_are_one():
    [found] = histograms("n", [0.3, 0.1 + 0.2])
    assert (found.values, found.counts) == ([0.3], [2])


def test_many_numbers_are_counted_in_equal_intervals():
    numbers = [number / 100 for number in range(2401)]
    [found] = histograms("n", numbers)
    assert found.is_range
    assert found.values == [0, 24]
    assert found.counts == [100] * (INTERVALS - 1) + [101]


def test_many_colors_are_counted_by_channel():
    colors = [(number / 100, 0.5, 0.5) for number in range(100)]
    assert [found.name for found in histograms("color", colors)] == ["color[0]", "color[1]", "color[2]"]


def test_very_many_texts_are_not_counted():
    assert list(histograms("text", [str(number) for number in range(MAX_LEVELS + 1)])) == []


@pytest.mark.parametrize(("color", "shown"), [((1.0, 0.0, 0.0), "red"), ((0.5, 0.25, 0.0), "0.50, 0.25, 0.00")])
def test_color_has_its_name_and_a_swatch(color, shown):
    values = {**VALUES, "drawn": {"color": [color]}}
    text = dataset_page("set", SUMMARY, PICTURES, values, 1)
    assert f'fill="color(srgb-linear {" ".join(f"{each:.4f}" for each in color)})"' in text
    assert shown in Page(text).text
