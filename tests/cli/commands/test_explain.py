"""`rtcli explain`: its output and its errors. Its numbers are tested in `tests/test_explain.py`."""

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

SGR = re.compile(r"\x1b\[[0-9;]*m")

# A ball on the axis, lit from the eye, in front of a wall; a box behind the eye.
SMALL = """\
camera: {resolution: [3, 3], fov: 90}
lights:
  - {position: [0, 0, 0], intensity: 400}
  - {position: [0, 0, -20], intensity: 100}
objects:
  - {type: plane, position: [0, 0, -10], normal: [0, 0, 2], color: [0.5, 0.5, 0.5]}
  - {type: sphere, name: ball, position: [0, 0, -5], radius: 1, color: [1, 0.5, 0.25]}
  - {type: box, position: [0, 0, 4], size: [2, 2, 2], color: red}
image: {exposure: 1, tone: reinhard}
"""

STORY = """\
Pixel 1,1 of small.yaml (3x3)
197 167 135, #c5a787
lit: lights[0] reaches it; the surface faces away from lights[1]
The sections are those of docs/tracer.md; the document is the course text that it follows.

1. The primary ray                                                    docs/tracer.md, 2.1.2 to 2.1.5
   s_x = (px + a_x) / W      x = (2 s_x - 1) (W / H) tan(fov / 2)
   s_y = (py + a_y) / H      y = (1 - 2 s_y) tan(fov / 2)
   d = (x r + y u + f) / |x r + y u + f|
   Corrected: the document maps to -1..1 twice, so fov is the vertical field of view.
   px, py       1            1                         the pixel's column and row, counted from 0
   a            0.5          0.5                       the sample's position in the pixel, 0..1
   W, H         3            3                         the picture's width and height
   s            0.5          0.5                       the sample's position in the picture, 0..1
   fov          90                                     degrees, vertical
   x, y         0            0                         x and y on the image plane, at distance 1
   r            1            0            0            the camera's right
   u            0            1            0            the camera's up
   f            0            0           -1            the camera's viewing direction
   o            0            0            0            the eye
   d            0            0           -1            the direction, a unit vector
=> The ray is o + t d. It starts at the eye, and t is the distance along it.

2. Each object on the ray                                                        docs/tracer.md, 2.2
   sphere (2.2.1)   c = C - o      b = c . d      g = c - b d      D = R^2 - g . g, missed if D < 0
                    q = b + sign(b) sqrt(D)      t_1 = (|c| - R)(|c| + R) / q      t_2 = q
   plane (2.2.2)    t = (p_0 - o) . n / (d . n), parallel if |d . n| < 1e-6
   box (2.2.3)      missed if |g| > R = |size| / 2, the radius of its bounding sphere
                    o' = R^T (o - position)      d' = R^T d
                    each slab is between t = (-size/2 - o') / d' and t = (size/2 - o') / d'
                    t = the last entry, if it comes before the first exit
   The smallest t > 0 wins: only surfaces in front of the eye are seen. Corrected: for spheres the
   document's o means o - C; for planes it omits the absolute value; for boxes it omits rotating d.
   `ball`              t = 4           the nearest, so the eye sees it
      b = 5   |g| = 0   R = 1   D = 1   t_1 = 4   t_2 = 6
   objects[0] (plane)  t = 10          hit behind `ball`
      d . n = -1   t = 10
   objects[2] (box)    missed          behind the eye: entry and exit <= 0
      |g| = 0   R = 1.73205   x slab = -inf to inf   y slab = -inf to inf   z slab = -5 to -3
=> The ray hits 2 of 3 objects. The nearest is `ball`.

3. The nearest hit                                                             docs/tracer.md, 2.2.1
   P = o + t d
   n = (P - C) / |P - C|
   Chosen: surfaces have two sides, and the normal faces the eye.
   t            4                                      the distance from the eye
   P            0            0           -4            the point
   n            0            0            1            the normal, facing the eye
   rho          1            0.5          0.25         the albedo
=> The eye sees `ball` from outside.

4. Each light at the point                                                  docs/tracer.md, 2.3, 3.4
   r = |light - P|      l = (light - P) / r
   L_i = intensity * color / (4 pi r^2)      cos(theta) = n . l
   share = rho / pi * L_i * cos(theta), 0 where the light does not reach
   Chosen: only lights on the eye's side of the surface light it. Neither the object itself nor the
   one that carries the light can block it.
   lights[0]  nothing blocks it, so it reaches the point
      light        0            0            0            the light's position
      r            4                                      its distance
      l            0            0            1            the direction to it
      L_i          1.98944      1.98944      1.98944      the light that arrives there
      cos(theta)   1
      share        0.633257     0.316629     0.158314     of the radiance
   lights[1]  the surface faces away from it: cos(theta) <= 0
      light        0            0           -20           the light's position
      r            16                                     its distance
      l            0            0           -1            the direction to it
      L_i          0.0310849    0.0310849    0.0310849    the light that arrives there
      cos(theta)  -1
=> 1 of 2 lights reaches the point.

5. The radiance                                                                docs/tracer.md, 2.3.2
   radiance = the sum of the shares
   radiance     0.633257     0.316629     0.158314     linear RGB
=> The eye sees light from lights[0].

6. The samples of the pixel                                                    docs/tracer.md, 2.1.5
   radiance = (1 / N) * the sum of the samples
   N            1                                      samples
   radiance     0.633257     0.316629     0.158314     their mean, as the film stores it
=> The pixel has one sample, through its center.

7. The exposure                                         docs/tracer.md, From radiance to the picture
   x = 2^EV * radiance
   EV           1                                      stops
   2^EV         2
   x            1.26651      0.633257     0.316629     exposed radiance
=> The scene sets the exposure; each stop doubles the light.

8. The tone curve                                       docs/tracer.md, From radiance to the picture
   y = x / (1 + x)
   y            0.558794     0.387727     0.240484     linear, 0..1
=> The tone curve is reinhard: E. Reinhard et al., 2002, equation 3, per channel.

9. sRGB and 8 bits                                      docs/tracer.md, From radiance to the picture
   v = 12.92 y for y <= 0.0031308, else 1.055 y^(1/2.4) - 0.055
   value = round(255 v)
   v            0.772829     0.655894     0.527602     sRGB, 0..1
   255 v        197.071      167.253      134.539
   value        197          167          135          red, green, blue
=> The pixel is 197 167 135.

The native engine, the default, gives the same value.
"""

