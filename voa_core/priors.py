"""Priors over the coordinates of the poses (appendix of the longer paper).

`filtering.Belief` has uniform priors (`Belief.uniform`) and given ones (`Belief.of`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats, finite_array, number
from voa_core.errors import InvalidInput, NoMesh
from voa_core.filtering import SUM_TOLERANCE, Belief, condition
from voa_core.poses import PoseSet

_SAME_TILT = 1e-3


@dataclass(frozen=True)
class Category:
    """A way in which the object rests, with the distribution of its yaw and position.

    A pose belongs to the category if a turn about the vertical and a shift in the plane lead from the reference to it.

    Attributes:
        reference: index of a pose of this category, from which yaws are counted.
        probability: P(category).
        yaw_mean_rad, yaw_concentration: parameters of the von Mises distribution; a concentration of 0 is uniform.
        mean_xy: (2,) metres; None: every position is equally probable.
        covariance_xy: (2, 2) m^2, symmetric positive definite; given with `mean_xy`.
    """

    reference: int
    probability: float
    yaw_mean_rad: float = 0.0
    yaw_concentration: float = 0.0
    mean_xy: tuple[float, float] | None = None
    covariance_xy: tuple[tuple[float, float], tuple[float, float]] | None = None

    def __post_init__(self) -> None:
        number("probability", self.probability, at_least=0.0)
        number("yaw_mean_rad", self.yaw_mean_rad)
        number("yaw_concentration", self.yaw_concentration, at_least=0.0)
        if (self.mean_xy is None) != (self.covariance_xy is None):
            raise InvalidInput("mean_xy, covariance_xy", "both or neither", "one of them")

    def log_density(self, yaws: Floats, places: Floats) -> Floats:
        """Log of the von Mises and Gaussian densities up to a constant, for yaws (k,) and places (k, 2)."""
        density: Floats = self.yaw_concentration * np.cos(yaws - self.yaw_mean_rad)
        if self.mean_xy is None or self.covariance_xy is None:
            return density
        covariance = finite_array("covariance_xy", self.covariance_xy, (2, 2))
        if not np.allclose(covariance, covariance.T) or np.linalg.eigvalsh(covariance).min() <= 0.0:
            raise InvalidInput("covariance_xy", "a symmetric positive definite matrix", str(self.covariance_xy))
        off = places - finite_array("mean_xy", self.mean_xy, (2,))
        density -= 0.5 * np.einsum("ki,ki->k", off, np.linalg.solve(covariance, off.T).T)
        return density


def pose_model(poses: PoseSet, categories: Sequence[Category]) -> Belief:
    """Prior P(category) * vonMises(yaw) * Normal(x, y), the densities normalised over the poses of each category.

    A category keeps its probability, however many poses belong to it.

    Raises:
        NoMesh: the poses have no geometry.
        InvalidInput: the probabilities do not sum to 1, a pose belongs to no category or to two, or a covariance is
            not positive definite.
    """
    if poses.rotations is None or poses.positions is None:
        raise NoMesh("a pose_model prior needs position and quaternion_wxyz of every pose")
    total = sum(category.probability for category in categories)
    if abs(total - 1.0) > SUM_TOLERANCE:
        raise InvalidInput("categories", "probabilities within 1e-6 of a sum of 1", f"a sum of {total:.9g}")
    prior = np.zeros(len(poses))
    taken = np.full(len(poses), -1)
    for index, category in enumerate(categories):
        if not 0 <= category.reference < len(poses):
            raise InvalidInput("reference", f"the index of a pose, 0 to {len(poses) - 1}", str(category.reference))
        reference = poses.rotations[category.reference]
        members = np.flatnonzero(np.abs(poses.rotations[:, 2, :] - reference[2]).max(axis=1) < _SAME_TILT)
        twice = members[taken[members] >= 0]
        if twice.size:
            first = poses.names[categories[taken[twice[0]]].reference]
            raise InvalidInput(
                "categories",
                "poses that rest differently",
                f"{poses.names[twice[0]]!r} in those of {first!r} and of {poses.names[category.reference]!r}",
            )
        taken[members] = index
        turned = poses.rotations[members] @ reference.T
        yaws = np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
        within = condition(Belief.uniform(len(members)), category.log_density(yaws, poses.positions[members, :2]))
        prior[members] = category.probability * within.belief.p if within else 0.0
    left = np.flatnonzero(taken < 0)
    if left.size:
        raise InvalidInput("categories", "a category for every pose", f"none for {poses.names[left[0]]!r}")
    return Belief.of(prior, "prior")
