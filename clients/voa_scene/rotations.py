"""Rotations between directions and quaternions, in plain Python."""

import math

from voa_scene.shapes import Quaternion, Vector

_TINY = 1e-12


def about_z(angle: float) -> Quaternion:
    """Rotation about the vertical axis by an angle, radians, counter-clockwise."""
    return (math.cos(angle / 2.0), 0.0, 0.0, math.sin(angle / 2.0))


def unit(vector: Vector) -> Vector:
    """Return a vector's direction, of length 1; the vector is not 0."""
    length = math.hypot(*vector)
    return (vector[0] / length, vector[1] / length, vector[2] / length)


def cross(one: Vector, other: Vector) -> Vector:
    """Return the cross product of two vectors."""
    return (
        one[1] * other[2] - one[2] * other[1],
        one[2] * other[0] - one[0] * other[2],
        one[0] * other[1] - one[1] * other[0],
    )


def along(start: Vector, direction: Vector, distance: float) -> Vector:
    """Return the point at a distance from a start along a direction of length 1."""
    return (start[0] + distance * direction[0], start[1] + distance * direction[1], start[2] + distance * direction[2])


def of_axes(x: Vector, y: Vector, z: Vector) -> Quaternion:
    """Rotation that turns the world's axes into three given ones, which are perpendicular and of length 1.

    Shepperd's method: the largest of the four parts is computed first, so that no division is by a small number.
    """
    trace = x[0] + y[1] + z[2]
    parts = (trace, x[0], y[1], z[2])
    largest = parts.index(max(parts))
    if largest == 0:
        w = math.sqrt(1.0 + trace) / 2.0
        return (w, (y[2] - z[1]) / (4.0 * w), (z[0] - x[2]) / (4.0 * w), (x[1] - y[0]) / (4.0 * w))
    if largest == 1:
        a = math.sqrt(max(1.0 + x[0] - y[1] - z[2], _TINY)) / 2.0
        return ((y[2] - z[1]) / (4.0 * a), a, (y[0] + x[1]) / (4.0 * a), (z[0] + x[2]) / (4.0 * a))
    if largest == 2:
        b = math.sqrt(max(1.0 - x[0] + y[1] - z[2], _TINY)) / 2.0
        return ((z[0] - x[2]) / (4.0 * b), (y[0] + x[1]) / (4.0 * b), b, (z[1] + y[2]) / (4.0 * b))
    c = math.sqrt(max(1.0 - x[0] - y[1] + z[2], _TINY)) / 2.0
    return ((x[1] - y[0]) / (4.0 * c), (z[0] + x[2]) / (4.0 * c), (z[1] + y[2]) / (4.0 * c), c)
