"""The pages of the documentation, and the blocks of commands and programs in them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "docs").rglob("*.md"))]
# The pages beside the code that they are about.
CODE_PAGES = [ROOT / "CONTRIBUTING.md", ROOT / "tracer" / "README.md", ROOT / "benchmarks" / "README.md"]

SHELL = ("sh", "bash", "console")

_BLOCK = re.compile(
    r"(?:^ *<!-- (?P<note>[^\n]*?) -->\n)?^(?P<fence> *`{3,})(?P<language>\w*)[^\n]*\n(?P<text>.*?)^(?P=fence) *$",
    re.DOTALL | re.MULTILINE,
)


@dataclass(frozen=True)
class Block:
    """A fenced block, and what the comment above it says of running it.

    Parameters
    ----------
    language
        The word behind the fence, such as `sh`.
    text
        What is between the fences.
    line
        The line of the page on which the text begins, from 1.
    note
        The comment right above the fence: `not run: REASON`, `slow: REASON`, `needs PROGRAM`, `exit code N`, or
        `file NAME`.
    """

    language: str
    text: str
    line: int
    note: str

    @property
    def runs(self) -> bool:
        """Whether it is commands or a program, and not left out."""
        return self.language in (*SHELL, "python") and not self.note.startswith("not run: ")

    @property
    def is_slow(self) -> bool:
        """Whether only the integration tests run it."""
        return self.note.startswith("slow: ")

    @property
    def needs(self) -> str | None:
        """A program that is not there on every machine."""
        return self.note.removeprefix("needs ") if self.note.startswith("needs ") else None

    @property
    def exit_code(self) -> int:
        """What the commands exit with."""
        return int(self.note.removeprefix("exit code ")) if self.note.startswith("exit code ") else 0

    @property
    def file(self) -> str | None:
        """The file that holds the text."""
        return self.note.removeprefix("file ") if self.note.startswith("file ") else None

    def commands(self) -> list[tuple[str, str]]:
        """Return the commands of a console, each with its output as it is shown."""
        parts = re.split(r"^\$ ", self.text, flags=re.MULTILINE)[1:]
        return [(part.partition("\n")[0], part.partition("\n")[2]) for part in parts]


def blocks(text: str) -> list[Block]:
    """Return the fenced blocks of a page."""
    found = []
    for match in _BLOCK.finditer(text):
        line = text.count("\n", 0, match.start("text")) + 1
        found.append(Block(match["language"], match["text"], line, match["note"] or ""))
    return found
