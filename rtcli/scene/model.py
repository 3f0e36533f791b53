"""The scene file as pydantic models: every key, its meaning, unit, default and bounds.

The models are frozen and take exactly the documented keys. Lengths share one unit of the author's choice, angles
are degrees, colors linear RGB. `rtcli.scene.schema` turns this module into the JSON Schema that editors use.

The constructors that type checkers see accept what validation accepts: any iterable of numbers for a vector, a
name for a color, a mapping for a part.
"""

from __future__ import annotations

import inspect
import itertools
import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    GetPydanticSchema,
    ModelWrapValidatorHandler,
    Tag,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    field_validator,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError, PydanticKnownError, core_schema
from typing_extensions import Self, TypeAliasType

from rtcli.curves import ToneName
from rtcli.scene.bounds import MAX_NAME, MAX_SAMPLES, MAX_SHADOW_SAMPLES, MAX_SIDE
from rtcli.scene.colors import color_from_text
from rtcli.scene.diagnostics.problems import MAX_PROBLEMS
from rtcli.scene.plain import plain
from rtcli.scene.vectors import are_parallel, cross, dot, negative, view_direction

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Integer = Annotated[int, Field(strict=True)]
# `rtcli.scene.vectors.Vector` with the checks of a scene file.
Vector: TypeAlias = tuple[Number, Number, Number]

WHITE = (1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0)
ZERO = (0.0, 0.0, 0.0)
_UPRIGHT = (0.0, 1.0, 0.0)


def _not_zero(vector: Vector) -> Vector:
    if vector == ZERO:
        raise PydanticCustomError("zero_length", "must not be [0, 0, 0]")
    return vector


# A vector other than 0. The models report a zero in better words than the schema.
Direction: TypeAlias = Annotated[
    Vector, AfterValidator(_not_zero), Field(json_schema_extra={"not": {"const": [0, 0, 0]}})
]


def _given(value: Any) -> Any:
    """Refuse an explicit null: an omitted key has a default, but a key without a value is a slip."""
    if value is None:
        raise PydanticCustomError("no_value", "has no value")
    return value


NotNull = BeforeValidator(_given)


def _color(value: Any) -> Any:
    if isinstance(value, str):
        color = color_from_text(value)
        if color is None:
            raise PydanticCustomError("color_name", "is not a color", {"name": value})
        return color
    if not isinstance(value, (list, tuple)):
        raise PydanticCustomError("color_kind", "is not a color")
    return value


_Share = Annotated[NotNegative, Field(le=1)]
# Named types, so that the schema defines each once; it adds the texts that name a color there.
Albedo = TypeAliasType("Albedo", Annotated[tuple[_Share, _Share, _Share], BeforeValidator(_color)])
LightColor = TypeAliasType(
    "LightColor", Annotated[tuple[NotNegative, NotNegative, NotNegative], BeforeValidator(_color)]
)
Side = Annotated[Integer, Field(ge=1, le=MAX_SIDE)]


def _exposure(value: Any) -> Any:
    if value != "auto" and (isinstance(value, bool) or not isinstance(value, (int, float))):
        raise PydanticCustomError("exposure_kind", "must be a number of stops or auto")
    if value != "auto" and not -sys.float_info.max <= value <= sys.float_info.max:
        raise PydanticCustomError("finite_number", "must be finite")
    return value


Exposure = Annotated[
    float | Literal["auto"],
    BeforeValidator(_exposure),
    WithJsonSchema({"anyOf": [{"type": "number"}, {"const": "auto"}]}),
]


