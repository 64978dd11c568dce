import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.voa_core.worlds import lidar_of
from voa_core.assistance import Definition, Valuation
from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.kernels import Array
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Driving, Looks, exact_looks
from voa_core.pose_samples import PoseSample, order_by_best_score
from voa_core.prediction import Prediction
from voa_core.ranking import Ranking, rank_looks
from voa_core.rules.protocol import UpdateRule
from voa_core.rules.registry import RULES, rule_of
from voa_core.sampled_ranking import rank_over_samples, values_over
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher

N, M, BEAMS = 240, 5, 6
LIDAR = lidar_of(BEAMS, range_max=2.0)
PLACES = tuple(SensorConfiguration(f"Q{i}", math.cos(i), math.sin(i), 0.0, cost=0.001 * (i % 4)) for i in range(40))


@dataclass(frozen=True)
class Bell:
    """A rule in numpy, so that many pairs of scans are compared quickly where kernels are not compiled."""

    sigma_m: float
    no_return_m: float = 2.0

    def statistic(self, observed: Array, predicted: Array) -> Array:
        statistic: Array = ((observed[:, None] - predicted[None]) ** 2).sum(axis=-1)
        return statistic

    def statistic_among(self, ranges: Array) -> Array:
        return self.statistic(ranges, ranges)

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        log_weights: Array = -0.5 * statistic / np.square(statistic.dtype.type(self.sigma_m))
        return log_weights


WIDE, NARROW = Bell(0.1), Bell(0.005)


def ranges_at(sensor: SensorConfiguration, n: int = N) -> Floats:
    """Scans (n, BEAMS) that differ the more, the further down the list the place is; at two places they do not."""
    index = [place.name for place in PLACES].index(sensor.name)
    random = np.random.default_rng(index)
    along = np.linspace(0.0, 2.0 * np.pi, n)[:, None]
    phases = random.uniform(0.0, 2.0 * np.pi, BEAMS)
    return 1.0 + 0.02 * max(index - 1, 0) * np.sin(along * random.integers(1, 4, BEAMS) + phases)


def looks_of(rule: UpdateRule = WIDE, dtype: type[np.floating] = np.float64, n: int = N) -> Looks:
    def weigher(sensor: SensorConfiguration) -> Weigher:
        return Weigher.of(rule, Prediction.of_dense(LIDAR.grid, ranges_at(sensor, n)), dtype, keep=False)

    return Looks(exact_looks(weigher))


def random_belief(seed: int, n: int = N) -> Belief:
    shares = np.random.default_rng(seed).gamma(0.5, size=n)
    shares[::9] = 0.0
    return Belief.of(shares / shares.sum())


def table(attempts: int | None = None, n: int = N) -> GraspTable:
    along, kinds = np.linspace(0.0, 2.0 * np.pi, n), np.arange(M)[:, None]
    scores = (0.5 + 0.5 * np.sin((1 + kinds % 3) * along + kinds)) ** 3
    names = [f"G{x}" for x in range(M)]
    if attempts is None:
        return GraspTable.of_probabilities(names, scores, n)
    return GraspTable.of_successes(names, np.round(attempts * scores), attempts, n)


def valuation(definition: Definition = "posterior") -> Valuation:
    return Valuation(random_belief(1), table(), UpdatePolicy(), definition)


def values(ranking: Ranking) -> list[float]:
    by_name = {look.sensor.name: look.assistance.voa for look in ranking.looks}
    return [by_name[place.name] for place in PLACES if place.name in by_name]


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-9), (np.float32, 1e-5)])
@pytest.mark.parametrize("definition", ["posterior", "executed"])
@pytest.mark.parametrize("rule", sorted(RULES))
def test_over_all_poses_the_ranking_is_the_exact_one(
    rule: str, definition: Definition, dtype: type[np.floating], tolerance: float
) -> None:
    n, places = 40, PLACES[::9]
    held = Valuation(random_belief(1, n), table(n=n), UpdatePolicy(), definition, random_belief(2, n))
    exact = rank_looks(places, looks_of(rule_of(rule, LIDAR), n=n), held)
    sampled = rank_over_samples(places, looks_of(rule_of(rule, LIDAR), dtype, n), held, seed="", sizes=[n])
    assert values(sampled) == pytest.approx(values(exact), abs=tolerance)
    assert sampled.before == exact.before
    assert sampled.value_of_perfect_information == pytest.approx(exact.value_of_perfect_information, abs=1e-12)
    for look in sampled.looks:
        own = look.assistance
        assert own.standard_error == 0.0
        before = own.expected_score_after - own.voa
        whole = next(each.assistance for each in exact.looks if each.sensor is look.sensor)
        assert before == pytest.approx(whole.expected_score_after - whole.voa, abs=1e-12)


