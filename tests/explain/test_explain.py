"""The story of a pixel: its value is the rendered one, its parts add up, and each reason of a miss is told."""

import dataclasses
import json
import math
import random
import time
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stories import PLACES, STRAIGHT, pixel_of, straight
from worlds import box, crowd, extreme_scenes, light, plane, random_scenes, scene, sphere, sun

import rtcli
from rtcli import Scene
from rtcli.curves import TONE_CURVES
from rtcli.explain import explain
from rtcli.explain.records import LIGHT_VERDICTS, Number
from rtcli.explain.shapes import MISSES
from rtcli.reports.explanation import as_json, text
from rtcli.tracer.native import NativeTracer
from rtcli.tracer.reference import ReferenceTracer
from rtcli.tracer.sampling import sample_offsets
from rtcli.tracer.world import MeterReading


def numbers(step):
    return {number.name: number.value for number in step.numbers}


def met(explanation, index=0):
    return explanation.story.intersections.objects[index]


def shares(explanation):
    return explanation.story.lights.lights


# --- The value is the rendered one -----------------------------------------------------------------------


def rendered(data, x, y):
    """Return radiance, stops and value of a pixel, as the reference engine renders it."""
    film = rtcli.render(data, engine="reference", crop=(x, y, 1, 1))
    return film.radiance[0, 0], film.exposure, film.develop()[0, 0, :3]


def assert_told_as_rendered(data, x, y):
    explanation = explain(data, x, y)
    radiance, exposure, value = rendered(data, x, y)
    assert explanation.radiance == tuple(radiance.tolist())
    assert explanation.exposure == exposure
    assert explanation.value == tuple(value.tolist())
    return explanation


IMAGES = st.fixed_dictionaries(
    {"exposure": st.floats(-6, 6) | st.floats(-1e300, 1e300), "tone": st.sampled_from(list(TONE_CURVES))},
    optional={"alpha": st.booleans()},
)


@given(random_scenes(), st.integers(1, 7), IMAGES, st.booleans(), PLACES)
def test_value_is_that_of_the_reference_engine(data, samples, image, eye_falloff, at):
    data["render"] |= {"samples": samples, "eye_falloff": eye_falloff}
    assert_told_as_rendered(Scene.model_validate({**data, "image": image}), *pixel_of(data, at))


@given(st.sampled_from(list(TONE_CURVES)), random_scenes(), PLACES)
def test_value_is_that_of_the_reference_engine_with_the_exposure_it_meters(tone, data, at):
    image = {"exposure": "auto", "tone": tone}
    explanation = assert_told_as_rendered(Scene.model_validate({**data, "image": image}), *pixel_of(data, at))
    assert numbers(explanation.development.exposure)["EV"] == explanation.exposure


def test_percentile_of_the_meter_is_that_of_numpy():
    # A square picture of 256 rows is looked at where the meter looks.
    camera = {"resolution": [256, 256], "fov": 50}
    data = scene(
        [plane([0, -1, 0], [0, 1, 0])], [light([0, 2, -5], 50)], camera=camera, image={"exposure": "auto"}
    )
    luminance = rtcli.render(data, engine="reference").radiance.astype(float) @ [0.2126, 0.7152, 0.0722]
    assert 0 < np.count_nonzero(luminance) < luminance.size
    expected = np.percentile(luminance[luminance > 0], 95)
    step = explain(data, 128, 200).development.exposure
    assert numbers(step)["P95"] == pytest.approx(expected, rel=1e-12)
    assert step.outcome.endswith(
        f"{math.log2(0.8 / expected):.6g} stops, metered from 256x256 points of the picture."
    )


def test_black_picture_has_no_percentile():
    explanation = straight([sphere([0, 0, -5])], image={"exposure": "auto"})
    step = explanation.development.exposure
    assert math.isnan(numbers(step)["P95"])
    assert (numbers(step)["EV"], numbers(step)["factor"]) == (0, 1)
    assert step.outcome == "The exposure is auto: 0 stops, because all 256x256 points of the picture are black."
    as_data = json.loads(as_json(explanation, "scene.yaml"))
    assert as_data["development"]["exposure"]["numbers"]["P95"] is None


def test_picture_that_is_metered_at_no_stops_is_not_called_black(monkeypatch):
    monkeypatch.setattr(ReferenceTracer, "exposure", lambda self, progress: MeterReading(0.0, 0.8, 1))
    step = straight([sphere([0, 0, -5])], [light([0, 0, 0])], image={"exposure": "auto"}).development.exposure
    assert numbers(step)["P95"] == 0.8
    assert step.outcome == "The exposure is auto: 0 stops, metered from 256x256 points of the picture."