def _angles(value: Any, vector: ValidatorFunctionWrapHandler) -> Any:
    if isinstance(value, (list, tuple)):
        return vector(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise PydanticKnownError("float_type")
    if not -sys.float_info.max <= value <= sys.float_info.max:
        raise PydanticKnownError("finite_number")
    return float(value)


def _rotation_schema(_: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
    """Check a list as a vector and anything else as a number: a union would report what both find wrong."""
    as_it_is = core_schema.plain_serializer_function_ser_schema(lambda value: value)
    return core_schema.no_info_wrap_validator_function(_angles, handler(Vector), serialization=as_it_is)


_NUMBER_SCHEMA = {"type": "number"}
Rotation = Annotated[
    float | Vector,
    GetPydanticSchema(_rotation_schema),
    WithJsonSchema(
        {"anyOf": [_NUMBER_SCHEMA, {"type": "array", "items": _NUMBER_SCHEMA, "minItems": 3, "maxItems": 3}]}
    ),
]


# What the constructors accept for a vector, a color, and a part of a scene.
Numbers: TypeAlias = Iterable[float]
ColorLike: TypeAlias = str | Iterable[float]
Keys: TypeAlias = Mapping[str, Any]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    def __init__(self, /, *unnamed: Any, **values: Any) -> None:
        if unnamed:
            fields = type(self).model_fields
            likeliest = sorted(keys_in_order(type(self)), key=lambda key: not fields[key].is_required())
            named = ", ".join(f"{key}=..." for key in likeliest[: len(unnamed)])
            raise TypeError(f"every argument needs its name: rtcli.{type(self).__name__}({named})")
        given = {key: plain(value) for key, value in values.items() if value is not None}
        try:
            super().__init__(**given)
        except ValidationError:
            # Above this module, but needed only for a mistake.
            from rtcli.scene.validation.from_python import constructor_error

            raise constructor_error(type(self), given) from None

    # Pydantic then builds nested models without calling their constructors, which is many times as fast.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Give `help` a signature of one line; pydantic's own spells out how each value is checked."""
        keyword, empty = inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.empty
        parameters = [
            inspect.Parameter(key, keyword, default=empty if field.is_required() else field.default)
            for key, field in cls.model_fields.items()
        ]
        cls.__signature__ = inspect.Signature(parameters)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a {type(self).__name__} cannot change: replace({name}=...) returns a changed copy")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a {type(self).__name__} cannot change: replace({name}=None) returns a changed copy")

    def replace(self, **changes: Any) -> Self:
        """Return a copy with other values for some keys, validated like a new object.

        Parameters
        ----------
        **changes
            The keys to change, as the class takes them. None restores a default.

        Raises
        ------
        rtcli.SceneError
            If the result is not valid.
        """
        given = {key: value for key, value in self if key in self.model_fields_set}
        return type(self)(**{**given, **changes})


# --- The camera ------------------------------------------------------------------------------------------

# The keys for what the picture spans: a camera has one of them, the last one if it is orthographic.
_LENSES = ("fov", "fov_x", "intrinsics")
_HEIGHT = "height"
# The keys for where the camera is: a matrix, or the others.
_POSES = ("opencv", "opengl")
_AIMS = ("position", "look_at", "up")
# How far a matrix may be from a rigid motion.
_RIGID = 1e-6
# How far from its principal point a picture may reach, in focal lengths.
_MAX_SLOPE = 1e12


def _equal_to(number: int) -> AfterValidator:
    def check(value: float) -> float:
        if value != number:
            raise PydanticCustomError("fixed_number", "must be {number}", {"number": number})
        return value

    return AfterValidator(check)


_Zero: TypeAlias = Annotated[Number, _equal_to(0), Field(json_schema_extra={"const": 0})]
_One: TypeAlias = Annotated[Number, _equal_to(1), Field(json_schema_extra={"const": 1})]
_Angle: TypeAlias = Annotated[Positive, Field(lt=180)]
_Focal: TypeAlias = Annotated[Positive, Field(le=1e12)]
Intrinsics: TypeAlias = tuple[
    tuple[_Focal, _Zero, Number], tuple[_Zero, _Focal, Number], tuple[_Zero, _Zero, _One]
]
_Row: TypeAlias = tuple[Number, Number, Number, Number]
_Matrix: TypeAlias = tuple[_Row, _Row, _Row, tuple[_Zero, _Zero, _Zero, _One]]


def _not_rigid(matrix: _Matrix) -> str | None:
    """Return why a matrix is no rigid motion, or None: its columns must be a right-handed orthonormal frame."""
    axes = _columns(matrix)[:3]
    for (i, a), (j, b) in itertools.combinations_with_replacement(enumerate(axes), 2):
        if not abs(dot(a, b) - (i == j)) <= _RIGID:
            return (
                f"column {i} has the length {math.sqrt(dot(a, a)):.9g}"
                if i == j
                else f"columns {i} and {j} are not perpendicular"
            )
    return "it mirrors the scene" if dot(cross(axes[0], axes[1]), axes[2]) < 0 else None


def _columns(matrix: _Matrix) -> tuple[Vector, Vector, Vector, Vector]:
    """Return the columns of a matrix without the last row."""
    x, y, z, _ = matrix
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2]), (x[3], y[3], z[3])


def _are_close(one: Iterable[Iterable[float]], other: Iterable[Iterable[float]], reach: float) -> bool:
    """Return whether the rows of two rigid motions agree, which reach so far from the origin."""
    tolerances = (_RIGID, _RIGID, _RIGID, _RIGID * max(1.0, reach))
    return all(
        abs(a - b) <= tolerance
        for row, same in zip(one, other, strict=False)
        for a, b, tolerance in zip(row, same, tolerances, strict=True)
    )


_POSE = [[1, 0, 0, 0], [0, 1, 0, 2], [0, 0, 1, 8], [0, 0, 0, 1]]


