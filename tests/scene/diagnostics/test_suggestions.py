"""Suggestions for unknown words."""

import pytest

from rtcli.scene import model
from rtcli.scene.diagnostics.suggestions import suggested_key, suggested_type
from rtcli.scene.diagnostics.synonyms import WORDS_FOR_SHAPES

MODELS = [
    model.Scene,
    model.Camera,
    model.Pose,
    model.PointLight,
    model.CarriedLight,
    model.RenderSettings,
    model.ImageSettings,
]
MODELS += model.SHAPES.values()


@pytest.mark.parametrize(
    ("around", "word", "meant"),
    [
        (model.Scene, "shapes", "objects"),
        (model.Scene, "lamps", "lights"),
        (model.Scene, "sensor", "camera"),
        (model.Scene, "film", "image"),
        (model.Scene, "integrator", "render"),
        (model.Camera, "centre", "position"),
        (model.Camera, "eye", "position"),
        (model.Camera, "look_from", "position"),
        (model.Camera, "lookAt", "look_at"),
        (model.Camera, "target", "look_at"),
        (model.Camera, "vup", "up"),
        (model.Camera, "size", "resolution"),
        (model.Camera, "field-of-view", "fov"),
        (model.Camera, "angle", "fov"),
        (model.Camera, "hfov", "fov_x"),
        (model.Camera, "K", "intrinsics"),
        (model.Camera, "camera_matrix", "intrinsics"),
        (model.Camera, "focal_length", "intrinsics"),
        (model.Camera, "type", "projection"),
        (model.Camera, "ortho", "projection"),
        (model.Camera, "ortho_scale", "height"),
        (model.Camera, "extrinsics", "opencv"),
        (model.Camera, "transform_matrix", "opengl"),
        (model.Pose, "c2w", "camera_to_world"),
        (model.Pose, "w2c", "world_to_camera"),
        (model.PointLight, "location", "position"),
        (model.PointLight, "power", "intensity"),
        (model.PointLight, "colour", "color"),
        (model.CarriedLight, "strength", "intensity"),
        (model.Sphere, "shape", "type"),
        (model.Sphere, "centre", "position"),
        (model.Sphere, "material", "color"),
        (model.Sphere, "r", "radius"),
        (model.Sphere, "size", "radius"),
        (model.Sphere, "emission", "light"),
        (model.Sphere, "id", "name"),
        (model.Plane, "diffuse", "color"),
        (model.Plane, "orientation", "normal"),
        (model.Plane, "n", "normal"),
        (model.Box, "albedo", "color"),
        (model.Box, "rotate", "rotation"),
        (model.Box, "orientation", "rotation"),
        (model.Box, "dimensions", "size"),
        (model.Box, "base_color", "color"),
        (model.RenderSettings, "spp", "samples"),
        (model.RenderSettings, "bounces", "max_depth"),
        (model.RenderSettings, "sky", "background"),
        (model.ImageSettings, "tonemapping", "tone"),
        (model.ImageSettings, "ev", "exposure"),
    ],
)
def test_word_of_another_renderer_means_a_key(around, word, meant):
    assert suggested_key(word, around.model_fields) == meant


@pytest.mark.parametrize("around", MODELS, ids=lambda around: around.__name__)
def test_key_with_a_slip_is_recognised(around):
    for key in around.model_fields:
        for slip in (key.upper(), key.replace("_", ""), key.replace("_", "-").title(), key[0] + key):
            assert slip == key or suggested_key(slip, around.model_fields) == key


def test_word_of_several_keys_means_the_one_that_is_missing():
    assert suggested_key("size", ["radius", "resolution"]) == "resolution"
    assert suggested_key("size", ["radius", "resolution"], missing=["radius"]) == "radius"


def test_word_for_a_key_of_another_mapping_suggests_none():
    assert suggested_key("height", model.Sphere.model_fields) is None  # and not `light`


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("cube", "box"),
        ("cuboid", "box"),
        ("Block", "box"),
        ("ball", "sphere"),
        ("ORB", "sphere"),
        ("uv_sphere", "sphere"),
        ("floor", "plane"),
        ("ground", "plane"),
        ("infinite-plane", "plane"),
        ("Sphere", "sphere"),
        ("boxes", "box"),
        ("plain", "plane"),
        ("torus", None),
        ("", None),
    ],
)
def test_word_of_another_renderer_means_a_type(word, meant):
    assert suggested_type(word, model.SHAPES) == meant


def test_each_shape_has_words_of_others():
    assert list(WORDS_FOR_SHAPES) == list(model.SHAPES)