KEYS = {
    *("scene", "resolution", "pixel", "value", "radiance", "exposure", "story", "samples", "development"),
    *("native", "sentence", "engines_agree", "symbols", "drawing"),
}
STEP = {"title", "section", "equations", "numbers", "outcome", "note", "formulas", "meanings"}
OBJECT = {"index", "type", "name", "label"}


@pytest.fixture
def small(folder):
    """A scene whose numbers are easy to check, `small.yaml` in the folder."""
    (folder / "small.yaml").write_text(SMALL)
    return "small.yaml"


def told(run, *arguments, **options):
    """Explain a pixel; return the output."""
    result = run("explain", *arguments, **options)
    assert (result.exit_code, result.stderr) == (0, "")
    return result.stdout


# --- Text ------------------------------------------------------------------------------------------------


def test_story_of_a_small_scene(run, small):
    assert told(run, small, "--pixel", "1,1") == STORY


def test_story_of_standard_input(run, small):
    story = told(run, "-", "--pixel", "1,1", input=SMALL)
    assert story == STORY.replace("small.yaml", "<stdin>")


def test_another_sample_can_be_told(run, small):
    first, second = (told(run, small, "--pixel", "1,1", "--samples", "4", "--sample", n) for n in "12")
    assert "\nShows sample 1 of 4 (choose another with --sample); step 6 combines all.\n" in first
    assert "\nShows sample 2 of 4 " in second
    assert first.partition("6. The samples")[2] == second.partition("6. The samples")[2]
    assert first.partition("2. Each object")[0] != second.partition("2. Each object")[0]


def test_scene_can_be_changed_as_for_a_picture(run, small):
    options = ["--size", "9x9", "--exposure", "auto", "--set", "objects.ball.color=[0, 0, 1]"]
    story = json.loads(told(run, small, "--pixel", "4,4", "--json", *options))
    assert story["resolution"] == [9, 9]
    assert story["story"]["hit"]["numbers"]["rho"] == [0, 0, 1]
    assert "EV" in story["development"]["exposure"]["numbers"]
    assert story["exposure"] != 1


def pixel_of(file):
    with Image.open(file) as image:
        return np.asarray(image).reshape(3).tolist()


