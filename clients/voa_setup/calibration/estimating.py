"""Estimate odometry's origin or the lidar's mount from a robot's stops, with uncertainty, alternatives and sign."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_setup.calibration.known_object import InvalidCalibration
from voa_setup.calibration.planar import Floats, wrapped
from voa_setup.calibration.searching import CREDIBLE, Search, Solution
from voa_setup.calibration.stops import Stop
from voa_setup.calibration.unknowns import Unknown


@dataclass(frozen=True, eq=False)
class Estimate:
    """Result of a calibration.

    Attributes:
        best: the solution that fits; of several that fit equally well, the nearest to what the mapping states.
        others: solutions that fit about as well, elsewhere or with the other sign.
        sign_known: True if the scans, and the bound on the distance from the stated pose, exclude the other sign.
        stops: number of stops that were used.
    """

    best: Solution
    others: tuple[Solution, ...]
    sign_known: bool
    stops: int


def estimate(
    stops: Sequence[Stop],
    unknown: Unknown,
    *,
    stated_upside_down: bool,
    range_max: float,
    noise_m: float,
    within_m: float = math.inf,
    seed: int = 0,
) -> Estimate:
    """Estimate the unknown pose by Bayes' rule from the scans of all stops, under a uniform prior.

    Args:
        stops: of the robot, each in front of an object at a known pose.
        unknown: pose to be estimated, and the poses that are taken for known.
        stated_upside_down: mounting of the lidar as the mapping states it; it decides where the scans do not.
        range_max: of the lidar, metres.
        noise_m: standard deviation of one range by the lidar's preset, metres; used where a stop does not show it.
        within_m: largest distance of the result from the stated pose, metres.
        seed: of the samples; the same seed gives the same result.

    Raises:
        InvalidCalibration: no pose of the lidar explains the scans.
    """
    solutions: list[Solution] = []
    for hangs in (False, True):
        search = Search(stops, unknown, hangs, range_max, noise_m, np.random.default_rng(seed))
        solutions += search.solutions()
    near = [each for each in solutions if np.hypot(*(each.pose - unknown.stated)[:2]) <= within_m]
    if not near:
        raise InvalidCalibration(_none(solutions, unknown, within_m))
    top = max(each.fit for each in near)
    credible = [each for each in near if each.fit >= top - CREDIBLE]
    best = min(credible, key=lambda each: (each.upside_down != stated_upside_down, _apart(each, unknown.stated)))
    others: list[Solution] = []
    for each in sorted(credible, key=lambda each: -each.fit):
        if each is not best and not any(_same(each, other) for other in (best, *others)):
            others.append(each)
    return Estimate(best, tuple(others), all(each.upside_down == best.upside_down for each in others), len(stops))


def _none(solutions: Sequence[Solution], unknown: Unknown, within_m: float) -> str:
    if not solutions:
        return (
            "no pose of the lidar explains the scans by the object: is it at the stated pose, does the scan plane meet "
            "it, and does it stand clear of walls?"
        )
    nearest = min(solutions, key=lambda each: _apart(each, unknown.stated))
    x, y, yaw = nearest.pose
    return (
        f"the nearest solution, x = {x:.3f}, y = {y:.3f}, yaw_rad = {yaw:.3f}, is more than {within_m:g} m from the "
        f"stated {unknown.estimated}: correct what the mapping states, or allow more with --within"
    )


def _apart(solution: Solution, pose: Floats) -> float:
    """Distance of a solution from a pose: metres, a radian counting as half a metre."""
    off = solution.pose - pose
    return float(np.hypot(off[0], off[1]) + 0.5 * abs(wrapped(off[2:])[0]))


def _same(one: Solution, other: Solution) -> bool:
    """True if two solutions under one sign lie within three standard deviations of one another."""
    off = one.pose - other.pose
    off[2] = wrapped(off[2:])[0]
    return one.upside_down == other.upside_down and bool((np.abs(off) <= 3.0 * np.maximum(one.std, other.std)).all())
