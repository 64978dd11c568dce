"""Twin poses: the mesh lies in the same place, and every grasp scores the same; one of them is a mistake.

Poses that look alike but grasp differently are none: telling them apart is what a look is for.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from voa_core.checks import Floats
from voa_core.grasps import GraspTable
from voa_core.mistakes.found import Mistake, listed
from voa_core.mistakes.picking import evenly
from voa_core.mistakes.surface import Surface
from voa_core.objects import Object
from voa_core.poses import PoseSet

SAME_PLACE_M = 1e-4
_MOST_GROUPS = 20
_MOST_STEPS = 5_000_000  # of comparisons of placed meshes, where the cost is bounded: some 20 ms


def mistakes_of_twins(poses: PoseSet, table: GraspTable, object_: Object, most: int | None) -> list[Mistake]:
    """Find groups of poses at which the mesh lies in the same place within 0.1 mm and all grasps score the same.

    Args:
        poses: with geometry.
        table: scores of the grasps at the poses.
        object_: the mesh.
        most: poses to look at; None: all, and as many comparisons of placed meshes as it takes.
    """
    if poses.positions is None or poses.rotations is None:
        return []
    index, surface = evenly(len(poses), most), Surface(object_)
    groups = _groups(
        surface,
        poses.rotations[index],
        poses.positions[index],
        np.unique(table.scores[:, index], axis=1, return_inverse=True)[1].reshape(-1),
        None if most is None else max(1, _MOST_STEPS // (2 * surface.cost)),
    )
    found = []
    for group in groups[:_MOST_GROUPS]:
        names = tuple(poses.names[index[member]] for member in group)
        detail = (
            f"at {listed('pose', names)} the object lies in the same place within 0.1 mm, and every grasp scores the "
            "same: keep one of them and give it their prior together, or the belief is divided among them"
        )
        found.append(Mistake("twin-poses", detail, names))
    return found


def _groups(
    surface: Surface, rotations: Floats, positions: Floats, column: NDArray[np.intp], most: int | None
) -> list[list[int]]:
    """Groups of two and more twins, each around its first member, in the order of the first members."""
    features = _features(surface, rotations, positions)
    tree = cKDTree(features)
    open_poses = np.ones(len(positions), dtype=bool)
    compared = 0
    groups = []
    for first in range(len(positions)):
        if not open_poses[first]:
            continue
        group = [first]
        for other in sorted(tree.query_ball_point(features[first], 2.0 * SAME_PLACE_M)):
            if other <= first or not open_poses[other] or column[other] != column[first]:
                continue
            if most is not None and compared >= most:
                break
            compared += 1
            if _same_place(surface, rotations, positions, first, other):
                open_poses[other] = False
                group.append(other)
        if len(group) > 1:
            groups.append(group)
    return groups


def _features(surface: Surface, rotations: Floats, positions: Floats) -> Floats:
    """Nine numbers in metres per pose, (n, 9), that are nearly equal where the mesh lies in the same place.

    The middle of the surface, and its covariance divided by its size.
    """
    middle, covariance = surface.moments
    middles = np.einsum("nij,j->ni", rotations, middle) + positions
    covariances = np.einsum("nij,jk,nlk->nil", rotations, covariance, rotations)
    rows, columns = np.triu_indices(3)
    return np.hstack([middles, covariances[:, rows, columns] / np.sqrt(np.trace(covariance))])


def _same_place(surface: Surface, rotations: Floats, positions: Floats, first: int, other: int) -> bool:
    """Whether samples of the surface at either pose lie on the surface at the other."""
    for here, there in ((first, other), (other, first)):
        world = surface.samples @ rotations[here].T + positions[here]
        if not surface.holds((world - positions[there]) @ rotations[there], SAME_PLACE_M):
            return False
    return True