def test_progress_of_the_meter_is_told():
    def told(exposure):
        steps = []
        data = scene([sphere([0, 0, -5])], image={"exposure": exposure})
        explain(data, 0, 0, progress=lambda done, total: steps.append((done, total)))
        return steps

    steps = told("auto")
    assert len(steps) > 1
    assert steps == sorted(steps)
    assert steps[-1] == (256**2, 256**2)
    assert told(0) == []


@given(extreme_scenes(), PLACES)
def test_any_valid_numbers_can_be_explained(data, at):
    explanation = assert_told_as_rendered(Scene.model_validate(data), *pixel_of(data, at))
    assert json.loads(as_json(explanation, "scene.yaml"), parse_constant=pytest.fail)
    assert all(len(line) <= 100 for line in text(explanation, "scene.yaml"))


@given(random_scenes(), st.integers(1, 7), PLACES)
def test_each_step_that_is_shown_leads_to_the_next(data, samples, at):
    data["render"]["samples"] = samples
    for tone in TONE_CURVES:
        checked = Scene.model_validate({**data, "image": {"exposure": 0.7, "tone": tone}})
        explanation = explain(checked, *pixel_of(data, at))
        development = explanation.development
        assert numbers(development.exposure)["x"] == pytest.approx(np.multiply(2**0.7, explanation.radiance))
        # The curves in Python are shown, those of the compiled core decide: they must not tell different stories.
        assert numbers(development.srgb)["value"] == explanation.value
        assert np.abs(np.subtract(numbers(development.srgb)["v_255"], explanation.value)).max() <= 0.5 + 1e-9


def test_example_of_each_tone_curve():
    def shown(tone):
        # A background of radiance 1, 0.25 and 0.
        story = straight([], render={"background": [1, 0.25, 0]}, image={"tone": tone})
        return story, numbers(story.development.tone)["y"]

    assert shown("clip")[1] == (1, 0.25, 0)
    assert shown("reinhard")[1] == pytest.approx((0.5, 0.2, 0))
    aces = 0.25 * (2.51 * 0.25 + 0.03) / (0.25 * (2.43 * 0.25 + 0.59) + 0.14)
    assert shown("aces")[1] == pytest.approx((2.54 / 3.16, aces, 0))
    assert shown("clip")[0].value == (255, 137, 0)  # sRGB of 1/4 is 0.5371


def test_native_pixel_is_what_the_native_engine_renders():
    data = Scene.model_validate({**crowd(40, 3, False, False), "image": {"exposure": "auto"}})
    for x in range(0, data.camera.resolution[0], 5):
        film = rtcli.render(data, crop=(x, 7, 1, 1))
        native = explain(data, x, 7).native
        assert native.radiance == tuple(film.radiance[0, 0].tolist())
        assert native.exposure == film.exposure
        assert native.value == tuple(film.develop()[0, 0].tolist())


def test_story_tells_whether_the_engines_agree():
    explanation = straight([sphere([0, 0, -5])], [light([0, 0, 0])])
    assert explanation.engines_agree
    native = dataclasses.replace(explanation.native, value=(1, 2, 3))
    assert not dataclasses.replace(explanation, native=native).engines_agree


CROSSING = [box([0, 0, -5], [2, 2, 2], "red"), sphere([1, 0, -4.5], 1.0, "blue")]


@pytest.mark.parametrize("samples", [1, 4])
def test_engines_agree_on_each_pixel_but_for_rounding_and_borders(samples):
    data = scene(
        CROSSING,
        [light([3, 4, 0], 300)],
        camera={"resolution": [16, 12], "fov": 40},
        render={"samples": samples},
    )
    found = {explain(data, x, y).native.agreement for x in range(0, 16, 3) for y in range(0, 12, 3)}
    assert found <= {"equal", "rounded", "at_a_border"}
    assert found & {"equal", "rounded"}


def as_native(monkeypatch, change):
    """Let the native engine render something else: what `change` makes of its radiance, (H, W, 3)."""
    film = NativeTracer.film

    def changed(self, window, *more):
        arrays, rays = film(self, window, *more)
        radiance = np.broadcast_to(np.float32(change(arrays["radiance"])), arrays["radiance"].shape)
        return {**arrays, "radiance": radiance}, rays

    monkeypatch.setattr(NativeTracer, "film", changed)


