"""The compiled tracer: the crate in `tracer/python`, a thin layer over the one in `tracer/`.

While it computes, other Python threads run, and the calling thread gives signals, progress and bytes to Python
every 20 ms; what is raised there ends the work within 0.2 s and is raised again. Numbers in `bytes` stand in
native byte order; arguments of a wrong length or range raise ValueError.
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias, final

import numpy as np
import numpy.typing as npt

from rtcli.tracer.world import Vector, Window

# Stops, tone curve (a name of `rtcli.curves.TONE_CURVES`), bits a channel (8 or 16).
_DisplayTransform: TypeAlias = tuple[float, str, int]
# Keywords and their texts, for the text chunks of a PNG.
_Texts: TypeAlias = list[tuple[str, str]]
_Arrays: TypeAlias = dict[str, npt.NDArray[Any]]
# Called with the pixels done and all pixels.
_Progress: TypeAlias = Callable[[int, int], None]

__version__: str

# The number of parameters of each kind of shape and of light, in the order of their tags.
SHAPE_PARAMETERS: dict[str, int]
LIGHT_PARAMETERS: dict[str, int]

# By the quantity of a pass: from the levels of its picture to its values, as files state it.
LEVEL_FORMULAS: dict[str, str]

# The exposure is metered at this many times as many points, a grid that spans the whole picture.
METER_GRID: int
# The native engine traces pixels together in squares of this side, which start at multiples of it.
TILE_SIDE: int

# The most steps to find the coverage of objects.
COVERAGE_STEPS: int

class BudgetExceededError(RuntimeError):
    """There was more to do than a `WorkBudget` allows."""

@final
class WorkBudget:
    """How much work may be done: all that is given the same budget shares it.

    It is counted, not timed: whether work exceeds a budget depends neither on the machine nor on threads.

    Parameters
    ----------
    steps
        Each is a node of the tree that is visited, or a test of a shape against 16 rays: about 10 ns.
    """

    def __new__(cls, steps: int, /) -> WorkBudget: ...
    @property
    def spent(self) -> int:
        """The steps that were done so far; more than there may be, once the budget is exceeded."""

@final
class Tracer:
    """A world that is rendered to a film or to a picture. See `rtcli.tracer.world` for the meaning of each number.

    Parameters
    ----------
    camera
        Width, height, projection, half height, pixel aspect, center, position, right, up, forward.
    objects
        The columns of `Shapes`: kind (uint8), position, parameters, color (float64).
    checkers
        The columns of `Checkers`: object (int64), size, color (float64).
    lights
        The columns of `Lights`: kind (uint8), parameters, color, intensity (float64), carrier (int64).
    settings
        Samples, background, ambient light, whether objects are lit (`max_depth` of 1 or more), shadow samples,
        eye_falloff.
    threads
        How many work, at most four for each processor core.
    """

    def __new__(
        cls,
        camera: tuple[int, int, str, float, float, tuple[float, float], Vector, Vector, Vector, Vector],
        objects: tuple[bytes, ...],
        checkers: tuple[bytes, ...],
        lights: tuple[bytes, ...],
        settings: tuple[int, Vector, Vector, bool, int, bool],
        threads: int,
        /,
    ) -> Tracer: ...
    def film(self, window: Window, arrays: _Arrays, progress: _Progress | None, /) -> int:
        """Render a window into arrays by name; return the number of rays, which is 0 without radiance and alpha.

        Their shapes and types are those of `rtcli.tracer.passes.SPECS`.

        Raises
        ------
        TypeError
            If an array has items of another type, or is not contiguous.
        ValueError
            If an array has another size or an unknown name.
        """

    def levels(
        self, window: Window, transform: _DisplayTransform, budget: WorkBudget | None = None, /
    ) -> bytearray:
        """Render a window and develop it: red, green and blue of each pixel, 16 bits with the high byte first.

        Raises
        ------
        BudgetExceededError
            If it is more work than the budget allows.
        """

    def picture(
        self,
        window: Window,
        transform: _DisplayTransform,
        texts_and_compress: tuple[_Texts, str],
        write: Callable[[bytes], Any],
        progress: _Progress | None,
        /,
    ) -> tuple[int, float, float, float]:
        """Render a window to a PNG, of which `write` is given piece by piece, in memory that stays bounded.

        The compression of the file is `fast` or `small`.

        Returns
        -------
        rays, trace, develop, encode
            The number of rays, and the seconds that all threads together spent in each stage.
        """

    def coverage(self, window: Window, budget: WorkBudget | None = None, /) -> list[int]:
        """Return of each object how many pixels of a window its surface covers, what others hide included.

        Raises
        ------
        BudgetExceededError
            If it is more work than the budget allows.
        """

    def exposure(self, grid: int, budget: WorkBudget | None = None, /) -> tuple[float, float | None, int]:
        """Meter the whole picture at `grid` x `grid` points: return what `meter` does, and the number of rays.

        Raises
        ------
        BudgetExceededError
            If it is more work than the budget allows.
        """

@final
class PngEncoder:
    """Encodes radiance, interleaved float32 RGB, as a PNG, some rows at a time.

    Parameters
    ----------
    width, height
        The picture, pixels.
    transform
        Stops, tone curve, bits a channel.
    texts
        What the file tells beside its pixels.
    compress
        `fast`, or `small`: few bytes.
    """

    def __new__(
        cls, width: int, height: int, transform: _DisplayTransform, texts: _Texts, compress: str = "fast", /
    ) -> PngEncoder: ...
    def push(self, radiance: bytes, /) -> bytes:
        """Add whole rows; return what the file holds next."""

    def finish(self) -> bytes:
        """Return the rest of the file, once all rows were added."""

class FileSpans:
    """The places of all values and keys in the text of a plainly valid scene file, in characters.

    Each value has an index; the whole file has 0.
    """

    @staticmethod
    def of(file: bytes, format: str, /) -> FileSpans | None:
        """Read the spans of a file, `json` or `yaml`; return None if it is not plainly valid.

        Raises
        ------
        ValueError
            If there is no such format.
        """

    def value(self, index: int, /) -> tuple[int, int, bool]:
        """Return the start and end of a value, and whether it is a list or mapping."""

    def key(self, index: int, /) -> tuple[int, int] | None:
        """Return the start and end of the key of a value, with its quotes, if it has one."""

    def child(self, index: int, step: str | int, /) -> int | None:
        """Return the index of a value in a list or mapping."""

    def steps(self, index: int, /) -> list[str | int]:
        """Return the steps into a list or mapping."""

# A scene that was read: the values of each section by key, but of `camera` those of `CameraFrame`; the columns of
# `Shapes`, `Checkers` and `Lights`; and the names of the objects as in `rtcli.rendering.pack.PackedScene`.
Columns: TypeAlias = tuple[dict[str, Any], tuple[bytes, ...], tuple[bytes, ...], tuple[bytes, ...], str]
# The path of a value in a scene, and the value in YAML.
_PathEdit: TypeAlias = tuple[tuple[str | int, ...], str]

def read_scene(file: bytes, format: str, edits: list[_PathEdit], /) -> Columns | None:
    """Read a scene file, `json` or `yaml`, with edits of its values.

    Return None if the file is not plainly valid, or memory runs out.

    Raises
    ------
    ValueError
        For another format.
    """

def write_picture(
    scene: bytes, format: str, edits: list[_PathEdit], bits: int, compress: str, paths: tuple[str, str], /
) -> tuple[str, str, int, tuple[int, int], dict[str, float]] | None:
    """Render a scene file as `read_scene` takes it to a PNG, with one thread.

    The file is written under the second path, which must not exist, and appears under the first one once it is
    complete.

    Returns
    -------
    fingerprint, sha256, bytes, size, seconds
        The fingerprint of the scene, the hash of the file in hexadecimal digits, its size, the width and height of
        the picture, and the seconds of each stage. None if the scene is not plainly valid.

    Raises
    ------
    OSError
        If the file cannot be written; it names the first path.
    ValueError
        For another format, bits other than 8 and 16, or a compression other than `fast` and `small`.
    """

def by_threes(kinds: bytes, parameters: bytes, /) -> tuple[bytes, bytes, bytes]:
    """Return three of the parameters of each shape, a single one three times; the fourth or 0; and the rest."""

def simd_level() -> str:
    """Return `baseline`, `avx2`, `avx512` or `neon`: the best of this machine, or what RTCLI_SIMD asks for.

    Raises
    ------
    ValueError
        If RTCLI_SIMD names none of them, or one that this machine lacks.
    """

def emitter_places(count: int, /) -> list[Vector]:
    """Return the places of an emitter of radius 1 around the origin, from which it shines evenly."""

def sample_offsets(count: int, /) -> list[tuple[float, float]]:
    """Return the offsets of a pixel's samples; see `rtcli.tracer.sampling`."""

