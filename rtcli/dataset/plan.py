"""Which samples a run makes: shards, the unit of work, and where their files are."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from rtcli.rendering.metadata import SOFTWARE
from rtcli.template.dataset import Dataset
from rtcli.template.draws import VERSION
from rtcli.template.template import Template

SHARD_SIZE = 1_000
# The samples of a task: the finest step of progress, and of the sharing of work.
PIECE_SIZE = 50


class Shard(NamedTuple):
    """Consecutive samples of a split.

    Parameters
    ----------
    split
        The name of the split.
    number
        Its number in the split, from 0.
    start, stop
        Its first index, and the one after its last.
    total
        The number of shards of the split.
    """

    split: str
    number: int
    start: int
    stop: int
    total: int = 1

    @property
    def key(self) -> str:
        """Its name: `train-000012`."""
        return f"{self.split}-{self.number:06}"

    def pieces(self) -> Iterator[tuple[int, int]]:
        """Yield the first index of each piece, and the one after its last."""
        for start in range(self.start, self.stop, PIECE_SIZE):
            yield start, min(self.stop, start + PIECE_SIZE)


def shards_of(dataset: Dataset, start: int, stop: int) -> Iterator[Shard]:
    """Yield the shards of a data set that hold the indices from `start` to `stop - 1`, each cut to these."""
    first = 0
    for split, end in dataset.split_ends().items():
        begins = range(first, end, SHARD_SIZE)
        for number, begin in enumerate(begins):
            lower, upper = max(begin, start), min(end, begin + SHARD_SIZE, stop)
            if lower < upper:
                yield Shard(split, number, lower, upper, len(begins))
        first = end


@dataclass(frozen=True)
class Layout:
    """The folder of a data set.

    Parameters
    ----------
    folder
        The folder.
    scratch
        The name of the folder of unfinished files, one for each run: several may write at once, even one shard.
    """

    folder: Path
    scratch: str = "parts"

    @property
    def records(self) -> Path:
        """The folder with a record of each finished shard, and its labels."""
        return self.folder / ".rtcli"

    @property
    def parts(self) -> Path:
        """The folder of the run's unfinished files."""
        return self.records / self.scratch

    def record(self, shard: Shard) -> Path:
        """Return the path of the record of a shard, which exists once all files of the shard do."""
        return self.records / f"{shard.key}.json"

    def labels(self, key: str) -> Path:
        """Return the path of the labels of a shard, a line of JSON for each sample."""
        return self.records / f"{key}.jsonl"

    def label_lines(self, keys: Iterable[str]) -> Iterator[bytes]:
        """Yield the labels of each sample of some shards, as lines of JSON."""
        for key in keys:
            with self.labels(key).open("rb") as lines:
                yield from lines

    def grown(self, shard: Shard) -> Shard:
        """Return a shard with the samples that it has already, and all between."""
        record = self._record(shard)
        if record is None:
            return shard
        return shard._replace(start=min(shard.start, record["start"]), stop=max(shard.stop, record["stop"]))

    def is_done(self, shard: Shard) -> bool:
        """Return whether a shard is finished, with all of its samples, and its files are there."""
        record = self._record(shard)
        if record is None or not record["start"] <= shard.start <= shard.stop <= record["stop"]:
            return False
        return all(map(self._is_there, record["files"]))

    def _record(self, shard: Shard) -> dict[str, Any] | None:
        try:
            record: dict[str, Any] = json.loads(self.record(shard).read_bytes())
        except (OSError, ValueError):
            return None
        return record

    def _is_there(self, file: Mapping[str, Any]) -> bool:
        """Return whether a file of a shard has its size, or a folder the files in the list of its hashes."""
        path: str = file.get("path", "")
        if "bytes" in file:
            return (self.folder / path).is_file() and (self.folder / path).stat().st_size == int(file["bytes"])
        if not path.endswith("/"):
            return True
        try:
            lines = (self.folder / file["checksums"]).read_text(encoding="utf-8").splitlines()
        except OSError:
            return False
        return all((self.folder / line.partition("  ")[2]).is_file() for line in lines)


@dataclass(frozen=True)
class OutputSettings:
    """What decides the bytes of a data set beside its template.

    Parameters
    ----------
    formats
        Names of `rtcli.dataset.formats.FORMATS`.
    passes
        The passes to write beside the pictures.
    """

    formats: tuple[str, ...]
    passes: tuple[str, ...]

    def identity(self, template: Template) -> dict[str, Any]:
        """Return what all runs that add to a folder must agree on."""
        return {
            "software": SOFTWARE,
            "draws": VERSION,
            "template": template.raw.decode("utf-8-sig"),
            "template_sha256": template.sha256,
            "formats": list(self.formats),
            "passes": list(self.passes),
        }