def test_value_is_that_of_the_picture(run, scene):
    for x, y in [(20, 15), (3, 28), (0, 0), (39, 29)]:
        crop = ["--crop", f"{x},{y},1,1", "--engine", "reference"]
        assert run("render", scene, "-o", f"{x}.png", "-q", *crop).exit_code == 0
        story = json.loads(told(run, scene, "--pixel", f"{x},{y}", "--json"))
        assert story["value"] == pixel_of(f"{x}.png")


def test_names_of_a_file_cannot_steer_the_terminal(run, folder):
    hostile = SMALL.replace("name: ball", 'name: "\\e[2Jball\\u202e"')
    (folder / "\x1b[2J.yaml").write_text(hostile)
    story = told(run, "\x1b[2J.yaml", "--pixel", "1,1")
    assert "".join(story.splitlines()).isprintable()
    assert r"`\x1b[2Jball\u202e`" in story
    assert r"of \x1b[2J.yaml (3x3)" in story
    assert json.loads(told(run, "\x1b[2J.yaml", "--pixel", "1,1", "--json"))["scene"] == "\x1b[2J.yaml"


def test_color_marks_the_story_and_changes_nothing_else(run, small):
    plain = told(run, small, "--pixel", "1,1", env={"FORCE_COLOR": ""})
    colored = told(run, small, "--pixel", "1,1", env={"FORCE_COLOR": "1"})
    assert "\x1b[1;34m2. Each object on the ray\x1b[0m" in colored
    assert "\x1b[38;2;0;0;0;48;2;197;167;135m#c5a787\x1b[0m\n" in colored  # on the pixel's own color
    assert SGR.sub("", colored) == plain == STORY
    assert told(run, small, "--pixel", "1,1", env={"FORCE_COLOR": "1", "NO_COLOR": "1"}) == plain


def test_progress_of_the_meter_is_shown_to_who_waits_for_it(run, small, monkeypatch):
    arguments = ["explain", small, "--pixel", "1,1", "--exposure"]
    quiet = run(*arguments, "auto")
    monkeypatch.setattr("rtcli.cli.commands.explain.is_terminal", lambda stream: True)
    told = run(*arguments, "auto")
    assert told.stderr.splitlines()[-1] == "metering: 100 %"
    assert (quiet.stdout, quiet.stderr) == (told.stdout, "")
    assert run(*arguments, "0").stderr == ""


# --- JSON ------------------------------------------------------------------------------------------------


def no_constant(name):
    raise AssertionError(f"{name} is no JSON")


def test_json_is_one_object_with_the_documented_keys(run, small):
    options = ["--pixel", "1,1", "--samples", "4", "--json"]
    story = json.loads(told(run, small, *options, env={"FORCE_COLOR": "1"}), parse_constant=no_constant)
    assert story.keys() == KEYS
    assert story["scene"] == "small.yaml"
    assert (story["resolution"], story["pixel"]) == ([3, 3], [1, 1])
    assert story["story"].keys() == {"sample", "ray", "intersections", "hit", "lights", "radiance"}
    assert story["development"].keys() == {"mean", "exposure", "tone", "srgb"}
    assert story["native"].keys() == {"radiance", "exposure", "value", "object", "agreement"}
    assert [sample.keys() for sample in story["samples"]] == [{"offset", "object", "radiance"}] * 4
    steps = {**story["story"], **story["development"]}
    assert steps.pop("sample") == 1
    more = {
        "intersections": {"objects", "inputs"},
        "hit": {"kind", "object"},
        "lights": {"lights"},
        "mean": {"groups"},
    }
    assert {name: step.keys() for name, step in steps.items()} == {
        name: STEP | more.get(name, set()) for name in steps
    }
    assert steps["hit"]["object"].keys() == OBJECT
    assert {frozenset(item.keys()) for item in steps["intersections"]["objects"]} == {
        frozenset({"object", "verdict", "t", "numbers", "outcome"} | more)
        for more in ({"formulas", "meanings"}, set())  # the nearest, and the others
    }
    assert {frozenset(share.keys()) for share in steps["lights"]["lights"]} == {
        frozenset(
            {
                "label",
                "body",
                "verdict",
                "faces",
                "same_side",
                "blockers",
                "places",
                "radiance",
                "numbers",
                "inputs",
                "outcome",
                "formulas",
                "meanings",
            }
        )
    }
    assert [group.keys() for group in steps["mean"]["groups"]] == [{"object", "count", "radiance"}]