class Pose(_Model):
    """Where a camera is and how it is turned, as a matrix."""

    camera_to_world: _Matrix = Field(examples=[_POSE])
    """A rigid motion, as four rows: takes columns (x, y, z, 1) from the camera's axes to the world."""
    world_to_camera: Annotated[_Matrix | None, NotNull] = None
    """Its inverse, which metadata state as well. It may be left out, and changes nothing."""

    if TYPE_CHECKING:

        def __init__(
            self, *, camera_to_world: Iterable[Numbers], world_to_camera: Iterable[Numbers] | None = None
        ) -> None: ...

    @field_validator("camera_to_world")
    @classmethod
    def _is_rigid(cls, matrix: _Matrix) -> _Matrix:
        reason = _not_rigid(matrix)
        if reason is not None:
            raise PydanticCustomError("not_rigid", "must be a rigid motion: {reason}", {"reason": reason})
        return matrix

    @field_validator("world_to_camera")
    @classmethod
    def _is_inverse(cls, matrix: _Matrix | None, info: ValidationInfo) -> _Matrix | None:
        if matrix is not None and "camera_to_world" in info.data:
            *axes, eye = _columns(info.data["camera_to_world"])
            inverse = ((*axis, -dot(axis, eye)) for axis in axes)
            if not _are_close(inverse, matrix, max(map(abs, eye))):
                raise PydanticCustomError("poses_differ", "must be the inverse of `camera_to_world`")
        return matrix


def _without(keys: Iterable[str]) -> dict[str, Any]:
    return {"not": {"anyOf": [{"required": [key]} for key in keys]}}


# The schema of the keys that need or exclude each other.
_ORTHOGRAPHIC = {"required": ["projection"], "properties": {"projection": {"const": "orthographic"}}}
_RULES_OF_CAMERA: dict[str, Any] = {
    "oneOf": [
        *({"required": [key], "properties": {"projection": {"const": "perspective"}}} for key in _LENSES),
        {"required": [_HEIGHT], **_without(_LENSES)},
    ],
    "dependencies": {_HEIGHT: _ORTHOGRAPHIC, **{pose: _without(_AIMS) for pose in _POSES}},
}


