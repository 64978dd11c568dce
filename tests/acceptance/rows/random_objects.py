"""Rows about a look at random objects: promised and true values, share of the lead, standard errors that cover."""

import math

import numpy as np

from tests.acceptance.customer import Service
from tests.acceptance.figures import Figure
from tests.acceptance.looks import Looks, counts_of, covered, looks_at
from tests.acceptance.scenes import finned
from tests.acceptance.sizes import Size
from tests.acceptance.worlds import EXACT
from voa_client import PoseUncertainty

STRAYED = PoseUncertainty(xy_m=0.015, yaw_rad=math.radians(1.0))


def rows(service: Service, seed: int, size: Size) -> list[Figure]:
    """Measure the rows about one look at random objects, for an exact robot and one that errs by 1.5 cm, 1 degree."""
    figures: list[Figure] = []
    every: list[Looks] = []
    for robot, std, limit, share in (("exact", EXACT, 0.035, 0.85), ("1.5 cm, 1 degree", STRAYED, 0.05, 0.75)):
        looks = [each for index in range(size.objects) for each in _looks(service, seed + index, size, std)]
        every += looks
        figures += [_difference(looks, robot, limit), _share(looks, robot, share)]
    return [*figures, covered("random objects, both robots", every)]


def _looks(service: Service, seed: int, size: Size, std: PoseUncertainty) -> list[Looks]:
    """Value every look at one object, under the uniform belief and hints."""
    world = finned(seed)
    scenario = service.scenario_of(world)
    rng = np.random.default_rng([seed, 10, int(std != EXACT)])
    count = len(world.poses)
    beliefs = [np.full(count, 1.0 / count), *rng.dirichlet(np.full(count, 0.5), size.hints)]
    return [looks_at(service, world, scenario, belief, size.scans, rng, std) for belief in beliefs]


def _difference(looks: list[Looks], robot: str, limit: float) -> Figure:
    """Root mean square of promised less true value per look, the error of the true values included."""
    off = np.concatenate([each.promise - each.values.true for each in looks])
    own = np.concatenate([each.values.error for each in looks])
    rms = float(np.sqrt(np.mean(off**2)))
    without = math.sqrt(max(0.0, rms**2 - float(np.mean(own**2))))
    counts = f"{counts_of(looks)}; {without:.3f} without the error of the truth; bias {off.mean():+.3f}"
    return Figure(
        f"random objects, robot {robot}", "rms of promised less achieved per look", rms, "at most", limit, counts
    )


def _share(looks: list[Looks], robot: str, limit: float) -> Figure:
    """Share of the lead of the truly best look over the mean look that the first of the ranking has.

    The best of noisy true values is partly lucky, which makes the lead too large: by more with half the scans than with
    all. The difference is subtracted once more (jackknife). With the best look chosen by half the scans and valued by
    the other half, the lead is too small instead.
    """
    raw = sum(each.values.true.max() - each.values.true.mean() for each in looks)
    won = sum(each.values.true[each.chosen] - each.values.true.mean() for each in looks)
    of_half = 0.0
    lead_of_halves = won_of_halves = 0.0
    for each in looks:
        half = each.values.gains.shape[2] // 2
        for one, other in ((slice(half), slice(half, None)), (slice(half, None), slice(half))):
            best, valued = int(np.argmax(each.values.part(one))), each.values.part(other)
            of_half += (valued.max() - valued.mean()) / 2.0
            lead_of_halves += valued[best] - valued.mean()
            won_of_halves += valued[each.chosen] - valued.mean()
    lead = 2.0 * raw - of_half
    counts = f"{counts_of(looks)}; mean lead {lead / len(looks):.3f}; {won / raw:.2f} with the lead not corrected, "
    counts += f"{won_of_halves / lead_of_halves:.2f} with the best look of half the scans"
    return Figure(f"random objects, robot {robot}", "share of the lead", float(won / lead), "at least", limit, counts)
