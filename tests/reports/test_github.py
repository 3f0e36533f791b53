"""Annotations, read back by the rules of GitHub's documentation ("Workflow commands for GitHub Actions")."""

from dataclasses import dataclass
from pathlib import PurePath

import random_problems
from hypothesis import example, given

from rtcli.reports import github
from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics import rules
from rtcli.scene.diagnostics.problems import Problem, Span, printable

# In the order in which the runner undoes them (actions/runner, ActionCommand.cs): % is last, so that it makes no
# new escape with what follows it.
DATA_ESCAPES = {"%0D": "\r", "%0A": "\n", "%25": "%"}
PROPERTY_ESCAPES = {"%0D": "\r", "%0A": "\n", "%3A": ":", "%2C": ",", "%25": "%"}


@dataclass
class Command:
    """A workflow command as the runner parses it."""

    name: str
    properties: dict
    data: str


def unescaped(text, escapes):
    for escape, character in escapes.items():
        text = text.replace(escape, character)
    return text


def parsed(line):
    """Return the command in a line of a log: `::name key=value,key=value::data`."""
    assert line.startswith("::")
    about, _, data = line[2:].partition("::")
    name, _, listed = about.partition(" ")
    properties = {}
    for each in listed.split(","):
        key, _, value = each.partition("=")
        assert key not in properties
        properties[key] = unescaped(value, PROPERTY_ESCAPES)
    return Command(name, properties, unescaped(data, DATA_ESCAPES))


def commands(*checks):
    *lines, rest = "".join(github.report(checks)).split("\n")
    assert rest == ""
    return [parsed(line) for line in lines]


def test_parser_reads_the_examples_of_the_documentation():
    assert parsed("::error file=app.js,line=1,col=5,endColumn=7::Missing semicolon") == Command(
        "error", {"file": "app.js", "line": "1", "col": "5", "endColumn": "7"}, "Missing semicolon"
    )
    assert parsed("::warning title=a%3A%2C%250A::100%25::%0Ab") == Command(
        "warning", {"title": "a:,%0A"}, "100%::\nb"
    )


# Texts that look like escapes, and like commands.
LIKE_ESCAPES = Problem(
    rules.UNKNOWN_KEY,
    Span("%2C,%3A:%25%0A.yaml", 1, 2, 1, 3),
    "unknown key `%0A%25`::error::",
    help="%0D\n::stop-commands::%",
    where="a%25.b",
)


@given(problem=random_problems.problems())
@example(problem=LIKE_ESCAPES)
def test_command_holds_all_parts_of_a_problem(problem):
    (command,) = commands(FileReport("a.yaml", (problem,)))
    expected = {
        "file": printable(PurePath(problem.path).as_posix()),
        "line": str(problem.line),
        "endLine": str(problem.end_line),
        "title": f"rtcli {problem.code}",
    }
    if problem.line == problem.end_line:
        expected |= {"col": str(problem.column), "endColumn": str(problem.end_column)}
    where = f"{printable(problem.where)}: " if problem.where else ""
    help = f"\nhelp: {printable(problem.help)}" if problem.help else ""
    assert command == Command(problem.severity, expected, where + printable(problem.message) + help)


@given(checks=random_problems.checks())
def test_each_problem_and_each_file_that_cannot_be_read_is_one_command(checks):
    expected = [
        name
        for checked in checks
        for name in (["error"] if checked.unreadable else [problem.severity for problem in checked.problems])
    ]
    assert [command.name for command in commands(*checks)] == expected


def test_file_that_cannot_be_read_is_an_error_of_the_file():
    (command,) = commands(FileReport("50%,a:b.yaml", unreadable="No such file: 50%"))
    assert command == Command("error", {"file": "50%,a:b.yaml"}, "No such file: 50%")


# GitHub accepts columns only within one line.
def test_columns_of_a_span_of_several_lines_are_omitted():
    problem = Problem(rules.NAME_TAKEN, Span("a.yaml", 2, 7, 4, 3), "two")
    (command,) = commands(FileReport("a.yaml", (problem,)))
    assert command.properties == {"file": "a.yaml", "line": "2", "endLine": "4", "title": "rtcli E301"}


def test_file_is_named_as_github_does():
    problem = Problem(rules.NAME_TAKEN, Span("./scenes//a.yaml", 1, 1, 1, 2), "two")
    (command,) = commands(FileReport("./scenes//a.yaml", (problem,)))
    assert command.properties["file"] == "scenes/a.yaml"


def test_no_problems_are_no_commands():
    assert commands(FileReport("a.yaml")) == []
