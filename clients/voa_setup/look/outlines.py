"""Outlines of the object in the scan plane, at each pose: the part of the mesh that a planar lidar can see."""

from collections.abc import Sequence

import numpy as np

from voa_core.cutting import cut_poses
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_fleet.world.frames import Floats, matrix_of
from voa_fleet.world.meshes import Mesh
from voa_msgs.scenarios import Pose


def placed(mesh: Mesh, pose: Pose) -> Mesh:
    """Move a mesh from the object's frame into the world, to a pose."""
    turned = mesh.vertices @ matrix_of(pose.quaternion_wxyz or (1.0, 0.0, 0.0, 0.0)).T
    return Mesh(turned + np.asarray(pose.position or (0.0, 0.0, 0.0)), mesh.faces)


def outlines(mesh: Mesh, poses: Sequence[Pose], height_m: float) -> list[Floats]:
    """Cut the object by the plane z = `height_m` at each pose, as the service does for its predictions.

    Contours inside another one are left out, because no beam from outside reaches them.

    Returns:
        For each pose the segments of its outline in the world frame, (s, 2, 2): two ends with x and y, metres; none
        (s = 0) where the plane misses the object.
    """
    contours = cut_poses(
        Object.from_arrays(mesh.vertices, mesh.faces),
        PoseSet.from_arrays(
            [pose.name for pose in poses],
            [pose.position or (0.0, 0.0, 0.0) for pose in poses],
            [pose.quaternion_wxyz or (1.0, 0.0, 0.0, 0.0) for pose in poses],
        ),
        height_m,
    )
    reduced = contours.outlines
    segments = []
    for cut, (cosine, sine, x, y) in zip(contours.cut_of_pose, contours.placement, strict=True):
        points = reduced.points[reduced.point_start[cut] : reduced.point_start[cut + 1]]
        edges = reduced.edges[reduced.edge_start[cut] : reduced.edge_start[cut + 1]]
        world = points @ np.array([[cosine, sine], [-sine, cosine]]) + np.array([x, y])
        segments.append(world[edges])
    return segments
