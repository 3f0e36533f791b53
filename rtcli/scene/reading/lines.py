"""Line and column numbers of a text, counted as editors count them."""

from __future__ import annotations

# One table entry per this many characters keeps the table small even if every character is a line.
_CHUNK = 4096


class Lines:
    r"""The line starts of a text. A line ends with `\n`, `\r\n` or `\r`, as in YAML 1.2 and in editors.

    Fast for one line of millions of characters, and for millions of lines.
    """

    def __init__(self, text: str) -> None:
        self._text = text
        self._has_returns = "\r" in text
        # For each chunk: the number of line ends before it, and the start of the line in which it begins.
        self._ends: list[int] = [0]
        self._starts: list[int] = [0]
        for chunk in range(0, len(text), _CHUNK):
            end = chunk + _CHUNK
            self._ends.append(self._ends[-1] + self._count_ends(chunk, end))
            self._starts.append(self._last_start(chunk, end, self._starts[-1]))

    def _count_ends(self, start: int, end: int) -> int:
        r"""Return the number of line ends: each `\n`, and each `\r` without a `\n` after it."""
        count = self._text.count("\n", start, end)
        if self._has_returns:
            count += self._text.count("\r", start, end) - self._text.count("\r\n", start, end + 1)
        return count

    def _last_start(self, start: int, end: int, before: int) -> int:
        """Return the start of the line after the last line end in start..end; `before` if there is none."""
        last = self._text.rfind("\n", start, end)
        if self._has_returns:
            alone = self._text.rfind("\r", start, end)
            if alone >= 0 and self._text.startswith("\n", alone + 1):  # its `\n` ends the line
                alone = self._text.rfind("\r", start, alone) if alone + 1 >= end else -1
            last = max(last, alone)
        return last + 1 if last >= 0 else before

    def start_of(self, offset: int) -> int:
        """Return the offset at which the line around an offset starts."""
        chunk = offset // _CHUNK
        return self._last_start(chunk * _CHUNK, offset, self._starts[chunk])

    def number_of(self, offset: int) -> int:
        """Return the line number of an offset, counted from 1."""
        chunk = offset // _CHUNK
        return 1 + self._ends[chunk] + self._count_ends(chunk * _CHUNK, offset)