@pytest.mark.parametrize(
    ("change", "agreement"),
    [
        (lambda radiance: radiance * 1.0005, "rounded"),
        (lambda radiance: radiance * 1.01, "disagree"),
        (lambda radiance: radiance * 0, "disagree"),
        (lambda radiance: radiance[..., ::-1], "disagree"),
    ],
)
def test_engines_that_disagree_beyond_rounding_are_said_to(monkeypatch, change, agreement):
    as_native(monkeypatch, change)
    data = scene([box([0, 0, -5], [4, 4, 2], "red")], [light([3, 4, 0], 300)])
    assert explain(data, 15, 11).native.agreement == agreement


def test_native_pixel_is_that_of_its_whole_tile(monkeypatch):
    # Of a single pixel, the engine may decide otherwise than of a tile: a wrong picture would be explained away.
    as_native(monkeypatch, lambda radiance: radiance * (2 if radiance.shape == (12, 16, 3) else 1))
    data = scene(
        [box([0, 0, -5], [4, 4, 2], "red")], [light([3, 4, 0], 300)], camera={"resolution": [40, 28], "fov": 40}
    )
    assert {explain(data, x, y).native.agreement for x, y in [(16, 16), (20, 20), (31, 27)]} == {"disagree"}
    assert explain(data, 20, 15).native.agreement == "rounded"


def test_memory_does_not_grow_with_samples():
    def peak(samples):
        data = scene(
            [sphere([x, 0.5, -5]) for x in range(-4, 5)] + [plane([0, 0, 0], [0, 1, 0])],
            [light([3, 4, 0], 300, radius=1.0) for _ in range(4)],
            camera={"resolution": [3, 3], "fov": 40, "position": [0, 1, 0], "look_at": [0, 0.2, -4]},
            render={"samples": samples, "shadow_samples": 256},
        )
        explain(data, 1, 2)
        tracemalloc.start()
        try:
            explain(data, 1, 2)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    assert peak(256) < 1.5 * peak(64)


def sees_instead(monkeypatch, number):
    """Let the native engine see another object, given by its number from 1, with the radiance as it is."""
    film = NativeTracer.film

    def changed(self, *arguments):
        arrays, rays = film(self, *arguments)
        return {**arrays, "object_id": np.full_like(arrays["object_id"], number)}, rays

    monkeypatch.setattr(NativeTracer, "film", changed)


@pytest.mark.parametrize("samples", [1, 4])
def test_engines_that_see_different_objects_disagree_though_these_look_alike(monkeypatch, samples):
    data = scene([box([0, 0, -5], [4, 4, 2], "black")], [], render={"samples": samples})
    native = explain(data, 15, 11).native
    assert (native.agreement, native.object.label) == ("equal", "objects[0] (box)")
    sees_instead(monkeypatch, 0)
    explanation = explain(data, 15, 11)
    assert explanation.native.radiance == explanation.radiance == (0, 0, 0)
    assert (explanation.native.agreement, explanation.native.object) == ("disagree", None)
    assert "and sees the background at the pixel's center. The engines disagree, and" in " ".join(
        text(explanation, "a")
    )


@pytest.mark.parametrize(("way", "agreement"), [(0.0005, "at_a_border"), (0.01, "disagree")])
def test_object_that_is_seen_just_beside_a_ray_may_be_at_a_border(monkeypatch, way, agreement):
    pixel = 2.5 * 2 * math.tan(math.radians(20)) / 3
    wall, edge = plane([0, 0, -5], [0, 0, 1], "black"), box([2 + way * pixel, 0, -3], [4, 9, 1], "black")
    sees_instead(monkeypatch, 2)
    data = scene([wall, edge], [], camera={"resolution": [3, 3], "fov": 40})
    assert explain(data, 1, 1).native.agreement == agreement


@pytest.mark.parametrize(("way", "agreement"), [(0.0005, "at_a_border"), (0.01, "disagree")])
def test_what_is_seen_just_beside_a_ray_may_be_a_border(monkeypatch, way, agreement):
    pixel = 2.5 * 2 * math.tan(math.radians(20)) / 3  # where the box begins

    def beginning(left):
        wall, edge = plane([0, 0, -5], [0, 0, 1], "red"), box([2 + left, 0, -3], [4, 9, 1], [0, 0, 1])
        return scene([wall, edge], [light([-3, 1, 0], 300)], camera={"resolution": [3, 3], "fov": 40})

    beside = explain(beginning(-way * pixel), 1, 1).radiance
    as_native(monkeypatch, lambda radiance: beside)
    assert explain(beginning(way * pixel), 1, 1).native.agreement == agreement


