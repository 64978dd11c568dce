"""Beliefs and priors: from messages to the mathematics."""

import math
from collections.abc import Sequence
from hashlib import sha256

import numpy as np

from voa_core.errors import UnknownName
from voa_core.estimates import Estimate
from voa_core.filtering import Belief
from voa_core.poses import PoseSet
from voa_core.priors import Category, pose_model
from voa_core.scenario import Scenario
from voa_msgs import priors
from voa_msgs.sessions import UpdateRequest

BeliefInput = Belief | Sequence[float] | None
"""A belief from the store, or from a request (one probability for each pose), or None: the scenario's prior."""


def belief_of(given: BeliefInput, scenario: Scenario, field: str = "belief") -> Belief:
    """Return the belief that a session has or a request states.

    Args:
        given: from the store or from a request; None: the scenario's prior.
        scenario: over whose poses the belief is.
        field: name of the request's field, for errors.

    Raises:
        InvalidInput: the request's numbers are not a belief over the scenario's poses.
    """
    if given is None:
        return scenario.prior
    return given if isinstance(given, Belief) else Belief.of(given, field, len(scenario.poses))


def estimate_of(request: UpdateRequest, scenario: Scenario) -> Estimate:
    """Return the estimate that a request states, with the defaults of its scenario; it knows no places.

    Raises:
        InvalidInput: the request's numbers are not a belief over the scenario's poses.
    """
    belief, absent = belief_of(request.belief, scenario), request.absent
    if absent is None:
        absent = scenario.absent
    if absent in {0.0, 1.0}:  # as rounded in an earlier response: no scan can change it
        return Estimate(belief, log_odds_absent=-math.inf if absent == 0.0 else math.inf)
    return Estimate.of(belief, absent)


def prior_of(prior: list[float] | priors.PoseModelPrior | None, poses: PoseSet) -> Belief:
    """Build a prior over the poses from its message; None: uniform.

    Raises:
        VoaError: it is not a belief over the poses, or it names a pose that does not exist.
    """
    if prior is None:
        return Belief.uniform(len(poses))
    if isinstance(prior, list):
        return Belief.of(prior, "prior", len(poses))
    return pose_model(poses, [_category(category, poses) for category in prior.categories])


def belief_digest(belief: BeliefInput) -> bytes | None:
    """Return a digest that is equal for equal beliefs; one from the store never equals one from a request."""
    if belief is None:
        return None
    if isinstance(belief, Belief):
        return sha256(b"session" + belief.p.tobytes() + belief.log_p.tobytes()).digest()
    return sha256(b"given" + np.asarray(belief, dtype=np.float64).tobytes()).digest()


def _category(category: priors.PoseCategory, poses: PoseSet) -> Category:
    if category.pose not in poses.names:
        raise UnknownName("pose", category.pose, poses.names)
    mean = None if category.mean_xy is None else (category.mean_xy[0], category.mean_xy[1])
    covariance = None
    if category.covariance_xy is not None:
        (xx, xy), (yx, yy) = category.covariance_xy
        covariance = ((xx, xy), (yx, yy))
    return Category(
        poses.names.index(category.pose),
        category.probability,
        category.yaw_mean_rad,
        category.yaw_concentration,
        mean,
        covariance,
    )