def test_the_last_sample_is_the_first_with_all_possible_poses() -> None:
    sampled = rank_over_samples(PLACES, looks_of(), valuation(), seed="", sizes=[16, N, 4 * N, 16 * N])
    assert sampled.looks[0].assistance.standard_error == 0.0
    assert len(sampled.looks[0].assistance.gains) == np.count_nonzero(random_belief(1).p)
    assert len(sampled.looks[-1].assistance.gains) == 16


@pytest.mark.statistics
@pytest.mark.parametrize("definition", ["posterior", "executed"])
@pytest.mark.parametrize("rule", [WIDE, NARROW])
def test_the_standard_errors_of_values_cover_the_exact_ones(rule: Bell, definition: Definition) -> None:
    """About 95 % of the values over 200 samples at 5 places lie within two standard errors."""
    held, looks, places = valuation(definition), looks_of(rule), PLACES[7::7]
    exact = values_over(places, looks, held, sample_of(held, N, ""))
    off = []
    for seed in range(200):
        some = values_over(places, looks, held, sample_of(held, 48, str(seed)))
        off += [
            (one.assistance.voa - whole.assistance.voa) / (one.assistance.standard_error or 1e-12)
            for one, whole in zip(some, exact, strict=True)
        ]
    assert 0.9 <= np.mean(np.abs(off) <= 2.0) <= 0.99
    assert 0.8 <= np.sqrt(np.mean(np.square(off))) <= 1.25
    assert abs(np.mean(off)) <= 0.25


def sample_of(held: Valuation, size: int, seed: str) -> PoseSample:
    return PoseSample.of(held.outer, order_by_best_score(held.table, held.outer), size, seed)