def test_every_key_of_the_json_is_documented(run, small):
    page = (Path(__file__).parents[3] / "docs" / "explain.md").read_text(encoding="utf-8").partition("## JSON")[2]

    by_name = {"numbers", "inputs", "meanings", "symbols"}

    def keys(value):
        if isinstance(value, dict):
            for key, item in value.items():
                yield key
                yield from () if key in by_name else keys(item)
        elif isinstance(value, list):
            for item in value:
                yield from keys(item)

    for options in [[], ["--samples", "3", "--set", "lights[0].position=[0, 9, -5]"]]:
        story = json.loads(told(run, small, "--pixel", "1,1", "--json", *options))
        assert {key for key in keys(story) if f"`{key}`" not in page} == set()


def test_infinite_numbers_are_null(run, folder):
    # Seen along its sides, a box is in its slabs of x and y for all t.
    (folder / "box.yaml").write_text(
        "camera: {resolution: [1, 1], fov: 40}\n"
        "objects: [{type: box, position: [0, 0, -5], size: [1, 1, 1], color: red}]\n"
    )
    story = json.loads(told(run, "box.yaml", "--pixel", "0,0", "--json"), parse_constant=no_constant)
    assert story["story"]["intersections"]["objects"][0]["numbers"]["x_slab"] == [None, None]
    assert "x slab = -inf to inf" in told(run, "box.yaml", "--pixel", "0,0")


# --- A page ----------------------------------------------------------------------------------------------


def data_of(page):
    """Return the data in a page."""
    [data] = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page)
    return json.loads(data)


def test_page_is_one_file_with_the_story(run, small):
    assert told(run, small, "--pixel", "1,1", "--html", "story.html") == ""
    page = Path("story.html").read_text(encoding="utf-8")
    assert "<title>Pixel 1,1 of small.yaml</title>" in page
    assert data_of(page)["story"] == json.loads(told(run, small, "--pixel", "1,1", "--json"))
    assert not re.findall(r"<(?:link|img|script)[^>]+(?:src|href)=\"(?!data:)", page)


def test_page_goes_to_a_pipe(run, small):
    told(run, small, "--pixel", "1,1", "--html", "story.html")
    assert told(run, small, "--pixel", "1,1", "--html", "-") == Path("story.html").read_text(encoding="utf-8")


def test_page_knows_the_lines_of_the_file(run, small):
    paths = data_of(told(run, small, "--pixel", "1,1", "--html", "-"))["paths"]
    lines = data_of(told(run, small, "--pixel", "1,1", "--html", "-"))["lines"]
    assert paths["camera"] == paths["camera.fov"] == [1, 1]
    assert paths["objects[1]"] == [7, 7]
    assert lines[6] == [7, SMALL.splitlines()[6]]


def test_lines_of_options_are_not_those_of_the_file(run, small):
    options = ["--set", "camera.fov=40", "--set", "render.samples=1"]
    page = told(run, small, "--pixel", "1,1", "--html", "-", *options)
    assert "Options of the command replaced: camera.fov, render.samples" in page
    assert "camera.fov" not in data_of(page)["paths"]
    assert "render" not in data_of(page)["paths"]


def test_long_file_is_shown_where_the_story_is(run, folder):
    row = "".join(f"  - {{type: sphere, position: [{i}, 50, 0], radius: 0.1, color: red}}\n" for i in range(1200))
    (folder / "long.yaml").write_text(SMALL.replace("image:", f"{row}image:"))
    lines = data_of(told(run, "long.yaml", "--pixel", "1,1", "--html", "-"))["lines"]
    assert len(lines) < 60
    assert [7, SMALL.splitlines()[6]] in lines


def test_names_of_a_file_cannot_end_the_script(run, folder):
    hostile = SMALL.replace("name: ball", "name: '</script><script>alert(1)</script><!--&amp;'")
    (folder / "<b>&.yaml").write_text(hostile)
    page = told(run, "<b>&.yaml", "--pixel", "1,1", "--html", "-")
    assert "alert(1)</script>" not in page
    assert "<b>" not in page
    assert page.count("</script>") == 2
    assert (
        data_of(page)["story"]["story"]["hit"]["object"]["name"] == "</script><script>alert(1)</script><!--&amp;"
    )


