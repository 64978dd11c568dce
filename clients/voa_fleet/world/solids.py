"""The solids of an object as MuJoCo geometries."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from voa_fleet.world.frames import along, matrix_of, product, yaw_quaternion
from voa_fleet.world.groups import HAND_OBJECT, HARD, OBJECT_TABLE, OBJECT_TOUCHED, STIFF, TABLE_TOUCHED
from voa_fleet.world.meshes import Mesh
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.shapes import Box, Capsule, Cylinder, Hulls, MeshHull, Solid, Touches, Tube

_BITS: dict[Touches, int] = {"table": OBJECT_TABLE, "gripper": HAND_OBJECT, "both": OBJECT_TABLE | HAND_OBJECT}


_JOINT_HULL = "hull of all pieces"


def add_piece_meshes(spec: mujoco.MjSpec, hulls: Mapping[str, Sequence[Mesh]]) -> None:
    """Add the convex pieces of an object to a model, under the names that `piece_name` gives."""
    for file, pieces in hulls.items():
        for index, piece in enumerate(pieces):
            vertices = piece.vertices.astype(np.float32).ravel()
            spec.add_mesh(name=piece_name(file, index), uservert=vertices, userface=piece.faces.ravel())


def add_joint_hull(spec: mujoco.MjSpec, hulls: Mapping[str, Sequence[Mesh]]) -> str:
    """Add a mesh to a model whose convex hull is that of all convex pieces together; returns its name."""
    corners = np.concatenate([piece.vertices for pieces in hulls.values() for piece in pieces])
    hull = ConvexHull(corners)
    spec.add_mesh(name=_JOINT_HULL, uservert=corners.astype(np.float32).ravel(), userface=hull.simplices.ravel())
    return _JOINT_HULL


def piece_name(file: str, index: int) -> str:
    """Return the name of a convex piece in a model."""
    return f"{file} {index}"


def add_solid(body: Any, solid: Solid, target: FleetObject, mesh: str, density_kg_m3: float = 0.0) -> None:
    """Add a solid to the object's body.

    Args:
        body: of the object.
        solid: one of the object's `physics.solids`.
        target: the object.
        mesh: name of the mesh in the model whose convex hull a `MeshHull` is.
        density_kg_m3: 0 where the mesh gives the object its mass and inertia.
    """
    common = _common(solid, target.physics.friction, density_kg_m3)
    geometry = mujoco.mjtGeom
    match solid:
        case Box():
            half = [edge / 2.0 for edge in solid.size]
            body.add_geom(type=geometry.mjGEOM_BOX, size=half, pos=list(solid.centre), **common)
        case Cylinder() | Capsule():
            shape = geometry.mjGEOM_CYLINDER if isinstance(solid, Cylinder) else geometry.mjGEOM_CAPSULE
            ends = [*solid.start, *solid.end]
            body.add_geom(type=shape, size=[solid.radius, 0.0, 0.0], fromto=ends, **common)
        case Tube():
            _add_tube(body, solid, common)
        case MeshHull():  # MuJoCo collides the convex hull of any mesh
            body.add_geom(type=geometry.mjGEOM_MESH, meshname=mesh, **common)
        case Hulls():
            for index in range(len(target.hulls[solid.file])):
                body.add_geom(type=geometry.mjGEOM_MESH, meshname=piece_name(solid.file, index), **common)


def _add_tube(body: Any, tube: Tube, common: dict[str, Any]) -> None:
    """Add boxes whose outer faces touch the tube's outside in their middles."""
    start, end = np.array(tube.start), np.array(tube.end)
    frame = along(end - start)
    middle = tube.radius - tube.wall / 2.0
    half = [tube.wall / 2.0, tube.radius * math.tan(math.pi / tube.pieces), float(np.linalg.norm(end - start)) / 2.0]
    for piece in range(tube.pieces):
        turned = product(frame, yaw_quaternion(2.0 * math.pi * piece / tube.pieces))
        centre = (start + end) / 2.0 + matrix_of(turned) @ np.array([middle, 0.0, 0.0])
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=centre.tolist(), quat=turned.tolist(), **common)


def _common(solid: Solid, friction: float, density_kg_m3: float) -> dict[str, Any]:
    """Settings that all geometries of a solid share."""
    bits = _BITS[solid.touches]
    return {
        **({"density": density_kg_m3} if density_kg_m3 > 0.0 else {"mass": 0.0}),
        "contype": bits,
        "conaffinity": bits,
        "condim": 4,
        "friction": [friction, 0.005, 0.0001],
        "solref": list(STIFF),
        "solimp": list(HARD),
        "group": TABLE_TOUCHED if solid.touches == "table" else OBJECT_TOUCHED,
    }