class Camera(_Model):
    """A camera without a lens. By default it is at the origin and looks along -z."""

    model_config = ConfigDict(json_schema_extra=_RULES_OF_CAMERA)

    resolution: tuple[Side, Side] = Field(examples=[[640, 480], [1920, 1080]])
    """Width and height of the picture in pixels, each 1 to 65,535."""
    fov: Annotated[_Angle | None, NotNull] = Field(default=None, examples=[20, 60])
    """Vertical field of view in degrees, between 0 and 180."""
    fov_x: Annotated[_Angle | None, NotNull] = Field(default=None, examples=[40])
    """Horizontal field of view in degrees, between 0 and 180, in place of `fov`."""
    intrinsics: Annotated[Intrinsics | None, NotNull] = Field(
        default=None, examples=[[[800, 0, 319.5], [0, 800, 239.5], [0, 0, 1]]]
    )
    """K in place of `fov`: [[f_x, 0, c_x], [0, f_y, c_y], [0, 0, 1]], in pixels with integers at pixel centers."""
    projection: Literal["perspective", "orthographic"] = Field(default="perspective", examples=["orthographic"])
    """`perspective`, or `orthographic` with `height` in place of `fov`: all rays are parallel to the view."""
    height: Annotated[Positive | None, NotNull] = Field(default=None, examples=[10])
    """Length from the bottom to the top of an orthographic picture, in units of the scene."""
    position: Vector = Field(default=ZERO, examples=[[0, 2, 8]])
    """The position of the eye: x, y, z."""
    look_at: Annotated[Vector | None, NotNull] = Field(default=None, examples=[[0, 1, 0]])
    """The point shown at the center of the picture. Default: position + [0, 0, -1], a view along -z."""
    up: Direction = Field(default=(0.0, 1.0, 0.0), examples=[[0, 1, 0]], validate_default=True)
    """The direction that points up in the picture: not zero, not parallel to the viewing direction."""
    opencv: Annotated[Pose | None, NotNull] = Field(
        default=None, examples=[{"camera_to_world": [[1, 0, 0, 0], [0, -1, 0, 2], [0, 0, -1, 8], [0, 0, 0, 1]]}]
    )
    """The pose, in place of `position`, `look_at` and `up`: x to the right, y down, z along the view."""
    opengl: Annotated[Pose | None, NotNull] = Field(default=None, examples=[{"camera_to_world": _POSE}])
    """The same with x to the right, y up, z opposite to the view. With both, they must agree."""

    if TYPE_CHECKING:

        def __init__(  # noqa: PLR0913 - one for each key of a camera
            self,
            *,
            resolution: Iterable[int],
            fov: float | None = None,
            fov_x: float | None = None,
            intrinsics: Iterable[Numbers] | None = None,
            projection: Literal["perspective", "orthographic"] = ...,
            height: float | None = None,
            position: Numbers = ...,
            look_at: Numbers | None = None,
            up: Numbers = ...,
            opencv: Pose | Keys | None = None,
            opengl: Pose | Keys | None = None,
        ) -> None: ...

    @model_validator(mode="wrap")
    @classmethod
    def _keys_fit_each_other(cls, data: Any, validate: ModelWrapValidatorHandler[Self]) -> Self:
        """Report keys that exclude each other together with all other errors of the camera."""
        problems = list(_conflicts(data)) if isinstance(data, dict) else []
        if not problems:
            return validate(data)
        try:
            validate(data)
        except ValidationError as error:
            problems = _line_errors(error) + problems
        raise ValidationError.from_exception_data("Camera", problems)

    @field_validator("intrinsics")
    @classmethod
    def _is_in_front(cls, intrinsics: Intrinsics | None, info: ValidationInfo) -> Intrinsics | None:
        if intrinsics is not None:
            for axis, size in enumerate(info.data.get("resolution", ())):
                focal, center = intrinsics[axis][axis], intrinsics[axis][2]
                if max(abs(center), abs(size - center)) > _MAX_SLOPE * focal:
                    raise PydanticCustomError("too_oblique", "the picture is too far from its principal point")
        return intrinsics

    @field_validator("look_at")
    @classmethod
    def _look_somewhere(cls, look_at: Vector | None, info: ValidationInfo) -> Vector | None:
        if look_at is not None and look_at == info.data.get("position"):
            raise PydanticCustomError("no_direction", "must differ from the camera's position")
        return look_at

    @field_validator("up")
    @classmethod
    def _up_is_up(cls, up: Vector, info: ValidationInfo) -> Vector:
        seen = info.data
        if seen.keys() >= {"position", "look_at"} and are_parallel(
            view_direction(seen["position"], seen["look_at"]), up
        ):
            raise PydanticCustomError("up_along_view", "must not be parallel to the viewing direction")
        return up

    @field_validator("opengl")
    @classmethod
    def _poses_agree(cls, opengl: Pose | None, info: ValidationInfo) -> Pose | None:
        opencv = info.data.get("opencv")
        if opengl is not None and opencv is not None:
            turned = ((x, -y, -z, eye) for x, y, z, eye in opencv.camera_to_world[:3])
            reach = max(abs(row[3]) for row in opencv.camera_to_world[:3])
            if not _are_close(turned, opengl.camera_to_world, reach):
                raise PydanticCustomError("poses_differ", "must be the pose that `opencv` gives")
        return opengl

    @property
    def eye(self) -> Vector:
        """The position of the eye, whichever keys give it."""
        pose = self.opencv or self.opengl
        return self.position if pose is None else _columns(pose.camera_to_world)[3]

    @property
    def view(self) -> Vector:
        """The direction of the view, of any length: from the eye through the principal point."""
        if self.opencv is not None:
            return _columns(self.opencv.camera_to_world)[2]
        if self.opengl is not None:
            return negative(_columns(self.opengl.camera_to_world)[2])
        return view_direction(self.position, self.look_at)

    @property
    def upward(self) -> Vector:
        """The direction that is up in the picture, of any length, not along the view."""
        if self.opencv is not None:
            return negative(_columns(self.opencv.camera_to_world)[1])
        return self.up if self.opengl is None else _columns(self.opengl.camera_to_world)[1]


def _conflicts(data: Mapping[str, Any]) -> Iterator[InitErrorDetails]:
    """Yield an error for each key of a camera that another excludes, or one if nothing says what it spans."""
    lenses = [key for key in data if key in _LENSES]
    excluded: list[tuple[str, str]] = []
    if data.get("projection", "perspective") != "perspective":  # or misspelt
        excluded += [(key, "projection: orthographic") for key in lenses]
        if _HEIGHT not in data:
            yield InitErrorDetails(type="missing", loc=(_HEIGHT,), input=data)
    elif _HEIGHT in data and not lenses and "projection" not in data:
        yield InitErrorDetails(type="missing", loc=("projection",), input=data)
    else:
        if not lenses:
            yield InitErrorDetails(type="missing", loc=("fov",), input=data)
        excluded += [(key, lenses[0]) for key in lenses[1:]]
        if _HEIGHT in data:
            excluded.append((_HEIGHT, lenses[0] if lenses else "projection: perspective"))
    pose = next((key for key in data if key in _POSES), None)
    excluded += [(key, pose) for key in data if pose and key in _AIMS]
    for key, other in excluded:
        error = PydanticCustomError("excluded", "excludes {other}", {"other": other})
        yield InitErrorDetails(type=error, loc=(key,), input=data[key])


