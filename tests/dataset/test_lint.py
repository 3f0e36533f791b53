import pytest
from template_texts import TEXT

from rtcli.dataset.lint import lint_template
from rtcli.scene.diagnostics import rules
from rtcli.template.template import parse_template


def warnings(text, ignore=()):
    return lint_template(parse_template(text.encode(), "t.yaml"), ignore).problems


def test_template_without_warnings():
    assert warnings(TEXT) == ()


def test_warning_that_holds_for_each_sample_is_at_its_place_in_the_template():
    behind = TEXT.replace("position: [2, 8, -3]", "position: [{uniform: [0, 2]}, -9, 0]")
    [warning] = warnings(behind)
    assert (warning.rule, warning.message) == (
        rules.BLACK_PICTURE,
        "the whole picture is black, as in each of 5 samples",
    )


def test_warning_about_an_object_is_at_its_group():
    text = TEXT.replace("{apart: things, margin: 0.25}", "{apart: things}")
    hidden = "  - {type: sphere, position: [99, 99, {uniform: [99, 100]}], radius: 1, color: red}\n"
    [warning] = warnings(text + hidden)
    assert warning.pointer.startswith("/objects/2")


@pytest.mark.parametrize("seed", range(4))
def test_warning_that_holds_for_some_samples_is_none(seed):
    sometimes = "  - {type: sphere, position: {choice: [[0, 1, 0], [99, 99, 99]]}, radius: 0.1, color: red}\n"
    text = TEXT.replace("    - {apart: things, margin: 0.25}\n", "").replace("seed: 3", f"seed: {seed}")
    assert warnings(text + sometimes) == ()


def test_comments_and_options_ignore_warnings():
    away = "  - {type: sphere, position: [99, 99, 99], radius: 1, color: red}"
    [warning] = warnings(TEXT + away)
    assert warnings(f"{TEXT}{away}  # rtcli: ignore {warning.code}\n") == ()
    assert warnings(TEXT + away, [warning.rule]) == ()


def test_template_without_any_sample_has_no_warnings():
    crowded = TEXT.replace("{integers: [3, 6]}", "2").replace("margin: 0.25", "margin: 7.7")
    assert warnings(crowded.replace("require:", "tries: 1\n  require:")) == ()


def test_many_tries_do_not_hold_up_a_check():
    crowded = TEXT.replace("{integers: [3, 6]}", "2").replace("margin: 0.25", "margin: 7.7")
    assert warnings(crowded.replace("require:", "tries: 10000\n  require:")) == ()