def develop(radiance: bytes, transform: _DisplayTransform, alpha: bytes | None = None, /) -> bytearray:
    """Return radiance, interleaved float32 RGB, as sRGB: 8 bits a channel, or 16 with the high byte first.

    With alpha, float32, radiance is multiplied by it; the fourth channel is alpha, and the others are no products.
    """

def encode_png(
    pixels: bytes, size: tuple[int, int], channels: int, bits: int, texts: _Texts, compress: str = "fast", /
) -> bytes:
    """Return a PNG of levels: 1 or 3 channels that are no colors, or sRGB with alpha in 4.

    The size is width and height; levels have 8 bits, or 16 in native byte order.
    """

def decode_png(file: bytes, /) -> tuple[int, int, int, int, bytes]:
    """Return width, height, channels (1 to 4), bits and the numbers of a PNG, 16 bits in native byte order.

    Palettes, small depths and transparent colors are expanded.

    Raises
    ------
    ValueError
        If it is no PNG, is broken, or is larger than 6 GiB when decoded.
    """

def id_boxes(ids: npt.NDArray[np.uint32], count: int, /) -> list[tuple[int, list[int] | None]]:
    """Return the number of pixels of each id from 1 to `count`, and the box around them: left, top, width, height.

    The ids are an array (H, W) whose rows follow each other; the box is None if there are no pixels.

    Raises
    ------
    TypeError
        If they are another array, or not contiguous.
    ValueError
        If they have no pixels.
    """