# --- Lights ----------------------------------------------------------------------------------------------


class CarriedLight(_Model):
    """A point light at the center of the object that carries it. That object does not block it."""

    intensity: NotNegative = Field(examples=[4.0e6])
    """Emitted power; the light at distance r is intensity * color / (4 pi r^2)."""
    radius: NotNegative = Field(default=0.0, examples=[0.3])
    """The radius of the ball that shines; above 0, shadows have soft borders. It is not seen itself."""
    color: LightColor = Field(default=WHITE, examples=[[1, 0.9, 0.7], "orange", "#ffd9a0"])
    """[r, g, b], linear, each 0 or more; or a CSS name or #rrggbb."""

    if TYPE_CHECKING:

        def __init__(self, *, intensity: float, radius: float = ..., color: ColorLike = ...) -> None: ...

    @property
    def strength(self) -> float:
        """The number that the tracers multiply the color by."""
        return self.intensity


class PointLight(CarriedLight):
    """A light that emits equally in all directions: a point, or a ball that shines evenly."""

    type: Literal["point"] = "point"
    """The kind of light."""
    position: Vector = Field(examples=[[0, 15, -150]])
    """The position of the light: x, y, z."""

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            type: Literal["point"] = ...,
            intensity: float,
            position: Numbers,
            radius: float = ...,
            color: ColorLike = ...,
        ) -> None: ...

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that distinguish this light from others, beside its color and intensity."""
        return (*self.position, self.radius)


class SunLight(_Model):
    """A sun: light from infinitely far away, the same everywhere."""

    type: Literal["sun"] = "sun"
    """The kind of light."""
    direction: Direction = Field(examples=[[-1, -2, -0.5]])
    """The direction in which the light travels, not zero: [0, -1, 0] shines straight down."""
    irradiance: NotNegative = Field(examples=[3])
    """The light that arrives, irradiance * color, on a surface that faces the sun."""
    angle: Annotated[NotNegative, Field(lt=90)] = Field(default=0.0, examples=[0.53])
    """The angular diameter in degrees, below 90; above 0, shadows have soft borders. The real sun has 0.53."""
    color: LightColor = Field(default=WHITE, examples=[[1, 0.9, 0.7], "orange", "#ffd9a0"])
    """[r, g, b], linear, each 0 or more; or a CSS name or #rrggbb."""

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            type: Literal["sun"] = ...,
            direction: Numbers,
            irradiance: float,
            angle: float = ...,
            color: ColorLike = ...,
        ) -> None: ...

    @property
    def strength(self) -> float:
        """The number that the tracers multiply the color by."""
        return self.irradiance

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that distinguish this light from others, beside its color and irradiance."""
        return (*self.direction, self.angle)


# The type of a light that does not name it.
USUAL_LIGHT = "point"


def _type_of_light(light: Any) -> str:
    """Return the type of a light, of data or a model; an empty text if it is none."""
    found = light.get("type", USUAL_LIGHT) if isinstance(light, dict) else getattr(light, "type", USUAL_LIGHT)
    return found if isinstance(found, str) else ""


Light: TypeAlias = Annotated[
    Annotated[PointLight, Tag("point")] | Annotated[SunLight, Tag("sun")], Discriminator(_type_of_light)
]
# By the `type` that each has in a scene file.
LIGHTS: dict[str, type[_Model]] = {"point": PointLight, "sun": SunLight}


class _Shape(_Model):
    name: Annotated[str | None, NotNull] = Field(
        default=None, min_length=1, max_length=MAX_NAME, examples=["tall box"]
    )
    """A name, unique in the scene; messages, ids and `--set objects.NAME...` use it."""
    color: Albedo = Field(examples=[[0.9, 0.9, 0.9], "tomato", "#b3b3b3"])
    """The albedo: [r, g, b], linear, each 0 to 1; or a CSS name or #rrggbb."""


class Checker(_Model):
    """Squares in two colors on a flat face, like those of a chessboard."""

    size: Positive = Field(examples=[0.5])
    """The side of a square, greater than 0."""
    color: Albedo = Field(examples=[[0.1, 0.1, 0.1], "black"])
    """The albedo of every other square; the rest have the color of the object."""

    if TYPE_CHECKING:

        def __init__(self, *, size: float, color: ColorLike) -> None: ...


_CHECKER = Field(default=None, examples=[{"size": 0.5, "color": "black"}])


