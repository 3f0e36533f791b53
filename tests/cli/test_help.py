"""The help of each command: it fits a screen, opens with examples that work, and leaves nothing out."""

import itertools
import re
import shlex

import click
import pytest

from rtcli.cli import main

# Made as the program makes it, with the names of the help option: a command keeps those that it sees first.
CONTEXT = main.make_context("rtcli", [], resilient_parsing=True, terminal_width=78)
COMMANDS = {name: main.get_command(CONTEXT, name) for name in main.list_commands(CONTEXT)}
MAX_LINES = {"render": 50, "batch": 51, "dataset": 40}
WIDTH = 80


def help_lines(name):
    """Return the lines of a command's help on a terminal of 80 columns; those of the program for ''."""
    if not name:
        return main.get_help(CONTEXT).splitlines()
    context = click.Context(COMMANDS[name], CONTEXT, info_name=name, terminal_width=78)
    return COMMANDS[name].get_help(context).splitlines()


def section(lines, heading):
    """Return the lines below a heading, up to the next blank line."""
    below = itertools.dropwhile(lambda line: line != f"{heading}:", lines)
    return list(itertools.takewhile(bool, below))[1:]


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_help_fits_a_screen(name):
    lines = help_lines(name)
    assert len(lines) <= MAX_LINES.get(name, 30)
    assert max(map(len, lines)) <= WIDTH


@pytest.mark.parametrize("name", COMMANDS)
def test_help_opens_with_a_sentence_and_one_to_three_examples(name):
    usage, _, sentence, _, heading, *rest = help_lines(name)
    examples = list(itertools.takewhile(bool, rest))
    assert usage.startswith(f"Usage: rtcli {name} ")
    assert re.fullmatch(r"  [A-Z].*\.", sentence)
    assert heading == ("Example:" if len(examples) == 1 else "Examples:")
    assert 1 <= len(examples) <= 3
    assert [example for example in examples if not example.startswith(f"  rtcli {name}")] == []


EXAMPLES = [(name, example) for name, command in COMMANDS.items() for example in command.examples]


@pytest.mark.parametrize(("name", "example"), EXAMPLES, ids=[example for _, example in EXAMPLES])
def test_example_is_a_command_line_that_parses(name, example):
    program, command, *arguments = shlex.split(example)
    assert (program, command) == ("rtcli", name)
    with COMMANDS[name].make_context(name, arguments, CONTEXT) as context:
        assert context.args == []


def test_example_with_an_option_that_does_not_exist_does_not_parse():
    with pytest.raises(click.NoSuchOption):
        COMMANDS["render"].make_context("render", ["my.yaml", "--outptu", "my.png"], CONTEXT)


@pytest.mark.parametrize("name", ["batch", "validate", "explain", "compare"])
def test_command_without_its_arguments_shows_an_example(run, name):
    result = run(name)
    assert result.exit_code == 2
    assert result.stderr.endswith(f". For example: {COMMANDS[name].examples[0]}\n")


@pytest.mark.parametrize(
    ("arguments", "extra"), [(["render", "my.yaml", "my.png"], "my.png"), (["compare", "a", "b", "c", "d"], "c")]
)
def test_argument_too_many_is_told_with_an_example(run, arguments, extra):
    result = run(*arguments)
    assert result.exit_code == 2
    example = COMMANDS[arguments[0]].examples[0]
    assert result.stderr.endswith(f"Error: Unexpected argument '{extra}'. For example: {example}\n")


@pytest.mark.parametrize("name", COMMANDS)
def test_each_option_is_listed_once_and_says_what_it_does(name):
    lines = help_lines(name)
    for option in COMMANDS[name].get_params(CONTEXT):
        if isinstance(option, click.Option):
            (line,) = [line for line in lines if re.match(rf"  (-\w, )?{option.opts[-1]}\b(?!-)", line)]
            assert re.search(r"  [A-Z][a-z-]+ ", line), "a verb"


@pytest.mark.parametrize(
    ("name", "headings"),
    [
        ("render", ["Options", "Golden pictures", "Cluster"]),
        ("batch", ["Options", "Sweeps", "Golden pictures", "Cluster"]),
        ("compare", ["Options"]),
    ],
)
def test_options_are_in_groups_and_the_first_begins_with_the_most_used(name, headings):
    lines = help_lines(name)
    found = [line.removesuffix(":") for line in lines if re.fullmatch(r"[A-Z][\w ]+:", line)]
    assert found == ["Examples", "Positional arguments", *headings]
    used_most = {"render": "  -o, --output OUT", "batch": "  -o, --output DIR", "compare": "  --tolerance T"}
    assert section(lines, "Options")[0].startswith(used_most[name])


@pytest.mark.parametrize("name", ["render", "batch"])
def test_descriptions_of_all_groups_stand_in_one_column(name):
    rows = [re.match(r"  (-\S.*?)  +(?=\S)", line) for line in help_lines(name)]
    assert len({row.end() for row in rows if row}) == 1