def pass_picture(name: str, values: bytes, scale: float | None, /) -> tuple[bytes, int, str]:
    """Return a pass of float32 as levels, their bits, and how to get its values, in JSON.

    Levels of 16 bits are in native byte order. `scale` is the length of one level of a depth or distance; None to
    fit it to the values. See `rtcli.image.pass_picture`.

    Raises
    ------
    ValueError
        If there is no such pass, or it has no levels, as that of ids.
    """

def camera_matrices(camera: tuple[Any, ...], window: Window, /) -> str:
    """Return `rtcli.rendering.metadata.camera_matrices` in JSON."""

def meter(radiance: bytes, /) -> tuple[float, float | None]:
    """Return the stops that expose a picture well, and the 95th percentile of luminance they were found from.

    That is the percentile of all points that are not black; 0 stops and None if all are.
    """

def half_tangent(degrees: float, /) -> float:
    """Return tan(angle / 2) of an angle in degrees: the same on every machine, as `math.tan` is not."""

# --- Draws of templates, and the bodies that their constraints measure -------------------------------------

def draw_word(key: tuple[int, int], counter: tuple[int, int, int], /) -> int:
    """Return the first word of Philox4x64-10 for a key and a counter, 64 bits.

    The counter is an index, an attempt, and the number of an object in its group; its last word is 0.
    """