class Plane(_Shape):
    """An infinite plane, visible and lit from both sides."""

    type: Literal["plane"] = "plane"
    """The kind of shape."""
    position: Vector = Field(examples=[[0, -20, 0]])
    """Any point on the plane."""
    normal: Direction = Field(examples=[[0, 1, 0]])
    """A direction perpendicular to the plane, not zero."""
    checker: Annotated[Checker | None, NotNull] = _CHECKER
    """A pattern of squares, whose corners lie at `position` and on the axes u and v of the plane."""
    # Gives every shape the attribute. Not a key of a scene file.
    light: ClassVar[None] = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            type: Literal["plane"] = ...,
            color: ColorLike,
            position: Numbers,
            normal: Numbers,
            name: str | None = None,
            checker: Checker | Keys | None = None,
        ) -> None: ...

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that distinguish this plane from others, beside its position."""
        return self.normal


class _Body(_Shape):
    position: Vector = Field(examples=[[0, 1, 0]])
    """The center: x, y, z."""
    light: Annotated[CarriedLight | None, NotNull] = Field(default=None, examples=[{"intensity": 1000}])
    """Turns this object into the body of a point light: it shines and does not block its own light."""


class Sphere(_Body):
    """A sphere."""

    type: Literal["sphere"] = "sphere"
    """The kind of shape."""
    radius: Positive = Field(examples=[2.5])
    """The radius, greater than 0."""

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            type: Literal["sphere"] = ...,
            color: ColorLike,
            position: Numbers,
            radius: float,
            name: str | None = None,
            light: CarriedLight | Keys | None = None,
        ) -> None: ...

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that distinguish this sphere from others, beside its position."""
        return (self.radius,)


class Box(_Body):
    """A box, rotated in any way."""

    type: Literal["box"] = "box"
    """The kind of shape."""
    size: tuple[Positive, Positive, Positive] = Field(examples=[[12.5, 40, 12.5]])
    """Width (x), height (y) and depth (z), each greater than 0."""
    rotation: Rotation = Field(default=0.0, examples=[45, [20, 45, 0]])
    """Degrees about +y, counter-clockwise seen from above; or [x, y, z]: about x, then y, then z."""
    checker: Annotated[Checker | None, NotNull] = _CHECKER
    """A pattern of squares on each face, whose corners lie at its middle and on the axes of the box."""

    if TYPE_CHECKING:

        def __init__(  # noqa: PLR0913 - one for each key of a box
            self,
            *,
            type: Literal["box"] = ...,
            color: ColorLike,
            position: Numbers,
            size: Numbers,
            name: str | None = None,
            light: CarriedLight | Keys | None = None,
            rotation: float | Numbers = ...,
            checker: Checker | Keys | None = None,
        ) -> None: ...

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that distinguish this box from others, beside its position."""
        x, y, z = self.angles
        return (*self.size, y, x, z)

    @property
    def angles(self) -> Vector:
        """The degrees by which the box is rotated about the axes of the scene, first about x, then y, then z."""
        return self.rotation if isinstance(self.rotation, tuple) else (0.0, self.rotation, 0.0)


class Cylinder(_Body):
    """A cylinder, closed by two discs."""

    type: Literal["cylinder"] = "cylinder"
    """The kind of shape."""
    radius: Positive = Field(examples=[0.5])
    """The radius, greater than 0."""
    height: Positive = Field(examples=[3])
    """The distance between the discs, greater than 0."""
    axis: Direction = Field(default=_UPRIGHT, examples=[[0, 1, 0], [1, 1, 0]])
    """The direction of the axis, of any length but 0."""

    if TYPE_CHECKING:

        def __init__(  # noqa: PLR0913 - one for each key of a cylinder
            self,
            *,
            type: Literal["cylinder"] = ...,
            color: ColorLike,
            position: Numbers,
            radius: float,
            height: float,
            name: str | None = None,
            light: CarriedLight | Keys | None = None,
            axis: Numbers = ...,
        ) -> None: ...

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that distinguish this cylinder from others, beside its position."""
        return (self.radius, self.height, *self.axis)