# --- The samples -----------------------------------------------------------------------------------------


@given(random_scenes(), st.integers(1, 9), PLACES)
def test_samples_are_those_of_the_pixel_and_their_mean_is_its_radiance(data, samples, at):
    data["render"]["samples"] = samples
    explanation = explain(Scene.model_validate(data), *pixel_of(data, at))
    assert [sample.offset for sample in explanation.samples] == list(sample_offsets(samples))
    mean = np.mean([sample.radiance for sample in explanation.samples], axis=0)
    assert explanation.radiance == pytest.approx(mean, rel=1e-6)
    groups = explanation.development.mean.groups
    assert sum(group.count for group in groups) == samples
    assert len({group.object for group in groups}) == len(groups)
    mean = sum(group.count * np.array(group.radiance) for group in groups) / samples
    assert explanation.radiance == pytest.approx(mean, rel=1e-6)


@given(random_scenes(), st.integers(1, 5), PLACES)
def test_each_sample_can_be_told(data, samples, at):
    data["render"]["samples"] = samples
    checked = Scene.model_validate(data)
    for told in range(samples):
        explanation = explain(checked, *pixel_of(data, at), told + 1)
        assert explanation.story.sample == told + 1
        assert explanation.story.hit.object == explanation.samples[told].object
        assert numbers(explanation.story.radiance)["radiance"] == explanation.samples[told].radiance
        assert numbers(explanation.story.ray)["a"] == explanation.samples[told].offset


def test_ray_is_that_of_the_formulas():
    camera = {"resolution": [8, 4], "fov": 90, "position": [1, 2, 3]}
    ray = numbers(explain(scene([], camera=camera), 6, 1).story.ray)
    assert ray["s"] == (6.5 / 8, 1.5 / 4)
    assert ray["xy"] == pytest.approx(((2 * 6.5 / 8 - 1) * 2, 1 - 2 * 1.5 / 4))
    assert ray["o"] == (1, 2, 3)
    assert ray["d"] == pytest.approx(np.array([1.25, 0.25, -1]) / math.hypot(1.25, 0.25, 1))


def test_ray_of_intrinsics_is_that_of_their_formulas():
    k = [[4, 0, 2], [0, 5, -3], [0, 0, 1]]
    step = explain(scene([], camera={"resolution": [8, 4], "intrinsics": k}), 6, 1).story.ray
    ray = numbers(step)
    assert (ray["focal"], ray["c"]) == (pytest.approx((4, 5)), pytest.approx((2, -3)))
    assert ray["xy"] == pytest.approx(((6 - 2) / 4, (-3 - 1) / 5))
    assert not ray.keys() & {"s", "size", "fov"}
    assert not any("fov" in equation for equation in step.equations)


def test_ray_of_an_orthographic_camera_starts_beside_its_position():
    view = {"resolution": [8, 4], "projection": "orthographic", "height": 6, "position": [1, 2, 3]}
    found = explain(scene([sphere([4.5, 2.5, 0], 2)], [light([0, 5, 9])], camera=view), 6, 1)
    step = found.story.ray
    ray = numbers(step)
    x, y = (2 * 6.5 / 8 - 1) * 2 * 3, (1 - 2 * 1.5 / 4) * 3
    assert (ray["height"], ray["xy"]) == (6, pytest.approx((x, y)))
    assert (ray["o"], ray["d"]) == (pytest.approx((1 + x, 2 + y, 3)), (0, 0, -1))
    assert "o = position + x r + y u      d = f" in step.equations
    assert numbers(found.story.hit)["P"][:2] == pytest.approx((1 + x, 2 + y))


@pytest.mark.parametrize("pixel", [(-1, 0), (0, -1), (32, 0), (0, 24)])
def test_pixel_outside_of_the_picture_is_refused(pixel):
    with pytest.raises(ValueError, match="not in the picture of 32x24"):
        explain(scene([]), *pixel)


@pytest.mark.parametrize("sample", [0, 4])
def test_sample_that_there_is_not_is_refused(sample):
    with pytest.raises(ValueError, match="the pixel has 3"):
        explain(scene([], render={"samples": 3}), 0, 0, sample)


# --- Each object on the ray ------------------------------------------------------------------------------


