"""Twin poses: poses at which the mesh lies in the same place and every grasp has the same score, by mistake.

Poses that look alike but have different grasp scores are no twins: to distinguish them is the purpose of a look.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.grasps import GraspTable
from voa_core.mistakes.effort import Effort
from voa_core.mistakes.mistake import Mistake, listed
from voa_core.mistakes.picking import evenly
from voa_core.mistakes.surface import Surface
from voa_core.objects import Object
from voa_core.poses import PoseSet

SAME_PLACE_M = 1e-4
_MOST_GROUPS = 20
_STEPS_OF_A_NEIGHBOUR = 50  # cost of one candidate, in boxes


def mistakes_of_twins(poses: PoseSet, table: GraspTable, object_: Object, effort: Effort) -> list[Mistake]:
    """Find groups of poses at which the mesh lies in the same place within 0.1 mm and all grasp scores are equal.

    Args:
        poses: with geometry.
        table: scores of the grasps at the poses.
        object_: the mesh.
        effort: `pairs` limits the poses, `boxes` the comparisons of placed meshes.

    Returns:
        One mistake for each of the first 20 groups.
    """
    if poses.positions is None or poses.rotations is None:
        return []
    index = evenly(len(poses), effort.pairs)
    placed = Placed(Surface(object_), poses.rotations[index], poses.positions[index])
    columns = np.unique(table.scores[:, index], axis=1, return_inverse=True)[1].reshape(-1)
    mistakes = []
    for group in _groups(placed, columns, effort.boxes):
        names = tuple(poses.names[index[member]] for member in group)
        detail = (
            f"at {listed('pose', names)} the object lies in the same place within 0.1 mm, and every grasp scores the "
            "same: keep one of them and give it their prior together, or the belief is divided among them"
        )
        mistakes.append(Mistake("twin-poses", detail, names))
    return mistakes


def _groups(placed: "Placed", columns: NDArray[np.intp], steps: int) -> list[list[int]]:
    """Find groups of at least two twins, each around its first member, within a number of `steps`.

    Only poses with the same column of scores and nearly the same moments are compared.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415 - slow to import, and needed for this alone

    features = placed.features()
    groups: list[list[int]] = []
    for members in np.split(np.argsort(columns, kind="stable"), np.cumsum(np.bincount(columns))[:-1]):
        if len(members) == 1:
            continue
        tree = cKDTree(features[members])
        alone = np.ones(len(members), dtype=bool)
        for first in range(len(members)):
            if steps <= 0 or len(groups) == _MOST_GROUPS:
                return groups
            if not alone[first]:
                continue
            near = np.array(tree.query_ball_point(features[members[first]], 2.0 * SAME_PLACE_M))
            steps -= _STEPS_OF_A_NEIGHBOUR * len(near)
            group = [first]
            for other in np.sort(near[(near > first) & alone[near]])[: max(0, steps) // (2 * placed.surface.cost) + 1]:
                steps -= 2 * placed.surface.cost
                if placed.alike(members[first], members[other]):
                    alone[other] = False
                    group.append(int(other))
            if len(group) > 1:
                groups.append([int(member) for member in members[group]])
    return groups


@dataclass(frozen=True, eq=False)
class Placed:
    """A mesh at n poses.

    Attributes:
        surface: of the mesh.
        rotations: (n, 3, 3).
        positions: (n, 3) metres.
    """

    surface: Surface
    rotations: Floats
    positions: Floats

    def features(self) -> Floats:
        """Features of each pose, (n, 9) metres, which are nearly equal where the mesh lies in the same place.

        They are the middle of the surface, and its covariance divided by its size.
        """
        middle, covariance = self.surface.moments
        middles = np.einsum("nij,j->ni", self.rotations, middle) + self.positions
        covariances = np.einsum("nij,jk,nlk->nil", self.rotations, covariance, self.rotations)
        rows, columns = np.triu_indices(3)
        return np.hstack([middles, covariances[:, rows, columns] / np.sqrt(np.trace(covariance))])

    def alike(self, first: int, other: int) -> bool:
        """True if samples of the surface at each of two poses lie within 0.1 mm of the surface at the other."""
        for here, there in ((first, other), (other, first)):
            world = self.surface.samples @ self.rotations[here].T + self.positions[here]
            local = (world - self.positions[there]) @ self.rotations[there]
            if not self.surface.holds(local, SAME_PLACE_M):
                return False
        return True
