"""The values of a template as they are drawn, whatever its constraints say."""

import json
from dataclasses import replace

from rtcli.rendering.pack import camera_frame
from rtcli.scene.model import SHAPES, Camera

FRAME = camera_frame(Camera(resolution=[8, 8], fov=40))


def frame_of(camera):
    """Return what the sampler asks about a camera that is not plainly valid."""
    return FRAME


def shape_of(text):
    """Return what the sampler asks about an object that is not plainly valid."""
    data = json.loads(text)
    shape = SHAPES[data["type"]].model_validate(data)
    return shape.type, shape.position, shape.parameters


def drawn(template, index=0, attempt=0):
    """Return the sections of a sample by key, and the list of its objects, as plain data."""
    free = replace(template, dataset=template.dataset.model_copy(update={"require": ()}))
    draw = free.draw_of(index, attempt, free.factors_at(index))
    sections = json.loads(free.sampler.draw(draw, 1, frame_of, shape_of).text)
    objects = sections.pop("objects")
    assert sections == {key: json.loads(text) for key, text in free.sampler.sections(draw).items()}
    return sections, objects