@given(random_scenes(), PLACES)
def test_nearest_object_is_what_is_seen(data, at):
    story = explain(Scene.model_validate(data), *pixel_of(data, at)).story
    objects = story.intersections.objects
    hits = [item for item in objects if item.t is not None]
    assert [item.object.index for item in objects] == list(range(len(data["objects"])))
    if not hits:
        assert (story.hit.kind, story.hit.object) == ("background", None)
        return
    nearest = min(hits, key=lambda item: item.t)
    assert nearest.verdict == "nearest"
    assert story.hit.object == nearest.object
    assert {item.verdict for item in hits if item is not nearest} <= {"farther"}


def test_terms_of_a_sphere():
    item = met(straight([sphere([0.6, 0, -5], 1)]))
    assert (item.verdict, item.t) == ("nearest", pytest.approx(4.2))
    assert numbers(item) == pytest.approx({"b": 5, "g_length": 0.6, "R": 1, "D": 0.64, "t_1": 4.2, "t_2": 5.8})


def test_terms_of_a_plane():
    item = met(straight([plane([0, 0, -3], [0, 3, 4])]))
    assert (item.verdict, item.t) == ("nearest", pytest.approx(3))
    assert numbers(item) == pytest.approx({"d_n": -0.8, "t": 3})


def test_terms_of_a_box():
    item = met(straight([box([0, 0, -5], [2, 2, 2])]))
    assert (item.verdict, item.t) == ("nearest", pytest.approx(4))
    terms = numbers(item)
    assert terms["z_slab"] == pytest.approx((4, 6))
    assert (terms["g_length"], terms["R"]) == pytest.approx((0, math.sqrt(3)))


# Of a ray along -z from the origin.
MISSES_OF_EACH_KIND = [
    (sphere([2.5, 0, -5], 1), "passed_by", "the ray misses it: |g| > R, so D < 0"),
    (sphere([0, 1.01, -5], 1), "passed_by", "the ray misses it: |g| > R, so D < 0"),
    (sphere([0, 0, 5], 1), "behind", "behind the eye: t_1 and t_2 <= 0"),
    (plane([0, -1, 0], [0, 1, 0]), "parallel", "parallel: |d . n| < 1e-06"),
    (plane([0, 0, 1], [0, 0, 1]), "behind", "behind the eye: t <= 0"),
    (box([5, 0, -5], [2, 2, 2]), "outside_bounding_sphere", "the ray misses its bounding sphere: |g| > R"),
    (box([1.2, 0, -5], [2, 2, 2]), "outside_slabs", "the ray is parallel to the x slab and outside it"),
    (box([0, 0, 5], [2, 2, 2]), "behind", "behind the eye: entry and exit <= 0"),
]


@pytest.mark.parametrize(("shape", "verdict", "outcome"), MISSES_OF_EACH_KIND)
def test_object_that_is_missed_tells_why(shape, verdict, outcome):
    item = met(straight([shape]))
    assert (item.verdict, item.t) == (verdict, None)
    assert verdict in MISSES
    assert item.outcome == outcome


def test_box_that_is_passed_tells_which_slab_is_left_before_which_is_entered():
    # Turned by 45 degrees its nearer edge is at x = 0.2, so the ray is left of it.
    item = met(straight([box([1.5, 0, -5], [1.8, 2, 1.8], rotation=45)]))
    terms = numbers(item)
    assert item.verdict == "outside_slabs"
    first, second = sorted("xz", key=lambda axis: terms[f"{axis}_slab"][1])
    assert terms[f"{first}_slab"][1] < terms[f"{second}_slab"][0]
    assert item.outcome == (
        f"the ray leaves the {first} slab at {terms[f'{first}_slab'][1]:.6g}, before it enters "
        f"the {second} slab at {terms[f'{second}_slab'][0]:.6g}"
    )


def test_object_whose_numbers_overflow_tells_so():
    # It is met at t = 1e308 / 1e-5, which float64 does not hold.
    item = met(straight([plane([0, -1e308, 0], [0, 1, 1e-5])]))
    assert (item.verdict, item.t) == ("out_of_range", None)
    assert item.outcome == "its values exceed the range of float64"


def test_object_that_is_met_beyond_float64_is_not_called_behind_the_eye():
    # The eye is in a corner of the box: the ray enters it behind the eye, and leaves it farther than float64 goes.
    far = 0.8e308
    item = met(straight([box([far, far, -far], [1.7e308] * 3)], camera={**STRAIGHT, "look_at": [1, 1, -1]}))
    assert all(near < 0 and leaving == math.inf for near, leaving in (numbers(item)[f"{x}_slab"] for x in "xyz"))
    assert (item.verdict, item.t) == ("out_of_range", None)