# A value of a template: its text in JSON, a list, a mapping, or a draw: its kind, a name of
# `rtcli.template.draws.DRAWS`; its key; its parameters, `Draw.numbers`; and values within it.
CompiledDraw: TypeAlias = tuple[str, tuple[int, int], list[float], list[CompiledValue]]
CompiledValue: TypeAlias = str | list[CompiledValue] | dict[str, CompiledValue] | CompiledDraw
# What draws depend on: the index of the sample, how often it was drawn before, and the values of draws
# `factor`, in JSON, by their numbers.
_Draw: TypeAlias = tuple[int, int, list[str]]

@final
class Drawn:
    """A draw by itself, with none of `factor` in it."""

    def __new__(cls, draw: CompiledDraw, /) -> Drawn: ...
    def value(self, word: int, index: int, /) -> str:
        """Return the value in JSON that a random word stands for, in the sample of an index."""

@final
class Sample:
    """A sample of a template with its outputs, and how it was found.

    Attributes
    ----------
    attempt
        The attempt of its draws, beside those of objects.
    groups
        For each object the number of its group.
    text
        The scene in JSON; None if no try meets all constraints.
    labels
        Its labels as a line of JSON, without the end of the line; None if they are not wanted.
    files
        For the output `files`: the end of the name and the bytes of each file. Passes of floats are levels of
        PNGs.
    tar
        For the output `tar`: the members of a tar file.
    parts
        For the output `parts`: for the picture, `image`, and for each pass its name, the end of the name of its
        file, and the bytes. Passes of floats are in NumPy's format.
    arrays
        For the output `arrays`: for the picture, `images`, and for each pass its name, its shape, the type of its
        values, and these compressed to a stream of zlib, the same on every machine.
    levels
        For the output `levels`: the shape of the picture, (H, W, 3) or, with alpha, (H, W, 4), and its 8-bit sRGB.
    draws
        The number of objects and scenes that a constraint decided on.
    checks
        How often each constraint was asked.
    refusals
        For each constraint that refused objects, in the order of the first refusals: its name, how often, how
        often that was the end of a try, and the objects that last did not meet it.
    """

    attempt: int
    groups: list[int]
    text: str | None
    labels: bytes | None
    files: list[tuple[str, bytes]]
    tar: bytes
    parts: list[tuple[str, str, bytes]]
    arrays: list[tuple[str, tuple[int, ...], str, bytes]]
    levels: tuple[tuple[int, int, int], bytes] | None
    draws: int
    checks: list[tuple[str, int]]
    refusals: list[tuple[str, int, int, str]]

class _SampleRequest(Protocol):
    """Described by `rtcli.dataset.sample.SampleRequest`."""

    @property
    def passes(self) -> Sequence[str]: ...
    @property
    def outputs(self) -> Sequence[str]: ...
    @property
    def threads(self) -> int: ...
    @property
    def tries(self) -> int | None: ...

class Models(Protocol):
    """Answers about values in JSON that are not plainly valid; described by `rtcli.dataset.models`."""

    # Attributes, as a module has them.
    @property
    def camera_of(self) -> Callable[[str], tuple[Any, ...] | str]: ...
    @property
    def shape_of(self) -> Callable[[str], tuple[str, Vector, tuple[float, ...]] | str]: ...
    @property
    def scene_of(self) -> Callable[[str], tuple[tuple[Any, ...], tuple[Any, ...]] | str]: ...

