import pytest

from rtcli.scene.model import SHAPES
from rtcli.template.bodies import body_of


def example_of(shape):
    """Return an object of a kind, with the examples of its keys."""
    fields = shape.model_fields.items()
    keys = {key: field.examples[0] for key, field in fields if field.is_required() and field.examples}
    return shape(**{**keys, "color": "red", "position": [1, 2, 3]})


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_all_shapes_with_an_inside_have_a_body(shape):
    """Shapes without an inside cannot carry a light."""
    can_carry = "light" in shape.model_fields
    assert (body_of(example_of(shape)) is not None) == can_carry


def test_body_reaches_as_far_as_the_shape():
    box = SHAPES["box"](color="red", position=[1, 2, 3], size=[2, 4, 6], rotation=90)
    assert body_of(box).reach((1.0, 0.0, 0.0)) == pytest.approx(3)
    assert body_of(box).reach((0.0, 0.0, -1.0)) == pytest.approx(1)