def test_object_behind_the_nearest_tells_what_hides_it():
    explanation = straight([sphere([0, 0, -9]), sphere([0, 0, -5], name="ball"), sphere([0, 0, -5])])
    assert [(item.verdict, item.outcome) for item in explanation.story.intersections.objects] == [
        ("farther", "hit behind `ball`"),
        ("nearest", "the nearest, so the eye sees it"),
        ("farther", "as near as `ball`, which comes earlier in the file"),
    ]


def test_object_is_called_by_its_name_or_its_place_and_type():
    explanation = straight([box([0, 0, -9], [1, 1, 1]), sphere([0, 0, -5], name="red \x1b[31m ball")])
    assert [item.object.label for item in explanation.story.intersections.objects] == [
        "objects[0] (box)",
        r"`red \x1b[31m ball`",
    ]
    assert explanation.story.hit.object.name == "red \x1b[31m ball"


# --- What is seen ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("shape", "seen", "normal", "t"),
    [
        (sphere([0, 0, -5], 1), "from outside", (0, 0, 1), 4),
        (sphere([0, 0, 0], 2), "from inside", (0, 0, 1), 2),
        (box([0, 0, -5], [2, 2, 2], rotation=180), "from outside", (0, 0, 1), 4),
        (box([0, 0, 0], [2, 2, 6]), "from inside", (0, 0, 1), 3),
        (plane([0, 0, -2], [0, 0, 1]), "from its front", (0, 0, 1), 2),
        (plane([0, 0, -2], [0, 0, -1]), "from its back", (0, 0, 1), 2),
    ],
)
def test_surface_is_told_with_point_normal_and_side(shape, seen, normal, t):
    hit = straight([{**shape, "color": [0.1, 0.2, 0.3]}]).story.hit
    terms = numbers(hit)
    assert hit.kind == "surface"
    assert seen in hit.outcome
    assert terms["n"] == pytest.approx(normal)
    assert terms["P"] == pytest.approx((0, 0, -t))
    assert (terms["t"], terms["rho"]) == (pytest.approx(t), (0.1, 0.2, 0.3))


def test_normal_of_a_box_is_told_in_box_space_too():
    # Turned by 90 degrees counter-clockwise, seen from above, the side with normal x faces -z.
    terms = numbers(straight([box([0, 0, -5], [2, 2, 2], rotation=90)]).story.hit)
    assert terms["n_box"] == pytest.approx((-1, 0, 0))
    assert terms["n"] == pytest.approx((0, 0, 1))


def test_background_is_told():
    story = straight([], [light([0, 0, 0])], render={"background": [0.1, 0.2, 0.3]}).story
    assert story.hit.kind == "background"
    assert numbers(story.radiance)["radiance"] == (0.1, 0.2, 0.3)
    assert story.lights.outcome == "The lights do not matter: the ray hits nothing."


def test_lamp_that_is_seen_is_told_by_the_distance_of_its_light():
    lamp = sphere([0, 0, -5], light={"intensity": 100, "color": [1, 0.5, 0]})
    story = straight([lamp]).story
    arriving = 100 / (4 * math.pi * 25)
    assert story.hit.kind == "shining"
    assert numbers(story.radiance)["r"] == 5
    assert numbers(story.radiance)["radiance"] == pytest.approx((arriving, arriving / 2, 0))
    assert story.lights.lights == ()


def test_depth_of_0_leaves_surfaces_black():
    story = straight([sphere([0, 0, -5])], [light([0, 0, 0])], render={"max_depth": 0}).story
    assert story.hit.kind == "surface"
    assert story.lights.outcome == "The lights do not matter: max_depth is 0."
    assert numbers(story.radiance)["radiance"] == (0, 0, 0)


# --- The lights ------------------------------------------------------------------------------------------


@given(random_scenes(), st.booleans(), PLACES)
def test_shares_of_the_lights_sum_to_the_radiance(data, eye_falloff, at):
    data["render"]["eye_falloff"] = eye_falloff
    story = explain(Scene.model_validate(data), *pixel_of(data, at)).story
    if story.hit.kind != "surface":
        assert story.lights.lights == ()
        return
    total = (
        np.sum([share.radiance for share in story.lights.lights], axis=0) if story.lights.lights else np.zeros(3)
    )
    total = total + numbers(story.radiance).get("rho_ambient", 0)
    if eye_falloff:
        total = total / (4 * math.pi * numbers(story.hit)["t"] ** 2)
    assert numbers(story.radiance)["radiance"] == pytest.approx(total, rel=1e-12)


