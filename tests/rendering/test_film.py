import numpy as np
import pytest
from PIL import Image
from worlds import scene, sphere

from rtcli import Film

FILM = Film(radiance=np.linspace(0, 1.2, 60, dtype=np.float32).reshape(4, 5, 3), exposure=-1.0)


def test_save_writes_the_developed_picture(tmp_path):
    FILM.save(tmp_path / "out.png")
    with Image.open(tmp_path / "out.png") as image:
        np.testing.assert_array_equal(np.asarray(image), FILM.develop())


@pytest.mark.parametrize(("bits", "dtype"), [(8, np.uint8), (16, np.uint16)])
def test_bits_are_those_of_the_pixels_and_the_file(tmp_path, bits, dtype):
    FILM.save(tmp_path / "out.png", bits=bits)
    assert FILM.develop(bits).dtype == dtype
    assert (tmp_path / "out.png").read_bytes()[24] == bits  # IHDR: width and height, then the depth


@pytest.mark.parametrize("bits", [0, 1, 12, 32])
def test_other_bits_are_refused_and_leave_no_file(tmp_path, bits):
    with pytest.raises(ValueError, match="8 or 16"):
        FILM.save(tmp_path / "out.png", bits=bits)
    assert not list(tmp_path.iterdir())


def test_sixteen_bits_tell_apart_what_eight_do_not():
    ramp = Film(radiance=np.linspace(0.5, 0.505, 30, dtype=np.float32).reshape(1, 10, 3))
    assert len(np.unique(ramp.develop(8))) < 5
    assert len(np.unique(ramp.develop(16))) == 30


def test_film_of_another_type_is_developed_as_float32():
    wide = Film(radiance=FILM.radiance.astype(np.float64)[::-1, ::-1])
    np.testing.assert_array_equal(wide.develop(), Film(radiance=FILM.radiance).develop()[::-1, ::-1])


def test_save_takes_text_and_any_case_of_the_suffix(tmp_path):
    FILM.save(str(tmp_path / "OUT.PNG"))
    assert (tmp_path / "OUT.PNG").exists()


@pytest.mark.parametrize("name", ["out.bmp", "out", ".png"])
def test_save_refuses_a_name_that_tells_no_format(tmp_path, name):
    with pytest.raises(ValueError, match=r"must end in \.png"):
        FILM.save(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_save_into_a_missing_folder_is_an_os_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        FILM.save(tmp_path / "missing" / "out.png")


def test_passes_are_absent_unless_asked_for(render):
    film = render(scene([sphere([0, 0, -5])]), passes=["depth"])
    assert film.depth is not None
    assert film.normal is film.object_id is film.position is film.albedo is film.distance is None


@pytest.mark.parametrize(
    ("name", "dtype", "shape"),
    [
        ("radiance", np.float32, (24, 32, 3)),
        ("depth", np.float32, (24, 32)),
        ("distance", np.float32, (24, 32)),
        ("normal", np.float32, (24, 32, 3)),
        ("position", np.float32, (24, 32, 3)),
        ("albedo", np.float32, (24, 32, 3)),
        ("object_id", np.uint32, (24, 32)),
    ],
)
def test_arrays_have_the_types_and_shapes_of_the_contract(render, name, dtype, shape):
    film = render(scene([sphere([0, 0, -5])]), passes=[] if name == "radiance" else [name])
    array = getattr(film, name)
    assert (array.dtype, array.shape) == (dtype, shape)


@pytest.mark.parametrize("exposure", [float("inf"), float("-inf"), float("nan")])
def test_exposure_that_is_not_finite_is_refused(exposure):
    with pytest.raises(ValueError, match="finite number of stops"):
        Film(radiance=np.zeros((1, 1, 3), np.float32), exposure=exposure)


# --- The film as a value ---------------------------------------------------------------------------------


def test_repr_is_one_line_with_size_arrays_and_exposure():
    assert repr(FILM) == "<Film 5x4: radiance; exposure -1, tone clip>"
    film = Film(radiance=FILM.radiance, depth=FILM.radiance[..., 0], exposure=0.5, tone="aces")
    assert repr(film) == "<Film 5x4: radiance, depth; exposure 0.5, tone aces>"


def test_film_is_a_mapping_of_its_arrays():
    film = Film(radiance=FILM.radiance, depth=FILM.radiance[..., 0])
    assert film["radiance"] is film.radiance
    assert film["depth"] is film.depth
    assert list(film) == list(film.keys()) == list(dict(film)) == ["radiance", "depth"]
    assert len(film) == 2
    assert "depth" in film
    assert "normal" not in film


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("normal", "no 'normal': this film has radiance: request it with rtcli.render(scene, passes=\"normal\")"),
        (
            "dept",
            "no 'dept' (did you mean 'depth'?): this film has radiance: "
            'request it with rtcli.render(scene, passes="depth")',
        ),
        ("radiace", "no 'radiace' (did you mean 'radiance'?): this film has radiance"),
        ("exposure", "no 'exposure': this film has radiance"),
        (0, "no 0: this film has radiance"),
    ],
)
def test_array_that_is_not_there_is_a_key_error_that_lists_those_that_are(name, message):
    with pytest.raises(KeyError) as caught:
        FILM[name]
    assert caught.value.args == (message,)


def test_picture_of_pillow_is_the_developed_one():
    image = FILM.to_pil()
    assert (image.mode, image.size) == ("RGB", (5, 4))
    np.testing.assert_array_equal(np.asarray(image), FILM.develop())


def test_picture_of_pillow_with_16_bits_is_refused():
    with pytest.raises(ValueError, match=r"use film.develop\(16\) or film.save"):
        FILM.to_pil(bits=16)


def test_jupyter_shows_the_picture_that_save_writes(tmp_path):
    film = Film(radiance=FILM.radiance, depth=FILM.radiance[..., 0])
    film.save(tmp_path / "out.png")
    assert film._repr_png_() == (tmp_path / "out.png").read_bytes()
