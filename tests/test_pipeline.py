import tracemalloc

import numpy as np
import pytest
from worlds import light, plane, render, scene, sphere

from rtcli.pack import pack
from rtcli.pipeline import Request, trace

ROOM = scene([plane([0, -1, 0], [0, 1, 0]), sphere([0, 0, -5])], [light([2, 3, -2])])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"engine": "native"}, "unknown engine 'native': known is reference"),
        ({"passes": ["depth", "dept"]}, "unknown passes dept: known are depth"),
        ({"threads": 0}, "threads must be at least 1, got 0"),
        ({"crop": (0, 0, 0, 5)}, "not inside the picture of 32x24 pixels"),
        ({"crop": (30, 0, 3, 1)}, "not inside the picture"),
        ({"crop": (0, -1, 3, 2)}, "not inside the picture"),
    ],
)
def test_wrong_requests_say_what_is_right(options, message):
    with pytest.raises(ValueError, match=message):
        render(ROOM, **options)


def test_passes_are_taken_at_pixel_centres_whatever_the_samples():
    many = ROOM.model_copy(update={"render": ROOM.render.model_copy(update={"samples": 7})})
    np.testing.assert_array_equal(
        render(ROOM, passes=["object_id"]).object_id, render(many, passes=["object_id"]).object_id
    )


def test_film_carries_the_scenes_exposure_and_tone():
    film = render(
        ROOM.model_copy(update={"image": ROOM.image.model_copy(update={"exposure": 2.0, "tone": "aces"})})
    )
    assert (film.exposure, film.tone) == (2.0, "aces")


def test_memory_beside_the_film_does_not_grow_with_the_picture():
    def beside_the_film(height):
        camera = {"resolution": [512, height], "fov": 40}
        large = scene([plane([0, -1, 0], [0, 1, 0]), sphere([0, 0, -5])], [light([2, 3, -2])], camera=camera)
        tracemalloc.start()
        try:
            film = render(large, threads=1)
            return tracemalloc.get_traced_memory()[1] - film.radiance.nbytes
        finally:
            tracemalloc.stop()

    assert beside_the_film(4096) < 1.2 * beside_the_film(512)


def test_one_pass_may_be_named_without_a_list():
    assert render(ROOM, passes="depth").depth is not None


def test_progress_tells_the_pixels_done_and_ends_with_all():
    told = []
    camera = {"resolution": [300, 140], "fov": 40}
    trace(pack(scene([], camera=camera)), Request(threads=2), lambda done, total: told.append((done, total)))
    assert told == sorted(told)
    assert len(told) == 6  # tiles of 128 x 128, cut at the right and lower edges
    assert told[-1] == (300 * 140, 300 * 140)