class Capsule(_Body):
    """A cylinder with half spheres for ends."""

    type: Literal["capsule"] = "capsule"
    """The kind of shape."""
    radius: Positive = Field(examples=[0.5])
    """The radius of the cylinder and the half spheres, greater than 0."""
    height: NotNegative = Field(examples=[2])
    """The distance between the centers of the half spheres, 0 or more; with 0 the capsule is a sphere."""
    axis: Direction = Field(default=_UPRIGHT, examples=[[0, 1, 0], [1, 1, 0]])
    """The direction of the axis, of any length but 0."""

    if TYPE_CHECKING:

        def __init__(  # noqa: PLR0913 - one for each key of a capsule
            self,
            *,
            type: Literal["capsule"] = ...,
            color: ColorLike,
            position: Numbers,
            radius: float,
            height: float,
            name: str | None = None,
            light: CarriedLight | Keys | None = None,
            axis: Numbers = ...,
        ) -> None: ...

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that distinguish this capsule from others, beside its position."""
        return (self.radius, self.height, *self.axis)


class Cone(_Body):
    """A cone, or the frustum of one, closed by discs."""

    type: Literal["cone"] = "cone"
    """The kind of shape."""
    position: Vector = Field(examples=[[0, 1, 0]])
    """The middle of the axis: x, y, z."""
    radius: Positive = Field(examples=[1])
    """The radius of the base, greater than 0."""
    top_radius: NotNegative = Field(default=0.0, examples=[0, 0.5])
    """The radius of the top, 0 or more; with 0 the cone ends in its tip."""
    height: Positive = Field(examples=[2])
    """The distance from the base to the top, greater than 0."""
    axis: Direction = Field(default=_UPRIGHT, examples=[[0, 1, 0], [1, 1, 0]])
    """The direction from the base to the top, of any length but 0."""

    if TYPE_CHECKING:

        def __init__(  # noqa: PLR0913 - one for each key of a cone
            self,
            *,
            type: Literal["cone"] = ...,
            color: ColorLike,
            position: Numbers,
            radius: float,
            height: float,
            name: str | None = None,
            light: CarriedLight | Keys | None = None,
            top_radius: float = ...,
            axis: Numbers = ...,
        ) -> None: ...

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that distinguish this cone from others, beside its position."""
        return (self.radius, self.top_radius, self.height, *self.axis)


Object: TypeAlias = Annotated[Sphere | Plane | Box | Cylinder | Capsule | Cone, Field(discriminator="type")]
# By the `type` that each has in a scene file, the name of its class in lower case.
SHAPES: dict[str, type[_Shape]] = {shape.__name__.lower(): shape for shape in get_args(get_args(Object)[0])}
# The keys of an object whose values are mappings.
PARTS: dict[str, type[_Model]] = {"light": CarriedLight, "checker": Checker}


class RenderSettings(_Model):
    """How light is computed."""

    samples: Annotated[Integer, Field(ge=1, le=MAX_SAMPLES)] = 1
    """Rays per pixel, 1 to 1,024, in a fixed pattern: 1 uses the pixel's center; higher values smooth edges."""
    background: LightColor = BLACK
    """The radiance of rays that hit nothing, as a color."""
    ambient: LightColor = BLACK
    """Light from all around that nothing blocks, as a color: adds albedo * ambient to each surface."""
    max_depth: Annotated[Integer, Field(ge=0)] = 1
    """0: only objects that carry a light are seen; 1 or more: direct light with shadows."""
    shadow_samples: Annotated[Integer, Field(ge=1, le=MAX_SHADOW_SAMPLES)] = 64
    """Places of each light with a size, 1 to 1,024, in a fixed pattern: higher values smooth soft shadows."""
    eye_falloff: Annotated[bool, Field(strict=True)] = False
    """Also divide by 4 pi t^2, where t is the distance to the eye. Not physical, but some courses teach it."""

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            samples: int = ...,
            background: ColorLike = ...,
            ambient: ColorLike = ...,
            max_depth: int = ...,
            shadow_samples: int = ...,
            eye_falloff: bool = ...,
        ) -> None: ...


class ImageSettings(_Model):
    """How radiance becomes an image."""

    exposure: Exposure = 0.0
    """Exposure in stops, each a factor of 2; or auto."""
    tone: ToneName = "clip"
    """The tone curve: clip cuts off at white; reinhard and aces compress bright light gradually."""
    alpha: Annotated[bool, Field(strict=True)] = False
    """Leave the background out, and record the share of each pixel that objects cover."""

    if TYPE_CHECKING:

        def __init__(
            self, *, exposure: float | Literal["auto"] = ..., tone: ToneName = ..., alpha: bool = ...
        ) -> None: ...


