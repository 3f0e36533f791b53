"""What a template would give: samples drawn without rendering more than ids."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from rtcli.dataset.sample import DatasetSample, Rejections, SampleError, SampleRequest, draw_sample
from rtcli.scene.reading.source import Loc
from rtcli.scene.write import as_data
from rtcli.template.draws import path_of
from rtcli.template.template import Template

# The most samples to draw, and to render for the rate.
SAMPLES, RENDERED = 1_000, 10


@dataclass
class Trial:
    """The result of drawing some samples.

    Parameters
    ----------
    samples, objects
        The number of samples that meet all constraints, and of their objects.
    failures
        For each index without a sample, the reason.
    rejections
        What the constraints refused.
    ranges
        The least and the greatest of each number that differs between samples, by its path.
    rate
        The samples that one processor core makes in a second.
    """

    samples: int = 0
    objects: int = 0
    failures: list[tuple[int, str]] = field(default_factory=list)
    rejections: Rejections = field(default_factory=Rejections)
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    rate: float = 0.0

    def see(self, sample: DatasetSample) -> None:
        """Count a sample."""
        self.samples += 1
        self.objects += len(sample.groups)
        data = as_data(sample.scene)
        objects = [item for item in data.pop("objects", ())]
        found = list(numbers(data, ()))
        for index, (item, group) in enumerate(zip(objects, sample.groups, strict=True)):
            found += numbers(item, ("objects", index if group.name is None else group.name))
        found += [(("dataset", "factors", *loc), value) for loc, value in numbers(dict(sample.factors), ())]
        for loc, value in found:
            path = path_of(loc)
            low, high = self.ranges.get(path, (value, value))
            self.ranges[path] = min(low, value), max(high, value)


def numbers(data: Any, loc: Loc) -> Iterator[tuple[Loc, float]]:
    """Yield the numbers in plain data, and where they are, below a location."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from numbers(value, (*loc, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from numbers(value, (*loc, index))
    elif isinstance(data, (int, float)) and not isinstance(data, bool):
        yield loc, data


def try_out(
    template: Template, start: int, stop: int, passes: tuple[str, ...], on_progress: Callable[[int, int], None]
) -> Trial:
    """Draw the samples from `start` to `stop - 1`, at most `SAMPLES`, and render some.

    Parameters
    ----------
    template
        The template.
    start, stop
        The first index, and the one after the last.
    passes
        The passes that would be written.
    on_progress
        Called with the samples drawn, and of all.
    """
    trial, stop = Trial(), min(stop, start + SAMPLES)
    rendered, spent = 0, 0.0
    for index in range(start, stop):
        before = time.perf_counter()
        try:
            sample, rejections = draw_sample(template, index)
        except SampleError as error:
            if rendered < RENDERED:  # a run takes this time, too
                spent += time.perf_counter() - before
            trial.failures.append((index, str(error)))
            trial.rejections.update(error.rejections)
            continue
        finally:
            on_progress(index - start + 1, stop - start)
        trial.rejections.update(rejections)
        trial.see(sample)
        if rendered < RENDERED:
            before = time.perf_counter()
            draw_sample(template, index, SampleRequest(passes, ["parts"]), ("", True))
            rendered, spent = rendered + 1, spent + time.perf_counter() - before
    trial.rate = rendered / spent if rendered else 0.0
    trial.ranges = {path: ends for path, ends in trial.ranges.items() if ends[0] != ends[1]}
    return trial