def test_page_that_cannot_be_written_is_an_error(run, small):
    result = run("explain", small, "--pixel", "1,1", "--html", "missing/story.html")
    assert (result.exit_code, result.stdout) == (3, "")
    assert "missing/story.html: its folder does not exist" in result.stderr


@pytest.mark.parametrize("name", ["small.yaml", "./small.yaml", "link.html"])
def test_page_does_not_replace_the_scene(run, folder, name):
    scene = folder / "small.yaml"
    scene.write_text(SMALL)
    (folder / "link.html").symlink_to(scene)
    result = run("explain", "small.yaml", "--pixel", "1,1", "--html", name)
    assert result.exit_code == 2
    assert f"the page {name!r} would replace the scene 'small.yaml'" in result.stderr
    assert scene.read_text() == SMALL


def test_page_of_an_invalid_scene_is_not_written(run, folder):
    (folder / "wrong.yaml").write_text(SMALL.replace("radius: 1", "radius: -1"))
    assert run("explain", "wrong.yaml", "--pixel", "1,1", "--html", "story.html").exit_code == 1
    assert not (folder / "story.html").exists()


# --- What is refused -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ([], "Missing option '--pixel'"),
        (["--pixel", "3,1"], "pixel 3,1 is not in the picture of 3x3 pixels"),
        (["--pixel", "1,3"], "pixel 1,3 is not in the picture of 3x3 pixels"),
        (["--pixel", "2,1", "--size", "2x2"], "pixel 2,1 is not in the picture of 2x2 pixels"),
        (["--pixel", "1"], "'1' is not column,row of a pixel"),
        (["--pixel", "1,1,1"], "--pixel"),
        (["--pixel", "-1,0"], "--pixel"),
        (["--pixel", "a,b"], "--pixel"),
        (["--pixel", "1,1", "--sample", "0"], "--sample"),
        (["--pixel", "1,1", "--sample", "2"], "there is no sample 2: the pixel has 1"),
        (["--pixel", "1,1", "--set", "objects.box.color=red"], "no item named `box`"),
        (["--pixel", "1,1", "--json", "--html", "a.html"], "--json and --html exclude each other"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_usage_exits_with_2_and_names_what_is_wrong(run, small, options, part):
    result = run("explain", small, *options)
    assert (result.exit_code, result.stdout) == (2, "")
    assert part in result.stderr


def test_unknown_simd_level_is_wrong_usage(run, small):
    result = run("explain", small, "--pixel", "1,1", env={"RTCLI_SIMD": "sse9"})
    assert (result.exit_code, result.stdout) == (2, "")
    assert "RTCLI_SIMD" in result.stderr


def test_invalid_scene_exits_with_1_and_tells_all_problems(run, folder):
    (folder / "wrong.yaml").write_text("camera: {resolution: [0, 3], fov: 200}\n")
    result = run("explain", "wrong.yaml", "--pixel", "1,1")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.endswith("\n2 errors\n")


@pytest.mark.parametrize("name", ["none.yaml", "."])
def test_scene_that_cannot_be_read_exits_with_3(run, folder, name):
    result = run("explain", name, "--pixel", "1,1")
    assert (result.exit_code, result.stdout) == (3, "")
    assert result.stderr.startswith(f"Error: {name}: ")


# --- Streams ---------------------------------------------------------------------------------------------


@pytest.mark.skipif(os.name == "nt", reason="POSIX only: pipes")
@pytest.mark.parametrize("options", [[], ["--json"]])
def test_reader_that_goes_away_causes_no_traceback(spawn, small, options):
    reader, writer = os.pipe()
    os.close(reader)
    process = spawn("explain", small, "--pixel", "1,1", *options, stdout=writer)
    os.close(writer)
    _, errors = process.communicate(timeout=20)
    assert errors == b""


def test_characters_that_the_output_cannot_encode_are_escaped(spawn, folder):
    (folder / "names.yaml").write_text(SMALL.replace("name: ball", "name: größe赤"), encoding="utf-8")
    env = {**os.environ, "PYTHONIOENCODING": "latin-1"}
    process = spawn("explain", "names.yaml", "--pixel", "1,1", env=env)
    story, errors = process.communicate(timeout=20)
    assert (process.returncode, errors) == (0, b"")
    assert "The eye sees `größe\\u8d64` from outside.".encode("latin-1") in story
