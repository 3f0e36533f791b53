"""Where the values of a plainly valid file stand, without the exact readers, which take half a KB for each."""

from __future__ import annotations

import codecs
from collections.abc import Iterator, Mapping

from rtcli.rendering.load import format_of
from rtcli.scene.reading.source import ContainerSpan, Document, Source, SourceSpan
from rtcli.tracer._native import FileSpans


def plain_document(raw: bytes, name: str) -> Document:
    """Return a plainly valid file as a document without data, which finds its spans once they are needed."""

    def read(source: Source) -> Document:
        return Document(source, None, root_span=plain_spans(raw, source.name))

    return Document(Source(name, raw.removeprefix(codecs.BOM_UTF8).decode()), None, read_again=read)


def plain_spans(raw: bytes, name: str) -> SourceSpan | None:
    """Return the span of the value of a file, which holds all others; None if it is not plainly valid."""
    spans = FileSpans.of(raw, format_of(raw, name))
    return None if spans is None else _span(spans, 0)


def _span(spans: FileSpans, index: int) -> SourceSpan:
    start, end, is_container = spans.value(index)
    if not is_container:
        return SourceSpan(start, end)
    span = ContainerSpan(start, end)
    span.values, span.keys = _Values(spans, index), _Keys(spans, index)
    return span


class _Values(Mapping[str | int, SourceSpan]):
    """The spans of the values in a list or mapping, each made when it is asked for."""

    def __init__(self, spans: FileSpans, index: int) -> None:
        self.spans = spans
        self.index = index

    def __getitem__(self, step: str | int) -> SourceSpan:
        return _span(self.spans, self._child(step))

    def __iter__(self) -> Iterator[str | int]:
        return iter(self.spans.steps(self.index))

    def __len__(self) -> int:
        return len(self.spans.steps(self.index))

    def _child(self, step: str | int) -> int:
        child = self.spans.child(self.index, step)
        if child is None:
            raise KeyError(step)
        return child


class _Keys(_Values):
    """The spans of the keys of a mapping; none in a list."""

    def __getitem__(self, step: str | int) -> SourceSpan:
        key = self.spans.key(self._child(step))
        if key is None:
            raise KeyError(step)
        return SourceSpan(*key)

    def __iter__(self) -> Iterator[str | int]:
        return (step for step in super().__iter__() if isinstance(step, str))

    def __len__(self) -> int:
        return sum(1 for _ in self)
