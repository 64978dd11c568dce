"""The solids of an object as MuJoCo geometries."""

import math
from typing import Any

import mujoco
import numpy as np

from voa_fleet.world.frames import along, matrix_of, product, yaw_quaternion
from voa_fleet.world.groups import HAND_OBJECT, HARD, OBJECT_TABLE, OBJECT_TOUCHED, STIFF, TABLE_TOUCHED
from voa_fleet.world.objects import Box, Capsule, Cylinder, Solid, Touches, Tube

_BITS: dict[Touches, int] = {"table": OBJECT_TABLE, "gripper": HAND_OBJECT, "both": OBJECT_TABLE | HAND_OBJECT}


def add_solid(body: Any, solid: Solid, friction: float) -> None:
    """Add a solid to the object's body: it collides and has no mass, because the mesh gives the inertia."""
    match solid:
        case Box():
            half = [edge / 2.0 for edge in solid.size]
            _add(body, solid, friction, mujoco.mjtGeom.mjGEOM_BOX, half, pos=list(solid.centre))
        case Cylinder() | Capsule():
            cylinder = isinstance(solid, Cylinder)
            shape = mujoco.mjtGeom.mjGEOM_CYLINDER if cylinder else mujoco.mjtGeom.mjGEOM_CAPSULE
            _add(body, solid, friction, shape, [solid.radius, 0.0, 0.0], fromto=[*solid.start, *solid.end])
        case Tube():
            _add_tube(body, solid, friction)


def _add_tube(body: Any, tube: Tube, friction: float) -> None:
    """Add boxes whose outer faces touch the tube's outside in their middles."""
    start, end = np.array(tube.start), np.array(tube.end)
    frame = along(end - start)
    middle = tube.radius - tube.wall / 2.0
    half = [tube.wall / 2.0, tube.radius * math.tan(math.pi / tube.pieces), float(np.linalg.norm(end - start)) / 2.0]
    for piece in range(tube.pieces):
        turned = product(frame, yaw_quaternion(2.0 * math.pi * piece / tube.pieces))
        centre = (start + end) / 2.0 + matrix_of(turned) @ np.array([middle, 0.0, 0.0])
        shape = mujoco.mjtGeom.mjGEOM_BOX
        _add(body, tube, friction, shape, half, pos=centre.tolist(), quat=turned.tolist())


def _add(body: Any, solid: Solid, friction: float, shape: Any, size: list[float], **place: list[float]) -> None:
    bits = _BITS[solid.touches]
    body.add_geom(
        type=shape,
        size=size,
        mass=0.0,
        contype=bits,
        conaffinity=bits,
        condim=4,
        friction=[friction, 0.005, 0.0001],
        solref=list(STIFF),
        solimp=list(HARD),
        group=TABLE_TOUCHED if solid.touches == "table" else OBJECT_TOUCHED,
        **place,
    )
