"""Meshes of the table's objects: round bodies with fins and collars, and an angle bar."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh

from tests.acceptance.casting import Floats, turned


def quaternion(yaw: float, *, flipped: bool = False) -> tuple[float, float, float, float]:
    """Quaternion w, x, y, z of a turn by `yaw` about z; `flipped`: upside down before it, by half a turn about x."""
    w, z = math.cos(yaw / 2), math.sin(yaw / 2)
    return (0.0, w, z, 0.0) if flipped else (w, 0.0, 0.0, z)


@dataclass(frozen=True)
class Fin:
    """A radial fin: bearing (radians), length beyond the body, thickness, and its lowest and highest z, metres."""

    bearing: float
    length: float
    thickness: float
    low: float
    high: float


def round_body(
    radius: float, height: float, fins: Sequence[Fin] = (), collars: Sequence[tuple[float, float, float]] = ()
) -> trimesh.Trimesh:
    """Make a cylinder about the z axis from z = 0 up, with fins, and collars of (radius, lowest z, highest z)."""
    parts = [_cylinder(radius, 0.0, height)]
    parts += [_cylinder(*collar) for collar in collars]
    for fin in fins:
        reach = radius / 2 + fin.length
        part = trimesh.creation.box((reach, fin.thickness, fin.high - fin.low))
        part.apply_translation((radius / 2 + reach / 2, 0.0, (fin.low + fin.high) / 2))
        part.apply_transform(_turn(fin.bearing))
        parts.append(part)
    return _joined(parts)


def angle_bar(long: float, short: float, width: float, height: float) -> trimesh.Trimesh:
    """Make an L of two bars about the middle of the long one, which lies along x."""
    along = trimesh.creation.box((long, width, height))
    along.apply_translation((0.0, 0.0, height / 2))
    across = trimesh.creation.box((width, short, height))
    across.apply_translation((long / 2 - width / 2, short / 2 - width / 2, height / 2))
    return _joined([along, across])


def _joined(parts: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh:
    counts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + first for part, first in zip(parts, counts, strict=False)]
    return trimesh.Trimesh(np.concatenate([part.vertices for part in parts]), np.concatenate(faces), process=False)


def _turn(angle: float) -> Floats:
    """Homogeneous matrix (4, 4) of a turn about the z axis."""
    matrix: Floats = np.eye(4)
    matrix[:2, :2] = turned(angle)
    return matrix


def _cylinder(radius: float, low: float, high: float) -> trimesh.Trimesh:
    cylinder: trimesh.Trimesh = trimesh.creation.cylinder(radius, high - low, sections=48)
    cylinder.apply_translation((0.0, 0.0, (low + high) / 2))
    return cylinder
