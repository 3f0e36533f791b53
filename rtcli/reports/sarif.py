"""SARIF 2.1.0 (OASIS Standard, 2020), which code scanners and editors exchange.

Of the optional properties, it has those that GitHub's code scanning requires ("SARIF support for code scanning").
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from pathlib import PurePath
from typing import Any
from urllib.parse import quote

from rtcli.reports.file_report import FileReport
from rtcli.scene.diagnostics.problems import Problem
from rtcli.scene.diagnostics.rules import RULES, Rule

_SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"


def report(files: Iterable[FileReport], version: str) -> Iterator[str]:
    """Yield a log with one run of the given version of rtcli."""
    results: list[dict[str, Any]] = []
    notifications: list[dict[str, Any]] = []
    for file in files:
        results += map(_result, file.problems)
        if file.unreadable:
            location = {"physicalLocation": {"artifactLocation": _artifact(file.path)}}
            notifications.append({"level": "error", "message": _message(file.unreadable), "locations": [location]})
    run = {
        "tool": {"driver": {"name": "rtcli", "semanticVersion": version, "rules": [*map(_rule, RULES)]}},
        "invocations": [{"executionSuccessful": not notifications, "toolExecutionNotifications": notifications}],
        "columnKind": "unicodeCodePoints",
        "newlineSequences": ["\r\n", "\r", "\n"],
        "results": results,
    }
    yield json.dumps({"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def _rule(rule: Rule) -> dict[str, Any]:
    summary = _message(rule.summary)
    return {
        "id": rule.code,
        "name": rule.name,
        "shortDescription": summary,
        "fullDescription": summary,
        "defaultConfiguration": {"level": rule.severity},
        "help": _message(rule.remedy) if rule.remedy else summary,  # must not be empty
    }


def _result(problem: Problem) -> dict[str, Any]:
    help = f"\nhelp: {problem.help}" if problem.help else ""
    location: dict[str, Any] = {
        "physicalLocation": {
            "artifactLocation": _artifact(problem.path),
            "region": {
                "startLine": problem.line,
                "startColumn": problem.column,
                "endLine": problem.end_line,
                "endColumn": problem.end_column,
            },
        }
    }
    if problem.where:
        location["logicalLocations"] = [{"fullyQualifiedName": problem.where}]
    return {
        "ruleId": problem.code,
        "ruleIndex": RULES.index(problem.rule),
        "level": problem.severity,
        "message": _message(problem.message + help),
        "locations": [location],
    }


def _message(text: str) -> dict[str, str]:
    """Return a message with its braces doubled, since `{0}` stands for an argument (section 3.11.5)."""
    return {"text": text.replace("{", "{{").replace("}", "}}")}


def _artifact(path: str) -> dict[str, str]:
    """Return the URI of a file: a relative reference, or a file URI if absolute (RFC 3986, RFC 8089)."""
    pure = PurePath(path)
    return {"uri": pure.as_uri() if pure.is_absolute() else quote(os.fsencode(pure.as_posix()), safe="/")}
