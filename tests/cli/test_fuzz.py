"""No broken file crashes `rtcli validate`: 10,000 mutated files, and those that Hypothesis generates."""

import random
import re
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

ROOT = Path(__file__).parents[2]
SUFFIXES = (".yaml", ".json")
CORPUS = [
    (path.suffix, path.read_bytes())
    for folder in ("tests/data/invalid", "tests/data/lint", "scenes")
    for path in sorted((ROOT / folder).iterdir())
    if path.suffix in SUFFIXES and path.stat().st_size < 5000
]
FORMATS = ["text", "concise", "json", "github", "sarif", "junit"]

INPUTS, BATCH = 10_000, 250

# Text that parsers stumble over: indicators, escapes, numbers at the border, control and bidirectional characters.
TOKENS = [
    *(
        b"[",
        b"]",
        b"{",
        b"}",
        b",",
        b": ",
        b"- ",
        b"? ",
        b"\n",
        b"\r",
        b"\t",
        b"'",
        b'"',
        b"|\n",
        b">-\n",
        b"#",
        b"%",
    ),
    *(b"&a ", b"*a", b"<<: ", b"!!int ", b"!x", b"---\n", b"...\n", b"\\", b"\\u", b"\\ud800", b"\\x", b"@", b"`"),
    *(b"1e999", b"-1e-999", b".nan", b".inf", b"0x", b"0o9", b"9" * 400, b"-0", b"1_0", b"12:30", b"true", b"~"),
    *(
        b"\x00",
        b"\x1b[2J",
        b"\x07",
        b"\x7f",
        b"\x85",
        b"\xc2\x85",
        b"\xff",
        b"\xc3",
        b"\xed\xa0\x80",
        b"\xef\xbb\xbf",
    ),
    *("\u202e\u2066\u200b\u2028\ufeff\U000e0041\ufffe\u0301赤".encode(), b"::error::", b"%0A", b"]]>", b"<!--"),
    *(b"camera", b"objects: ", b"type: sphere", b"radius: 0", b"color: red", b"name: a", b"light: {intensity: 1}"),
    *(b" " * 300, b"x" * 12_000, b"[" * 80, b"{a: " * 80),
]


WORD = re.compile(rb"[\w.#+-]+")
WORDS = sorted({word for _, raw in CORPUS for word in WORD.findall(raw)})


def mutated(rng: random.Random) -> tuple[str, bytes]:
    """Return suffix and bytes of a file of the corpus with one to four changes; most keep its structure."""
    suffix, raw = rng.choice(CORPUS)
    for _ in range(rng.choice([1, 1, 1, 2, 3, 4])):
        raw = rng.choice([other_word, other_word, other_word, other_lines, other_lines, other_bytes])(rng, raw)
    return rng.choice(SUFFIXES) if rng.random() < 0.05 else suffix, raw


def other_word(rng: random.Random, raw: bytes) -> bytes:
    words = list(WORD.finditer(raw))
    if not words:
        return raw
    word = rng.choice(words)
    return raw[: word.start()] + rng.choice([*WORDS, *TOKENS]) + raw[word.end() :]


def other_lines(rng: random.Random, raw: bytes) -> bytes:
    lines = raw.splitlines(keepends=True)
    start = rng.randint(0, len(lines))
    end = min(len(lines), start + rng.randint(0, 2))
    other = rng.choice(CORPUS)[1].splitlines(keepends=True) or [b""]
    kept = rng.choice([[], lines[start:end] * 2, [rng.choice(other)]])
    return b"".join([*lines[:start], *kept, *lines[end:]])


def other_bytes(rng: random.Random, raw: bytes) -> bytes:
    start = rng.randint(0, len(raw))
    end = min(len(raw), start + rng.choice([0, 1, 1, 3, 10, 100]))
    inserted = rng.choice([b"", raw[start:end] * 3, bytes([rng.randrange(256)]), rng.choice(TOKENS)])
    return raw[:start] + inserted + (b"" if rng.random() < 0.1 else raw[end:])


def harmful(text: str) -> set[str]:
    """Return the characters of an output that a terminal must not get: control, format and broken ones."""
    return {c for c in text if c != "\n" and unicodedata.category(c) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")}


def judge(result, codes):
    assert "Traceback" not in result.output, result.output[-2000:]
    assert result.exit_code in codes, result.output[-2000:]
    assert harmful(result.output) == set()


@pytest.mark.integration
@pytest.mark.parametrize("batch", range(INPUTS // BATCH))
def test_mutated_files_give_reports_and_nothing_else(run, folder, batch):
    rng = random.Random(batch)
    for number in range(BATCH):
        suffix, raw = mutated(rng)
        (folder / f"{number}{suffix}").write_bytes(raw)
    style = FORMATS[batch % len(FORMATS)]
    judge(run("validate", ".", "--format", style, *["--strict"] * (batch % 2)), {0, 1})


PIECES = [token.decode("utf-8", errors="ignore") for token in TOKENS]
TEXTS = st.text() | st.lists(st.sampled_from(PIECES) | st.text(max_size=3), max_size=20).map("".join)


@settings(max_examples=300)
@given(raw=st.binary() | TEXTS.map(lambda text: text.encode("utf-8", errors="surrogatepass")))
@pytest.mark.parametrize("style", FORMATS)
def test_any_input_gives_a_report_and_nothing_else(style, raw):
    from click.testing import CliRunner

    from rtcli.cli import main

    judge(CliRunner().invoke(main, ["validate", "-", "--format", style], input=raw, prog_name="rtcli"), {0, 1})


def test_harm_is_found_where_there_is_some():
    assert harmful("a\x1b[2J\u202eb\ud800\n") == {"\x1b", "\u202e", "\ud800"}