def test_ambient_light_is_a_term_of_the_radiance():
    step = straight(
        [sphere([0, 0, -5], color=[0.5, 0.25, 1])], render={"ambient": [0.5, 0.5, 0.25]}
    ).story.radiance
    assert numbers(step)["rho_ambient"] == (0.25, 0.125, 0.25)
    assert step.equations == ("radiance = rho * ambient + the sum of the shares",)
    assert step.outcome == "The eye sees ambient light only."


def test_ambient_light_is_seen_with_that_of_the_lights():
    step = straight([sphere([0, 0, -5])], [light([0, 0, 0])], render={"ambient": "white"}).story.radiance
    assert step.outcome == "The eye sees light from lights[0] and ambient light."


@given(random_scenes(), PLACES)
def test_share_of_a_light_is_what_its_numbers_give_and_its_verdict_allows(data, at):
    story = explain(Scene.model_validate(data), *pixel_of(data, at)).story
    for share in story.lights.lights:
        terms = numbers(share)
        assert share.verdict in LIGHT_VERDICTS
        assert share.faces == (terms["cos_theta"] > 0)
        assert (share.verdict == "blocked") == bool(share.blockers)
        assert all(blocking.distance < terms["r"] for blocking in share.blockers)
        expected = np.zeros(3)
        if share.verdict == "lit":
            expected = numbers(story.hit)["rho"] * np.array(terms["L_i"]) / math.pi * terms["cos_theta"]
        assert share.radiance == pytest.approx(expected)


def test_light_in_closed_form():
    # The floor 2 below the eye, seen straight down; the light at the eye, and one 3 to the side of it.
    down = {"camera": {**STRAIGHT, "look_at": [0, -1, 0], "up": [0, 0, -1]}}
    floor = plane([0, -2, 0], [0, 1, 0], [0.5, 0.5, 0.5])
    above, aside = shares(
        straight([floor], [light([0, 0, 0], 16 * math.pi), light([3, 0, 0], 52 * math.pi)], **down)
    )
    terms = numbers(above)
    assert (terms["position"], terms["r"], terms["cos_theta"]) == ((0, 0, 0), 2, 1)
    assert (terms["l"], terms["L_i"]) == (pytest.approx((0, 1, 0)), pytest.approx((1, 1, 1)))
    assert above.radiance == pytest.approx((0.5 / math.pi,) * 3)
    terms = numbers(aside)
    assert (terms["r"], terms["cos_theta"]) == pytest.approx((math.sqrt(13), 2 / math.sqrt(13)))
    assert terms["L_i"] == pytest.approx((1, 1, 1))
    assert aside.radiance == pytest.approx((0.5 / math.pi * 2 / math.sqrt(13),) * 3)


def test_each_verdict_on_a_light_has_its_example():
    # Seen from inside a large ball, whose far wall at z = -10 is lit.
    hollow = sphere([0, 0, 0], 10, name="hollow")
    lights = [
        light([0, 0, 5]),
        light([0, 0, 30]),  # outside
        light([2, 0, 5]),
    ]
    blocker = sphere([1, 0, -2.5], 0.5, name="blocker")  # on the way from the third light
    found = shares(straight([hollow, blocker], lights))
    assert [share.verdict for share in found] == ["lit", "other_side", "blocked"]
    assert [share.same_side for share in found] == [True, False, True]
    assert [share.faces for share in found] == [True, True, True]
    (turned,) = shares(straight([sphere([0, 0, -5])], [light([0, 0, -20])]))
    assert (turned.verdict, turned.faces) == ("turned_away", False)
    (behind,) = shares(straight([plane([0, 0, -5], [0, 0, 1])], [light([0, 0, -20])]))
    assert (behind.verdict, behind.outcome) == ("other_side", "on the opposite side of the plane from the eye")


def test_blockers_are_told_from_the_light_on():
    # A wall at z = -10 with its light above the eye's line; two balls between, and one behind the light.
    wall = plane([0, 0, -10], [0, 0, 1])
    balls = [sphere([0, 3 * (10 - d) / 10, -d], 0.25, name=f"ball {d}") for d in (8, 5)]
    (share,) = shares(straight([*balls, wall], [light([0, 3, 0])]))
    length = math.hypot(3, 10)
    assert [blocking.object.name for blocking in share.blockers] == ["ball 5", "ball 8"]
    assert [blocking.distance for blocking in share.blockers] == pytest.approx(
        [0.5 * length - 0.25, 0.8 * length - 0.25]
    )
    assert share.outcome.startswith("blocked by `ball 5` at distance ")
    assert share.radiance == (0, 0, 0)


