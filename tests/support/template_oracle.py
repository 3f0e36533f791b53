"""The draws of a template in plain Python, from the data of its file: the oracle of the compiled sampler."""

import colorsys
import hashlib
import itertools
import math
from collections.abc import Callable
from statistics import NormalDist

import numpy as np

from rtcli.scene.colors import linear_from_srgb

_GROUP_KEYS = {"repeat", "rest_on", "one_of", "choose"}


class Oracle:
    """A template with the design `random`, in which all names are plain.

    Parameters
    ----------
    data
        The data of its file.
    index, attempt
        The index of the sample, and how often it was drawn before.
    """

    def __init__(self, data, index, attempt=0):
        self.data, self.index = data, index
        factors = data["dataset"].get("factors", {})
        self.factors = {name: self.value(draw, f"dataset.factors.{name}", 0) for name, draw in factors.items()}
        self.attempt = attempt

    def word(self, path, attempt, element=0):
        """Return the random word of a path."""
        text = f"rtcli-draw-1\n{self.data['dataset']['seed']}\n{path}"
        key = np.frombuffer(hashlib.sha256(text.encode()).digest()[:16], "<u8")
        before = (self.index + (attempt << 64) + (element << 128) - 1) % 2**256
        counter = [before >> 64 * place & (2**64 - 1) for place in range(4)]
        return int(np.random.Philox(key=key, counter=np.array(counter, np.uint64)).random_raw())

    def value(self, data, path, attempt, element=0):
        """Return the value of plain data with draws in it."""

        def inner(part, step):
            return self.value(part, path + step, attempt, element)

        if isinstance(data, list):
            return [inner(item, f"[{number}]") for number, item in enumerate(data)]
        if not isinstance(data, dict):
            return data
        kind = next((key for key in data if key in _KINDS), None)
        if kind is None:
            return {key: inner(part, f".{key}") for key, part in data.items()}
        return _KINDS[kind](self, data, self.word(path, attempt, element), inner)

    def sections(self):
        """Return the sections of the sample."""
        sections = {key: part for key, part in self.data.items() if key not in ("dataset", "objects")}
        return {key: self.value(part, key, self.attempt) for key, part in sections.items()}

    def objects(self):
        """Return the objects of the sample."""
        return [item for number in range(len(self.data["objects"])) for item in self._group(number)]

    def _group(self, number):
        group = self.data["objects"][number]
        path = f"objects.{group['name']}" if "name" in group else f"objects[{number}]"
        count = self.value(group.get("repeat", 1), f"{path}.repeat", 0)
        for element in range(count):
            item = {
                key: self.value(part, f"{path}.{key}", self.attempt, element)
                for key, part in group.items()
                if key not in _GROUP_KEYS
            }
            if forms := group.get("one_of"):
                chosen = self._form(group, path, element)
                inner = f"{path}.one_of[{chosen}]"
                for key, part in forms[chosen].items():
                    if key != "weight":
                        item[key] = self.value(part, f"{inner}.{key}", self.attempt, element)
            if "name" in group and "repeat" in group:
                item["name"] = f"{group['name']}[{element}]"
            yield item

    def _form(self, group, path, element):
        if "choose" in group:
            return self.value(group["choose"], f"{path}.choose", self.attempt, element)
        weights = [form.get("weight", 1) for form in group["one_of"]]
        return _pick(self.word(f"{path}.one_of", self.attempt, element), weights)


def _pick(word, weights):
    drawn = word * sum(weights) >> 64
    return next(number for number, end in enumerate(itertools.accumulate(weights)) if drawn < end)


def _unit(word):
    return (word >> 11) * 2**-53


def _uniform(oracle, data, word, inner):
    low, high = data["uniform"]
    return low + (high - low) * _unit(word)


def _log_uniform(oracle, data, word, inner):
    low, high = map(math.log, data["log_uniform"])
    return math.exp(low + (high - low) * _unit(word))


def _normal(oracle, data, word, inner):
    distribution, share = NormalDist(*data["normal"]), ((word >> 12) + 0.5) * 2**-52
    low, high = (distribution.cdf(end) for end in data.get("clip", (-math.inf, math.inf)))
    return distribution.inv_cdf(low + (high - low) * share)


def _integers(oracle, data, word, inner):
    first, last = data["integers"]
    return first + (word * (last - first + 1) >> 64)


def _choice(oracle, data, word, inner):
    values = data["choice"]
    number = _pick(word, data.get("weights", [1] * len(values)))
    return inner(values[number], f".choice[{number}]")


def _hsv(oracle, data, word, inner):
    parts = [inner(part, f".hsv[{number}]") for number, part in enumerate(data["hsv"])]
    return [linear_from_srgb(level) for level in colorsys.hsv_to_rgb(*parts)]


def _all(oracle, data, word, inner):
    return [inner(data["all"], ".all")] * 3


def _factor(oracle, data, word, inner):
    value = oracle.factors[data["factor"]]
    return value * data["times"] if "times" in data else value


def _linspace(oracle, data, word, inner):
    first, last, count = data["linspace"]
    return float(np.linspace(first, last, count)[word * count >> 64])


def _range(oracle, data, word, inner):
    first, end, step = data["range"]
    levels = np.arange(first, end + 1e-9, step)
    return float(levels[word * len(levels) >> 64])


_KINDS: dict[str, Callable] = {
    "uniform": _uniform,
    "log_uniform": _log_uniform,
    "normal": _normal,
    "integers": _integers,
    "choice": _choice,
    "hsv": _hsv,
    "all": _all,
    "factor": _factor,
    "linspace": _linspace,
    "range": _range,
}