@pytest.mark.parametrize("seed", ["a", *(pytest.param(seed, marks=pytest.mark.statistics) for seed in "bc")])
def test_fewer_places_are_valued_over_larger_samples_and_the_best_is_among_the_first(seed: str) -> None:
    rounds: list[int] = []
    looks, held = looks_of(), valuation()
    sampled = rank_over_samples(
        PLACES, looks, held, seed=seed, sizes=[24, 48, 96], progress=lambda done, of: rounds.append(of)
    )
    exact = rank_looks(PLACES, looks, held)
    assert rounds.count(len(PLACES)) == len(PLACES)
    assert all(of <= len(PLACES) // 4 for of in rounds[len(PLACES) :])
    assert sum(len(look.assistance.gains) > 24 for look in sampled.looks) > 1, "some do not differ surely from the best"
    first = sampled.looks[0]
    net_value = next(look.net_value for look in exact.looks if look.sensor is first.sensor)
    assert exact.looks[0].net_value - net_value <= 0.01
    best = next(look for look in sampled.looks if look.sensor is exact.looks[0].sensor)
    assert sampled.ties_with_first(best)
    assert not all(sampled.ties_with_first(look) for look in sampled.looks)
    for look in sampled.looks:
        whole = next(each for each in exact.looks if each.sensor is look.sensor)
        assert look.cost == look.sensor.cost
        assert look.net_value == pytest.approx(look.assistance.voa - look.cost, abs=1e-12)
        error = look.assistance.standard_error
        assert error is not None
        assert abs(look.net_value - whole.net_value) <= 5.0 * error + 1e-9


def test_places_come_by_net_value_and_those_left_behind_do_not_pass_the_best() -> None:
    for seed in range(20):
        sampled = rank_over_samples(PLACES, looks_of(), valuation(), seed=str(seed), sizes=[8, 32])
        net_values = [look.net_value for look in sampled.looks]
        assert net_values == sorted(net_values, reverse=True)
        assert len(sampled.looks[0].assistance.gains) == 32
        assert sampled.ties_with_first(sampled.looks[0])


def test_a_place_that_is_left_behind_keeps_its_distance_to_the_best_of_its_round() -> None:
    held, looks, changes = valuation(), looks_of(), 0
    for seed in map(str, range(12)):
        sampled = rank_over_samples(PLACES, looks, held, seed=seed, sizes=[8, 32])
        final = {look.sensor.name: look for look in sampled.looks}
        first_round = values_over(PLACES, looks, held, sample_of(held, 8, seed))
        best = max(first_round, key=lambda look: look.net_value)
        changes += sampled.looks[0].sensor is not best.sensor
        for look in first_round:
            own = final[look.sensor.name]
            if len(own.assistance.gains) == 8:
                behind = best.net_value - look.net_value
                assert final[best.sensor.name].net_value - own.net_value == pytest.approx(behind, abs=1e-12)
    assert changes > 0, "the best of the first round is not always the best"


def test_progress_counts_the_values_of_each_round() -> None:
    calls: list[tuple[int, int]] = []
    rank_over_samples(
        PLACES[:10],
        looks_of(),
        valuation(),
        seed="",
        sizes=[8, 32],
        progress=lambda done, of: calls.append((done, of)),
    )
    assert calls[:10] == [(done, 10) for done in range(1, 11)]
    others = calls[10:]
    assert others == [(done, len(others)) for done in range(1, len(others) + 1)]


def test_threads_and_chunks_give_the_same_values() -> None:
    looks, held = looks_of(NARROW, np.float32), valuation("executed")
    alone = rank_over_samples(PLACES, looks, held, seed="s", sizes=[16, 64])
    with ThreadPoolExecutor(3) as pool:
        together = rank_over_samples(PLACES, looks, held, seed="s", sizes=[16, 64], ordered_map=pool.map)
    assert [look.sensor for look in together.looks] == [look.sensor for look in alone.looks]
    assert values(together) == values(alone)
    sample = sample_of(held, 16, "s")
    whole = values_over(PLACES, looks, held, sample)
    chunks = [look for start in range(0, 40, 7) for look in values_over(PLACES[start : start + 7], looks, held, sample)]
    assert [look.net_value for look in chunks] == [look.net_value for look in whole]


def test_driving_is_taken_off_in_every_round() -> None:
    driving = Driving(1.0, 0.0, 0.3)
    looks, held = looks_of(), valuation()
    sampled = rank_over_samples(PLACES, looks, held, seed="", sizes=[16, N], driving=driving)
    exact = rank_looks(PLACES, looks, held, driving=driving)
    assert sampled.looks[0].sensor is exact.looks[0].sensor
    for look in sampled.looks:
        assert look.cost == pytest.approx(look.sensor.cost + driving.cost(look.sensor))


@pytest.mark.statistics
@pytest.mark.parametrize("definition", ["posterior", "executed"])
def test_pending_looks_are_the_baseline_over_the_sampled_poses(definition: Definition) -> None:
    looks, held = replace(looks_of(), pending=(PLACES[20],)), valuation(definition)
    exact = rank_looks(PLACES[:30], looks, held)
    whole = rank_over_samples(PLACES[:30], looks, held, seed="", sizes=[N])
    assert [look.net_value for look in whole.looks] == pytest.approx([look.net_value for look in exact.looks], abs=1e-9)
    some = rank_over_samples(PLACES[:30], looks, held, seed="", sizes=[64])
    first = some.looks[0].assistance
    assert first.standard_error is not None
    of_all = next(look for look in exact.looks if look.sensor is some.looks[0].sensor)
    assert abs(first.voa - of_all.assistance.voa) <= 5.0 * first.standard_error
    assert some.value_of_perfect_information == pytest.approx(exact.value_of_perfect_information, abs=0.05)


@pytest.mark.statistics
@pytest.mark.parametrize("definition", ["posterior", "executed"])
def test_the_error_from_attempts_is_that_of_all_poses(definition: Definition) -> None:
    held = Valuation(random_belief(1), table(attempts=15), UpdatePolicy(), definition)
    looks = looks_of()
    [exact] = values_over(PLACES[30:31], looks, held, sample_of(held, N, ""))
    estimates = []
    for seed in range(100):
        [some] = values_over(PLACES[30:31], looks, held, sample_of(held, 64, str(seed)))
        assert some.assistance.score_standard_error is not None
        estimates.append(some.assistance.score_standard_error)
    assert np.mean(estimates) == pytest.approx(exact.assistance.score_standard_error, rel=0.05)


def test_no_grasp_that_ever_succeeds_is_worth_nothing_anywhere() -> None:
    nothing = GraspTable.of_probabilities(["a"], np.zeros((1, N)), N)
    held = Valuation(random_belief(1), nothing, UpdatePolicy(), "executed")
    sampled = rank_over_samples(PLACES, looks_of(), held, seed="", sizes=[16, 32])
    assert values(sampled) == [0.0] * len(PLACES)
    free = [look for look in sampled.looks if look.sensor.cost == 0.0]
    assert all(sampled.ties_with_first(look) for look in free)
    assert sampled.before.index is None


@pytest.mark.parametrize("sizes", [[], [16, 16], [32, 16]])
def test_sizes_that_do_not_ascend_are_refused(sizes: list[int]) -> None:
    with pytest.raises(InvalidInput, match="sizes"):
        rank_over_samples(PLACES, looks_of(), valuation(), seed="", sizes=sizes)
