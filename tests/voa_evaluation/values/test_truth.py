"""True values: the update of the service, scan by scan, gives what the batches give."""

import numpy as np
import pytest

from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp
from voa_core.scans import NO_RETURN, Scan
from voa_core.simulation import Sampling
from voa_core.updating import update
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.truth import Truth, argmax, crossed, oracle_choices, truth_of


@pytest.mark.parametrize("fixture", ["bench", "margin_bench"])
def test_gains_are_those_of_one_update_after_the_other(fixture: str, request: pytest.FixtureRequest) -> None:
    own: Bench = request.getfixturevalue(fixture)
    scenario, table = own.scenario, own.scenario.table
    belief = Belief.of([0.3, 0.1, 0.2, 0.15, 0.05, 0.2])
    truth = truth_of(own, belief)
    before = best_grasp(table, belief.p).index
    place = 4
    scans = own.world.scans(own.sensors[place], Sampling("any", 6), listed=True)[0]
    for row in range(len(scans.ranges)):
        ranges = np.full(scenario.lidar.grid.beams, NO_RETURN)
        ranges[scans.columns] = scans.ranges[row]
        evidence = scenario.evidence(Scan(ranges, scenario.lidar.grid), own.sensors[place], own.model.std)
        after = best_grasp(table, update(belief, evidence, scenario.policy).belief.p).index
        pose, sample = divmod(row, 6)
        score, without = (0.0 if grasp is None else table.scores[grasp, pose] for grasp in (after, before))
        assert truth.gains[place, pose, sample] == pytest.approx(score - without, abs=1e-12)
    assert truth.without == pytest.approx(best_grasp(table, belief.p).expected_score)


def made(gains: Floats) -> Truth:
    n = gains.shape[1]
    return Truth(np.full(n, 1.0 / n), gains, 0.4)


def test_the_oracle_gains_nothing_from_luck() -> None:
    """Noise alone makes the best of many worthless looks seem to gain; crossed halves gain nothing."""
    rng = np.random.default_rng(4)
    lucky, honest = [], []
    for _ in range(300):
        truth = made(rng.choice([-0.5, 0.5], (12, 2, 8)))
        lucky.append(truth.net.max())
        honest.append(float(crossed(truth, oracle_choices(truth)[0]).mean()))
    assert np.mean(lucky) > 0.15
    assert abs(np.mean(honest)) < 0.03


def test_the_oracle_takes_no_look_that_harms() -> None:
    truth = made(np.full((3, 2, 4), -0.1))
    best, worst = oracle_choices(truth)
    assert best.tolist() == [-1, -1]
    assert worst.tolist() == [0, 0]
    assert not crossed(truth, best).any()
    assert crossed(truth, worst) == pytest.approx(np.full((2, 4), -0.1))


def test_the_covariance_is_that_of_the_means() -> None:
    rng = np.random.default_rng(5)
    common = rng.standard_normal((4000, 1, 2, 10))
    gains = common + 0.1 * rng.standard_normal((4000, 2, 2, 10))
    nets = np.array([made(each).net for each in gains])
    assert np.cov(nets.T) == pytest.approx(np.mean([made(each).covariance() for each in gains[:200]], axis=0), rel=0.1)


def test_of_equal_values_the_first_is_the_largest() -> None:
    assert argmax(np.array([0.1, 0.3, 0.3 + 1e-14])) == 1
