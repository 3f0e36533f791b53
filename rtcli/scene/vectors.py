"""Vectors of three finite floats, computed so that the largest and smallest floats do not overflow or vanish."""

from __future__ import annotations

import math
from typing import TypeAlias

Vector: TypeAlias = tuple[float, float, float]

# Directions count as parallel when the sine of the angle between them is not above this.
_MIN_SINE = 1e-9


def unit(vector: Vector) -> Vector:
    """Return the unit vector: v / |v| (document, section 1.2.1)."""
    # Scaled first, so that no square overflows or vanishes.
    largest = max(map(abs, vector))
    x, y, z = (component / largest for component in vector)
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


def cross(a: Vector, b: Vector) -> Vector:
    """Return the cross product a x b (document, section 1.2.1)."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def direction(start: Vector, end: Vector) -> Vector:
    """Return the vector from start to end, of any length but with finite components."""
    x, y, z = (there - here for here, there in zip(start, end, strict=True))
    if math.isinf(x) or math.isinf(y) or math.isinf(z):
        # The difference of two finite numbers may overflow; the difference of their halves cannot.
        x, y, z = (there / 2 - here / 2 for here, there in zip(start, end, strict=True))
    return x, y, z


def view_direction(position: Vector, look_at: Vector | None) -> Vector:
    """Return the direction from an eye to the point it looks at, of any length; along -z without one."""
    return (0.0, 0.0, -1.0) if look_at is None else direction(position, look_at)


def are_parallel(a: Vector, b: Vector) -> bool:
    """Return whether two vectors of any length but 0 point the same way, or opposite ways.

    The sine of the angle between them is |a x b| of the unit vectors.
    """
    x, y, z = cross(unit(a), unit(b))
    return math.sqrt(x * x + y * y + z * z) <= _MIN_SINE


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product a . b (document, section 1.2.1)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def negative(a: Vector) -> Vector:
    """Return the opposite vector, with 0 for the opposite of 0."""
    return 0.0 - a[0], 0.0 - a[1], 0.0 - a[2]


def scaled(a: Vector, factor: float) -> Vector:
    """Return the product of a vector and a number."""
    return a[0] * factor, a[1] * factor, a[2] * factor


def moved(point: Vector, vector: Vector, factor: float = 1.0) -> Vector:
    """Return a point moved by a multiple of a vector."""
    return point[0] + vector[0] * factor, point[1] + vector[1] * factor, point[2] + vector[2] * factor
