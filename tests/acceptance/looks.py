"""Looks at one object under one belief: what the ranking promises of each, and its true value."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.acceptance.casting import Floats
from tests.acceptance.customer import Service
from tests.acceptance.figures import Figure
from tests.acceptance.values import Values, promised, true_values
from tests.acceptance.worlds import World
from voa_client import PoseUncertainty


@dataclass(frozen=True, eq=False)
class Looks:
    """Promised and true values of the looks from all places under one belief.

    Attributes:
        promise: (places,) promised values.
        promise_error: (places,) their standard errors.
        values: true values.
        chosen: index of the place that the ranking has first.
    """

    promise: Floats
    promise_error: Floats
    values: Values
    chosen: int


def looks_at(
    service: Service,
    world: World,
    scenario: str,
    belief: Floats,
    scans: int,
    rng: np.random.Generator,
    std: PoseUncertainty,
) -> Looks:
    """Rank all looks, and value each by fresh scans, so many of each pose; see `values.true_values`."""
    ranking = service.rank(scenario, belief, std)
    promise, error = promised(ranking, world.places)
    chosen = [place.name for place in world.places].index(ranking.ranking[0].sensor)
    return Looks(promise, error, true_values(service, world, scenario, belief, scans, rng, std), chosen)


def counts_of(looks: Sequence[Looks]) -> str:
    """Write from how many beliefs, looks and scans a figure is."""
    scans = sum(each.values.gains.size for each in looks)
    return f"{len(looks)} beliefs, {sum(len(each.promise) for each in looks)} looks, {scans} scans"


def covered(row: str, looks: Sequence[Looks]) -> Figure:
    """Share of looks whose true value lies within two standard errors: of the promise, and of the true value itself."""
    off = np.concatenate([each.promise - each.values.true for each in looks])
    own = np.concatenate([each.promise_error for each in looks])
    both = np.hypot(own, np.concatenate([each.values.error for each in looks]))
    share = float(np.mean(np.abs(off) <= 2.0 * both))
    counts = f"{counts_of(looks)}; bias {off.mean():+.3f}; mean standard error {own.mean():.3f}"
    return Figure(row, "true value within two standard errors", share, "at least", 0.9, counts)