def test_object_that_is_seen_does_not_block_its_own_light():
    # Rounding puts its surface nearer to the light, as the light sees it, than the point that the eye sees.
    (share,) = shares(straight([sphere([0, 0, -1_000_004], 1_000_000)], [light([0, 0, -3.9])]))
    assert (share.verdict, share.blockers) == ("lit", ())


def test_carried_light_is_called_by_its_object_and_not_blocked_by_it():
    lamp = sphere([0, 3, 0], 1, name="lamp", light={"intensity": 100})
    free, carried = shares(straight([plane([0, 0, -10], [0, 0, 1]), lamp], [light([5, 0, 0])]))
    assert (free.label, free.body, free.verdict) == ("lights[0]", None, "lit")
    assert (carried.label, carried.body.index, carried.verdict) == ("`lamp`", 1, "lit")


def test_blockers_of_a_sun_are_told_from_the_point_on():
    wall = plane([0, 0, -10], [0, 0, 1])
    balls = [sphere([0, 0.6 * d, -10 + 0.8 * d], 0.25, name=f"ball {d}") for d in (6, 3)]
    (share,) = shares(straight([*balls, wall], [sun([0, -0.6, -0.8])]))
    assert [blocking.object.name for blocking in share.blockers] == ["ball 3", "ball 6"]
    assert [blocking.distance for blocking in share.blockers] == pytest.approx([3.25, 6.25])
    assert share.outcome.endswith(" from the point")
    assert "position" not in numbers(share)


def test_places_of_an_emitter_are_counted_with_what_hides_them():
    wall = plane([0, 0, -10], [0, 0, 1])
    # The lower edge of the board is on the line from the point to the middle of the light: it hides about half.
    board = box([0, 6, -5], [8, 8, 0.1], name="board")
    (share,) = shares(straight([board, wall], [light([0, 4, 0], radius=0.5)], render={"shadow_samples": 20}))
    places = share.places
    assert (places.count, places.facing) == (20, 20)
    (hidden,) = places.hidden
    assert hidden.object.name == "board"
    assert places.reaching + hidden.count == 20
    assert 5 < hidden.count < 15
    assert (share.verdict, share.blockers) == ("lit", ())
    assert share.outcome == (
        f"{places.reaching} of its 20 places reach the point and {hidden.count} are hidden by `board`"
    )
    values = numbers(share)
    assert 0 < values["sum_g_v"] < values["sum_g"]


@given(random_scenes(emitters=True), st.tuples(st.floats(0, 0.999), st.floats(0, 0.999)))
def test_shares_of_emitters_sum_to_the_radiance(data, at):
    width, height = data["camera"]["resolution"]
    explanation = assert_told_as_rendered(Scene.model_validate(data), int(at[0] * width), int(at[1] * height))
    found = shares(explanation)
    if found:
        total = np.sum([share.radiance for share in found], axis=0)
        np.testing.assert_allclose(numbers(explanation.story.radiance)["radiance"], total, rtol=1e-12, atol=1e-300)


# --- As data ------------------------------------------------------------------------------------------------


def test_numbers_have_names_that_programs_can_use():
    explanation = straight(
        [sphere([0, 0, -5]), box([0, 0, -9], [1, 1, 1]), plane([0, 0, -20], [0, 0, 1])],
        [light([0, 0, 0])],
        render={"eye_falloff": True},
        image={"exposure": "auto"},
    )

    def names(value):
        if isinstance(value, Number):
            yield value.name
        elif dataclasses.is_dataclass(value):
            for field in dataclasses.fields(value):
                yield from names(getattr(value, field.name))
        elif isinstance(value, tuple):
            for item in value:
                yield from names(item)

    assert all(name.isidentifier() for name in names(explanation))
    assert len(set(names(explanation))) > 30


def test_ten_thousand_objects_take_seconds():
    rng = random.Random(1)
    centres = [[rng.uniform(-20, 20), rng.uniform(-20, 20), rng.uniform(-60, -20)] for _ in range(9_998)]
    balls = [sphere(centre, 0.3) if i % 2 else box(centre, [0.3, 0.4, 0.5]) for i, centre in enumerate(centres)]
    lights = [light([0, 0, 0]), light([9, 9, 0])]
    start = time.perf_counter()
    explanation = straight([sphere([0, 0, -70], 5), plane([0, -25, 0], [0, 1, 0]), *balls], lights)
    assert "".join(text(explanation, "scene.yaml"))
    assert as_json(explanation, "scene.yaml")
    assert time.perf_counter() - start < 60
