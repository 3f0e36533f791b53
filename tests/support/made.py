"""Samples of a template with everything that can be made of them."""

import io

import numpy as np
from PIL import Image

from rtcli.dataset.sample import SampleRequest, draw_sample

OUTPUTS = ("files", "tar", "parts", "arrays", "levels")


def made(template, index=0, passes=(), has_objects=True):
    """Return the sample of an index with all files and arrays."""
    return draw_sample(template, index, SampleRequest(passes, OUTPUTS), ("train", has_objects))[0]


def levels_of(sample):
    """Return the picture of a sample as an array."""
    shape, levels = sample.made.levels
    return np.frombuffer(levels, np.uint8).reshape(shape)


def passes_of(sample):
    """Return the passes of a sample by name, from the files that stand in a table."""
    passes = {}
    for name, suffix, file in sample.made.parts:
        if name != "image":
            stream = io.BytesIO(file)
            passes[name] = np.load(stream) if suffix == ".npy" else np.asarray(Image.open(stream))
    return passes
