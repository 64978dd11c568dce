"""Priors of scenarios as probabilities of their poses, in every form that the service accepts."""

import math

import numpy as np

from voa_fleet.errors import InvalidObject
from voa_fleet.world.frames import Floats, matrix_of
from voa_fleet.world.objects import FleetObject
from voa_msgs.priors import PoseCategory, PoseModelPrior

_SAME_TILT = 1e-3


def prior_of(target: FleetObject) -> list[float]:
    """Return the prior of the object's scenario, (poses,), which sums to 1; uniform where the scenario has none.

    Raises:
        InvalidObject: the prior has another number of poses, or a category of poses does not fit the poses.
    """
    prior = target.scenario.prior
    if prior is None:
        return [1.0 / len(target.poses)] * len(target.poses)
    shares = _of_model(target, prior) if isinstance(prior, PoseModelPrior) else np.array(prior)
    if len(shares) != len(target.poses) or not shares.sum() > 0.0:
        raise InvalidObject(
            f"{target.name}: expected a prior of {len(target.poses)} probabilities, one per pose, got {len(shares)}"
        )
    normalised: list[float] = (shares / shares.sum()).tolist()
    return normalised


def _of_model(target: FleetObject, model: PoseModelPrior) -> Floats:
    """Probabilities (poses,) by P(category) x von Mises(yaw) x Gaussian(x, y), normalised in each category.

    A category holds the poses that differ from its reference by a yaw and a shift in the plane (appendix of the longer
    paper, arXiv 2310.14402).
    """
    rotations = np.array([matrix_of(pose.quaternion_wxyz or (1.0, 0.0, 0.0, 0.0)) for pose in target.scenario.poses])
    places = np.array([(pose.position or (0.0, 0.0, 0.0))[:2] for pose in target.scenario.poses])
    shares, category_of = np.zeros(len(rotations)), np.full(len(rotations), -1)
    for index, category in enumerate(model.categories):
        reference = rotations[target.poses.index(target.pose(category.pose).name)]
        members = np.flatnonzero(np.abs(rotations[:, 2] - reference[2]).max(axis=1) < _SAME_TILT)
        if (category_of[members] >= 0).any():
            raise InvalidObject(f"{target.name}: prior: pose {category.pose!r} rests as another category's does")
        category_of[members] = index
        turned = rotations[members] @ reference.T
        yaws = np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
        logs = _log_density(category, yaws, places[members])
        densities = np.exp(logs - logs.max())
        shares[members] = category.probability * densities / densities.sum()
    outside = np.flatnonzero(category_of < 0)
    if outside.size:
        raise InvalidObject(f"{target.name}: prior: expected a category for pose {target.poses[outside[0]]!r}")
    return shares


def _log_density(category: PoseCategory, yaws: Floats, places: Floats) -> Floats:
    """Logarithms (k,), up to a constant, of the densities of yaws (k,) and places (k, 2)."""
    logs: Floats = category.yaw_concentration * np.cos(yaws - category.yaw_mean_rad)
    if category.mean_xy is not None and category.covariance_xy is not None:
        off = places - np.array(category.mean_xy)
        scaled = np.linalg.solve(np.array(category.covariance_xy), off.T).T
        logs = logs - 0.5 * np.einsum("ki,ki->k", off, scaled)
    if not math.isfinite(float(logs.max())):
        raise InvalidObject(f"prior: the densities of the category of {category.pose!r} are not finite")
    return logs
