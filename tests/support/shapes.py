"""Meshes of everyday objects, made from primitives: what a newcomer might bring.

All stand upright on z = 0 with their axis at x = y = 0, in metres, and are watertight.
"""

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from trimesh import Trimesh

from voa_fleet.world.meshes import Mesh


def spray_bottle() -> Mesh:
    """A bottle 80 mm wide and 50 mm deep, with a neck, a head that points to +x, and a trigger."""
    body = _box([0.08, 0.05, 0.13], [0.0, 0.0, 0.065])
    shoulder = _cylinder(0.02, [0.0, 0.0, 0.125], [0.0, 0.0, 0.15])
    neck = _cylinder(0.014, [0.0, 0.0, 0.145], [0.0, 0.0, 0.185])
    head = _box([0.085, 0.028, 0.03], [0.0175, 0.0, 0.20])
    trigger = _cylinder(0.005, [0.048, 0.0, 0.19], [0.038, 0.0, 0.145])
    return _union(body, shoulder, neck, head, trigger)


def screwdriver() -> Mesh:
    """A screwdriver that lies along x: a handle of 32 mm, a blade of 7 mm, 210 mm in all."""
    handle = _cylinder(0.016, [-0.105, 0.0, 0.016], [-0.005, 0.0, 0.016])
    blade = _cylinder(0.0035, [-0.01, 0.0, 0.016], [0.105, 0.0, 0.016])
    return _union(handle, blade)


def box() -> Mesh:
    """A box of 120, 70 and 45 mm."""
    return _mesh(_box([0.12, 0.07, 0.045], [0.0, 0.0, 0.0225]))


def drill() -> Mesh:
    """A cordless drill: a motor of 56 mm along x over a slanted handle and a foot, with a chuck and a bit."""
    foot = _box([0.10, 0.07, 0.05], [0.0, 0.0, 0.025])
    grip = _box([0.045, 0.036, 0.10], [-0.005, 0.0, 0.095])
    motor = _cylinder(0.028, [-0.07, 0.0, 0.16], [0.07, 0.0, 0.16])
    chuck = _cylinder(0.018, [0.065, 0.0, 0.16], [0.105, 0.0, 0.16])
    bit = _cylinder(0.004, [0.10, 0.0, 0.16], [0.155, 0.0, 0.16])
    return _union(foot, grip, motor, chuck, bit)


def bowl() -> Mesh:
    """A bowl of 150 mm, 55 mm high, with a wall of 4 mm."""
    outside = [[0.0, 0.0], [0.035, 0.0], [0.055, 0.012], [0.07, 0.033], [0.075, 0.055]]
    inside = [[0.071, 0.055], [0.066, 0.034], [0.052, 0.015], [0.034, 0.004], [0.0, 0.004]]
    return _mesh(trimesh.creation.revolve([*outside, *inside], sections=48))


def mug() -> Mesh:
    """A mug of 80 mm with a wall of 4 mm, and a handle of bars that points to +x."""
    profile = [[0.0, 0.0], [0.04, 0.0], [0.04, 0.095], [0.036, 0.095], [0.036, 0.005], [0.0, 0.005]]
    body = trimesh.creation.revolve(profile, sections=48)
    upright = _cylinder(0.0045, [0.066, 0.0, 0.0185], [0.066, 0.0, 0.0765])
    bars = [_cylinder(0.0045, [0.038, 0.0, height], [0.066, 0.0, height]) for height in (0.023, 0.072)]
    return _union(body, upright, *bars)


EVERYDAY = {
    "spray bottle": spray_bottle,
    "screwdriver": screwdriver,
    "box": box,
    "drill": drill,
    "bowl": bowl,
    "mug": mug,
}
"""The shapes by name."""


def _box(size: ArrayLike, centre: ArrayLike) -> Trimesh:
    solid: Trimesh = trimesh.creation.box(extents=np.asarray(size))
    solid.apply_translation(np.asarray(centre))
    return solid


def _cylinder(radius: float, start: ArrayLike, end: ArrayLike) -> Trimesh:
    solid: Trimesh = trimesh.creation.cylinder(radius=radius, segment=np.array([start, end]), sections=24)
    return solid


def _union(*solids: Trimesh) -> Mesh:
    return _mesh(trimesh.boolean.union(solids, engine="manifold"))


def _mesh(solid: Trimesh) -> Mesh:
    assert solid.is_watertight
    return Mesh(np.asarray(solid.vertices, dtype=np.float64), np.asarray(solid.faces, dtype=np.int32))
