"""True values of looks: success of the grasp that the service chooses after fresh noisy scans, by brute force."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from tests.acceptance.casting import Floats
from tests.acceptance.customer import Service, grasp_index
from tests.acceptance.worlds import EXACT, Place, World, displacements, errors
from voa_client import PoseUncertainty, Ranking


@dataclass(frozen=True, eq=False)
class Values:
    """True gains of looks from some places, under one belief.

    Attributes:
        gains: (places, n, M) success after each of M scans of each pose, less that without the look.
        belief: (n,).
        entropies: (places, n, M) entropy of the belief after each scan, nats.
    """

    gains: Floats
    belief: Floats
    entropies: Floats

    @property
    def true(self) -> Floats:
        """True value of each look, (places,), in success probability."""
        value: Floats = self.gains.mean(axis=2) @ self.belief
        return value

    @property
    def error(self) -> Floats:
        """Standard error of each true value from the number of scans, (places,)."""
        scans = self.gains.shape[2]
        error: Floats = np.sqrt((self.gains.var(axis=2, ddof=1) @ self.belief**2) / scans)
        return error

    def part(self, which: slice) -> Floats:
        """True value of each look, (places,), over some of the scans only."""
        value: Floats = self.gains[:, :, which].mean(axis=2) @ self.belief
        return value


def success(world: World, grasp: int, pose: int) -> float:
    """Success probability of a grasp (-1: none) at a pose."""
    return 0.0 if grasp < 0 else float(world.scores[grasp, pose])


def true_values(
    service: Service,
    world: World,
    scenario: str,
    belief: Floats,
    scans: int,
    rng: np.random.Generator,
    std: PoseUncertainty = EXACT,
    places: list[Place] | None = None,
) -> Values:
    """Value looks by fresh scans: each has another displacement, alike at all places, and another error of the robot.

    Args:
        service: updates the belief by each scan, and names the best grasp.
        world: takes the scans.
        scenario: id of the world's scenario.
        belief: before the look, (n,).
        scans: number M of scans of each pose and place.
        rng: makes displacements and noise.
        std: standard deviations of the robot's pose, stated.
        places: that are looked from; None: all of the world's.
    """
    chosen = places or world.places
    gains = np.zeros((len(chosen), len(world.poses), scans))
    entropies = np.zeros_like(gains)
    first = int(np.argmax(world.scores @ belief)) if (world.scores @ belief).max() > 0.0 else -1
    for pose in np.flatnonzero(belief > 0.0):
        moved = displacements(scans, rng)
        for index, place in enumerate(chosen):
            taken = world.scans(int(pose), place, moved, errors(scans, std, rng), rng)
            after = service.each(partial(service.update, scenario, place, belief=belief, std=std), taken)
            gains[index, pose] = [success(world, grasp_index(each.best_grasp), int(pose)) for each in after]
            gains[index, pose] -= success(world, first, int(pose))
            entropies[index, pose] = [each.entropy_nats for each in after]
    return Values(gains, belief, entropies)


def promised(ranking: Ranking, places: list[Place]) -> tuple[Floats, Floats]:
    """Promised value of each place, and its standard error (0 over exact scans), in the order of the places."""
    by_name = {look.sensor: look for look in ranking.ranking}
    looks = [by_name[place.name] for place in places]
    return np.array([look.voa for look in looks]), np.array([look.standard_error or 0.0 for look in looks])