class Scene(_Model):
    """A scene: a camera, lights, objects, and settings for the picture."""

    version: Literal[1] = 1
    """The version of the scene format."""
    camera: Camera = Field(examples=[{"resolution": [640, 480], "fov": 40}])
    """The position and view of the camera, and the size of the picture."""
    lights: tuple[Light, ...] = Field(default=(), examples=[[{"position": [0, 5, 0], "intensity": 1000}]])
    """Point lights and suns."""
    objects: tuple[Object, ...] = Field(
        default=(), examples=[[{"type": "sphere", "position": [0, 0, -5], "radius": 1, "color": "tomato"}]]
    )
    """Spheres, planes, boxes, cylinders, capsules and cones."""
    render: RenderSettings = RenderSettings()
    """How light is computed: samples, background, ambient light, depth, falloff."""
    image: ImageSettings = ImageSettings()
    """How radiance becomes an image: exposure, tone curve, alpha."""

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            camera: Camera | Keys,
            version: Literal[1] = ...,
            lights: Iterable[PointLight | SunLight | Keys] = ...,
            objects: Iterable[Sphere | Plane | Box | Cylinder | Capsule | Cone | Keys] = ...,
            render: RenderSettings | Keys = ...,
            image: ImageSettings | Keys = ...,
        ) -> None: ...

    def to_yaml(self) -> str:
        """Return the scene as the text of a scene file, which reads back equal.

        Keys stand in the order of the scene format, and those with default values are left out. A color that has
        a CSS name or `#rrggbb` is written as that.
        """
        from rtcli.scene.write import yaml_text  # above this module

        return yaml_text(self)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the scene to a file, completely or not at all.

        Parameters
        ----------
        path
            The suffix decides the format: `.yaml` or `.yml`, or `.json`.

        Raises
        ------
        ValueError
            If no format of scenes has the suffix.
        OSError
            If the file cannot be written.
        """
        from rtcli.scene.write import save

        save(self, path)

    @field_validator("version", mode="before")
    @classmethod
    def _version_is_a_number(cls, version: Any) -> Any:
        if isinstance(version, (bool, float)):  # Python considers both equal to 1
            raise PydanticCustomError("literal_error", "must be 1", {"expected": "1"})
        return version

    @field_validator("lights", "objects", mode="wrap")
    @classmethod
    def _in_pieces(cls, items: Any, validate: ValidatorFunctionWrapHandler) -> Any:
        """Validate a long list piece by piece, and stop early if it is full of errors."""
        if isinstance(items, BaseModel):  # pydantic would take it for a list of its keys
            raise PydanticCustomError("tuple_type", "must be a list")
        if not isinstance(items, (list, tuple)) or len(items) <= _PIECE:
            return validate(items)
        valid: list[Any] = []
        errors: list[InitErrorDetails] = []
        for start in range(0, len(items), _PIECE):
            try:
                valid += validate(items[start : start + _PIECE])
            except ValidationError as error:
                errors += _line_errors(error, start)
            if len(errors) > MAX_PROBLEMS:
                break
        if errors:
            raise ValidationError.from_exception_data("Scene", errors)
        return tuple(valid)

    @field_validator("objects", mode="wrap")
    @classmethod
    def _names_are_unique(cls, objects: Any, validate: ValidatorFunctionWrapHandler) -> Any:
        """Report names used twice together with all other errors of the objects."""
        problems = list(itertools.islice(_repeated_names(objects), MAX_PROBLEMS + 1))
        if not problems:
            return validate(objects)
        try:
            validate(objects)
        except ValidationError as error:
            problems += _line_errors(error)
        raise ValidationError.from_exception_data("Scene", problems)


# The number of objects validated at a time; larger pieces are not faster.
_PIECE = 1_000


def _repeated_names(objects: Any) -> Iterable[InitErrorDetails]:
    """Yield an error for each object whose name was used before."""
    first: dict[str, int] = {}
    for index, item in enumerate(objects if isinstance(objects, (list, tuple)) else ()):
        name = item.get("name") if isinstance(item, dict) else getattr(item, "name", None)
        if isinstance(name, str) and first.setdefault(name, index) != index:
            context = {"first": first[name]}
            error = PydanticCustomError("name_taken", "is already taken by objects[{first}]", context)
            # Pydantic's own errors have the tag of the union's member in place of "object".
            yield InitErrorDetails(type=error, loc=(index, "object", "name"), input=name)


# The order of the keys of objects and lights: `_OWN` stands for those that only some have, such as `radius`.
_OWN = 3
_RANKS = {"type": 0, "name": 1, "position": 2, "color": 4, "checker": 5, "light": 6}


def keys_in_order(model: type[BaseModel]) -> list[str]:
    """Return the keys of a model in the order of the reference.

    They are as declared, except those of objects and lights: pydantic puts the keys of a base class first.
    """
    fields = model.model_fields
    return sorted(fields, key=lambda key: _RANKS.get(key, _OWN)) if "color" in fields else list(fields)


def _line_errors(error: ValidationError, start: int = 0) -> list[InitErrorDetails]:
    """Return the errors of a model, or of a piece of a list that begins at index `start`."""
    return [_line_error(details, start) for details in error.errors(include_url=False)[: MAX_PROBLEMS + 1]]


def _line_error(details: Any, start: int) -> InitErrorDetails:
    error = PydanticCustomError(details["type"], "{text}", {**details.get("ctx", {}), "text": details["msg"]})
    first, *rest = details["loc"]
    loc = (first + start if isinstance(first, int) else first, *rest)
    return InitErrorDetails(type=error, loc=loc, input=details["input"])
