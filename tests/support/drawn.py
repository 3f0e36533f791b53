"""The values of a template as they are drawn, whatever its constraints say."""

import json
from dataclasses import replace

from rtcli.dataset import models
from rtcli.dataset.sample import SampleRequest
from rtcli.template.values import Constant

EMPTY = '{"camera":{"resolution":[8,8],"fov":40}}'


class Lenient:
    """Models that take any scene, and the camera once it is drawn again for a number of times."""

    def __init__(self, refusals=0):
        self.refusals = refusals

    def camera_of(self, text):
        """Return what the sampler asks about a camera that is not plainly valid."""
        self.refusals -= 1
        return "again" if self.refusals >= 0 else models.camera_of('{"resolution":[8,8],"fov":40}')

    def shape_of(self, text):
        """Return what the sampler asks about an object that is not plainly valid."""
        return models.shape_of(text)

    def scene_of(self, text):
        """Return what the sampler asks about a scene that is not plainly valid."""
        return models.scene_of(EMPTY)


def drawn(template, index=0, attempt=0):
    """Return the sections of a sample by key, and the list of its objects, as plain data.

    The attempt is 0, or 2 or more: that of the second try if an object has so many.
    """
    dataset = template.dataset.model_copy(update={"require": (), "tries": attempt or 1})
    own = {**template.sections, "camera": Constant({}, ("camera",))}  # which is not plainly valid
    free = replace(template, dataset=dataset, sections=own)
    references = free.references(free.factors_at(index))
    made = free.sampler.sample((index, references), SampleRequest(), None, Lenient(1 if attempt else 0))
    assert made.attempt == attempt
    found = json.loads(made.text)
    sections = template.sampler.sections((index, attempt, references))
    assert found.keys() == {*sections, "objects"}
    return {key: json.loads(text) for key, text in sections.items()}, found["objects"]