@final
class Sampler:
    """A template that is valid.

    Parameters
    ----------
    sections
        The values of a scene beside `objects`.
    groups
        For each item under `objects`: its name; the number of objects, None for a single one; the number of the
        group that they rest on; the number of the alternative of an object; the alternatives, each with all keys;
        and the kinds and margins of the constraints on its objects.
    order
        The numbers of the groups in the order in which their objects are placed.
    requirements
        What pictures must meet: the kind of each constraint, its bound, and the number of its group.
    tries
        The most tries of an object, and of a sample.
    """

    def __new__(
        cls,
        sections: dict[str, CompiledValue],
        groups: Sequence[
            tuple[
                str | None,
                CompiledValue | None,
                int | None,
                CompiledValue,
                list[dict[str, CompiledValue]],
                list[tuple[str, float]],
            ]
        ],
        order: list[int],
        requirements: list[tuple[str, float, int]],
        tries: int,
        /,
    ) -> Sampler: ...
    def sections(self, draw: _Draw, /) -> dict[str, str]:
        """Return the sections of a sample in JSON."""

    def sample(
        self,
        draw: tuple[int, list[str]],
        request: _SampleRequest,
        labels: tuple[str, str, bool] | None,
        models: Models,
        /,
    ) -> Sample:
        """Make a sample, drawn again until it meets all constraints, without the lock of the interpreter.

        Parameters
        ----------
        draw
            The index, and the values of draws `factor`, in JSON, by their numbers.
        request
            Its outputs beside its scene.
        labels
            If labels are wanted: the name of the split, the values of all factors in JSON, and whether objects
            have labels.
        models
            Answers questions about what is not plainly valid.
        """

@final
class Boxes:
    """The smallest box along the axes around each of many objects.

    Parameters
    ----------
    centers, halves
        The center of each, and half its size, float64: infinite around an object without an end.

    Raises
    ------
    ValueError
        If there are not as many of both.
    """

    def __new__(cls, centers: bytes, halves: bytes, /) -> Boxes: ...
    def meeting(self, center: Vector, half: Vector, /) -> list[int]:
        """Return the indices of all that meet a box, in order; more where rounding hides whether they do."""

    def beyond(self, eye: Vector, planes: list[tuple[Vector, float, float]], /) -> list[int]:
        """Return the indices of all with a point p beyond a plane, in order; more where rounding hides it.

        Of each plane, its normal n, an offset and a limit are given: n.(p - eye) + offset <= limit is beyond it.
        """

@final
class Enclosures:
    """A search for boxes that hold others, with a limited number of comparisons.

    Parameters
    ----------
    boxes
        Many boxes.
    chosen
        The indices of those that may hold others.
    comparisons
        How many it makes before it gives up.

    Raises
    ------
    ValueError
        If there is no box with such an index.
    """

    def __new__(cls, boxes: Boxes, chosen: list[int], comparisons: int, /) -> Enclosures: ...
    @property
    def gave_up(self) -> bool:
        """Whether a search ended early, because it would have taken too many comparisons."""

    def around(self, center: Vector, half: Vector, is_wanted: Callable[[int], bool], /) -> int | None:
        """Return the index of the first box that holds another and is wanted."""

    def first_inside(
        self, inner: bytes, start: int, is_wanted: Callable[[int, int], bool], /
    ) -> tuple[int, int] | None:
        """Return the place of the first of some boxes, uint64, that another holds, and the index of that one.

        The search begins at a place and looks at no index after the box it finds; `is_wanted` gets the indices of
        the inner box and the outer one.

        Raises
        ------
        ValueError
            If there is no box with an index that it looks at.
        """

@final
class Body:
    """A solid object: its kind, a name of `SHAPE_PARAMETERS`, its center, and its parameters.

    Raises
    ------
    ValueError
        If objects of this kind are not solid.
    """

    def __new__(cls, kind: str, position: Vector, parameters: Sequence[float], /) -> Body: ...
    def reach(self, direction: Vector, /) -> float:
        """Return the largest product of a direction and a point of the body, relative to its center."""

    def inradius(self) -> float:
        """Return the radius of the largest ball around the center that is within the body."""

    def distance(self, other: Body, /) -> float:
        """Return the distance between the surfaces of two bodies, 0 if they overlap."""
