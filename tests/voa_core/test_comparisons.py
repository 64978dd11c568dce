"""Comparisons with displaced copies in loops made for a rule, against the statistic of that rule."""

import math
from typing import Any

import numpy as np
import pytest

from tests.voa_core.simulated_worlds import LIDAR, NEAR, OBJECT, POSES, PlainGaussian
from tests.voa_core.worlds import RULE_NAMES, box
from voa_core.checks import Floats
from voa_core.comparisons import ComparesCopies, PlainComparison, comparison_of, squared_distances_of_pairs
from voa_core.copies import negligible
from voa_core.displaced_scans import DisplacedScans, predict_copies
from voa_core.displacements import standard_normal_points
from voa_core.filtering import log_means
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rules import distance_comparison
from voa_core.rules.distances import squared_distance
from voa_core.rules.mixture_comparison import MixtureComparison
from voa_core.rules.registry import rule_of

COPIES = 32
CASES = [
    *((name, {}) for name in RULE_NAMES),
    ("beam", {"temper": 1.0, "sigma_hit_m": 0.001}),
    ("beam", {"z_short": 0.0, "lambda_short_per_m": 1e-4}),
    ("beam", {"z_hit": 0.0}),
    ("margin", {"margin_m": 0.05}),
    ("inverse_rmsd", {"no_return_m": 0.3}),
]
every_rule = pytest.mark.parametrize(("name", "parameters"), CASES, ids=str)


def nowhere() -> None:
    pass


def copies_at_near() -> DisplacedScans:
    points = standard_normal_points(COPIES, "seed") * [0.01, 0.01, 0.08]
    return predict_copies(predictor_of_mesh(OBJECT, POSES, LIDAR), NEAR, np.repeat(points[None], 5, axis=0))


def scans_of(copies: DisplacedScans, seed: int) -> Floats:
    """Noisy scans of copies, and outliers: lost beams, walls, hands, nothing at all, and no beam."""
    rng = np.random.default_rng(seed)
    dense = copies.prediction().dense()
    scans = dense[rng.integers(len(dense), size=20)] + rng.normal(0.0, 0.005, (20, dense.shape[1]))
    scans[4][rng.random(len(scans[4])) < 0.3] = np.nan
    scans[5][rng.random(len(scans[5])) < 0.3] = np.inf
    scans[6] = np.minimum(scans[6], 0.15)
    scans[7] = rng.uniform(0.1, 2.0, len(scans[7]))
    scans[8] = np.inf
    scans[9] = np.nan
    scans[10] += 0.07
    return scans


@every_rule
def test_weights_are_those_of_the_rules_own_statistic(name: str, parameters: dict[str, Any]) -> None:
    rule, copies = rule_of(name, LIDAR, **parameters), copies_at_near()
    scans = scans_of(copies, 1)
    own, plain = comparison_of(rule, scans, copies), PlainComparison(rule, scans, copies)
    assert not isinstance(own, PlainComparison)
    pairs = np.tile(np.arange(20), 5), np.repeat(np.arange(5), 20)
    expected = plain.log_weights(*pairs)
    np.testing.assert_allclose(own.log_weights(*pairs), expected, rtol=1e-10, atol=1e-9)
    nobody, everything = np.full(20, -1), np.full(20, -np.inf)
    means = own.log_means(nobody, everything, nowhere)
    compared = np.arange(20) != 9
    np.testing.assert_allclose(
        means[:, compared], log_means(expected).reshape(5, 20)[:, compared], rtol=1e-10, atol=1e-9
    )
    np.testing.assert_allclose(
        plain.log_means(nobody, everything, nowhere), log_means(expected).reshape(5, 20), rtol=1e-12, atol=1e-12
    )


@pytest.mark.parametrize("leaves_out", [False, True])
def test_weights_far_below_their_bounds_are_right(leaves_out: bool) -> None:
    """With many fine beams a scan is thousands of nats away from a bound that takes the likeliest copy on each beam."""
    lidar = LidarModel(BeamGrid(1440, 0.0, math.pi / 720), 0.1, 30.0, 0.1, "missing", 0.002, 0.0, 0.05)
    rule, near = rule_of("beam", lidar, temper=1.0), SensorConfiguration("near", -0.5, 0.05, 0.1)
    poses = PoseSet.from_arrays(["A", "B"], [(0.0, 0.0, 0.0), (0.004, 0.002, 0.0)], [(1.0, 0.0, 0.0, 0.0)] * 2)
    predictor, random = predictor_of_mesh(box(0.3, 0.4, 0.2), poses, lidar), np.random.default_rng(1)
    points = 0.05 * standard_normal_points(COPIES, "seed")
    copies = predict_copies(predictor, near, np.repeat(points[None], 2, axis=0))
    drawn = predict_copies(predictor, near, 0.05 * random.normal(size=(2, 8, 3))).prediction().dense()
    scans = drawn + random.normal(0.0, 0.002, drawn.shape)
    own, pairs = np.repeat([0, 1], 8), (np.tile(np.arange(16), 2), np.repeat([0, 1], 16))
    every = PlainComparison(rule, scans, copies).log_weights(*pairs).reshape(2, 16, COPIES)
    expected = log_means(every.reshape(32, COPIES)).reshape(2, 16)
    least = expected[own, np.arange(16)] - 23.0 if leaves_out else np.full(16, -np.inf)
    means = comparison_of(rule, scans, copies).log_means(own, least, nowhere)
    matters = expected >= least
    np.testing.assert_allclose(means[matters], expected[matters], rtol=1e-10, atol=1e-9)
    assert (means[~matters] <= least[None].repeat(2, axis=0)[~matters] + 1e-9).all()
    assert every.max() - every.min() > 700.0, "the case is one where weights differ by more than a float64 holds"


@pytest.mark.parametrize("name", ["beam"])
@pytest.mark.parametrize("less", [0.0, 5.0, 20.0])
def test_nothing_that_weighs_enough_is_left_out(name: str, less: float) -> None:
    copies = copies_at_near()
    for parameters in ({}, {"temper": 1.0}, {"z_short": 0.4, "sigma_hit_m": 0.03}):
        rule = rule_of(name, LIDAR, **parameters)
        left = 0
        for seed in range(10):
            scans = scans_of(copies, seed)
            own, every = np.full(20, -1), PlainComparison(rule, scans, copies)
            logs = every.log_weights(np.tile(np.arange(20), 5), np.repeat(np.arange(5), 20)).reshape(5, 20, COPIES)
            least = logs.max(axis=(0, 2)) - less
            means = comparison_of(rule, scans, copies).log_means(own, least, nowhere)
            kept = np.where(logs >= least[:, None] + 1e-9, logs, -np.inf)
            with np.errstate(divide="ignore"):
                lower = np.log(np.exp(kept).mean(axis=2))
            upper = np.log(np.exp(logs).mean(axis=2))
            assert (means >= lower - 1e-9).all()
            assert (means <= upper + 1e-9).all()
            left += int((means < upper - 1e-9).sum())
        assert left > 0 or less > 5.0


def test_of_the_pose_that_gives_a_scan_nothing_is_left_out() -> None:
    copies, rule = copies_at_near(), rule_of("beam", LIDAR)
    scans = scans_of(copies, 3)
    comparison = comparison_of(rule, scans, copies)
    assert comparison.leaves_out
    own = np.arange(20) % 5
    means = comparison.log_means(own, np.full(20, np.inf), nowhere)
    of_own = means[own, np.arange(20)]
    np.testing.assert_allclose(of_own, log_means(comparison.log_weights(np.arange(20), own)), rtol=0, atol=1e-9)
    means[own, np.arange(20)] = -np.inf
    assert (means == -np.inf).all()


@pytest.mark.parametrize("above", [0.0, 0.3, 1.0, 3.0, 10.0, np.inf])
def test_poses_and_clusters_that_cannot_weigh_enough_are_left_out_whole(above: float) -> None:
    copies, rule = copies_at_near(), rule_of("beam", LIDAR)
    scans = scans_of(copies, 4)
    comparison = comparison_of(rule, scans, copies)
    most = PlainComparison(rule, scans, copies).log_weights(np.tile(np.arange(20), 5), np.repeat(np.arange(5), 20))
    least = most.reshape(5, 20, COPIES).max(axis=(0, 2)) + above
    means = comparison.log_means(np.full(20, -1), least, nowhere)
    assert ((means == -np.inf) | (means <= least)).all()
    assert (means == -np.inf).all() or above < np.inf


def test_products_of_few_factors_give_the_same_weights() -> None:
    copies, rule = copies_at_near(), rule_of("beam", LIDAR)
    scans = scans_of(copies, 5)
    usual, short = comparison_of(rule, scans, copies), comparison_of(rule, scans, copies)
    assert isinstance(short, MixtureComparison)
    short._mixture = short._mixture._replace(factors=3)
    pairs = np.tile(np.arange(20), 5), np.repeat(np.arange(5), 20)
    np.testing.assert_allclose(short.log_weights(*pairs), usual.log_weights(*pairs), rtol=1e-12, atol=1e-9)
    for least in (np.full(20, -np.inf), np.full(20, -30.0)):
        own = np.arange(20) % 5
        np.testing.assert_allclose(
            short.log_means(own, least, nowhere), usual.log_means(own, least, nowhere), rtol=1e-12, atol=1e-9
        )


def test_a_comparison_of_many_poses_can_be_ended_between_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distance_comparison, "_NUMBERS_AT_ONCE", 1)
    copies, rule = copies_at_near(), rule_of("gaussian", LIDAR)
    scans, checked = scans_of(copies, 6), []
    comparison = comparison_of(rule, scans, copies)
    means = comparison.log_means(np.full(20, -1), np.full(20, -np.inf), lambda: checked.append(1))
    assert means.shape == (5, 20)
    assert 0 < len(checked) < 5


@pytest.mark.parametrize("parameters", [{"z_random": 0.0}, {"z_no_return": 0.0}, {"z_random": 1e-12}])
def test_mixtures_that_exclude_something_are_compared_by_their_statistic(parameters: dict[str, float]) -> None:
    rule, copies = rule_of("beam", LIDAR, **parameters), copies_at_near()
    assert isinstance(comparison_of(rule, scans_of(copies, 1), copies), PlainComparison)


def test_other_rules_and_single_copies_are_compared_by_their_statistic() -> None:
    copies = copies_at_near()
    other = PlainGaussian()
    assert not isinstance(other, ComparesCopies)
    scans = scans_of(copies, 1)
    own = comparison_of(other, scans, copies)
    assert isinstance(own, PlainComparison)
    assert not own.leaves_out
    one = DisplacedScans.of(copies.prediction())
    assert isinstance(comparison_of(rule_of("beam", LIDAR), scans, one), PlainComparison)


def test_squared_distances() -> None:
    copies = copies_at_near()
    scans = scans_of(copies, 2)[:4]
    pairs = np.repeat(np.arange(4), 5), np.tile(np.arange(5), 4)
    own = squared_distances_of_pairs(scans, copies, 1.0, *pairs).reshape(4, -1)
    np.testing.assert_allclose(own, squared_distance(scans, copies.prediction().dense(), 1.0), rtol=1e-12)


def test_more_poses_leave_out_less() -> None:
    assert negligible(5) == negligible(500) == pytest.approx(23.0, abs=0.1)
    assert negligible(20_000) == pytest.approx(26.7, abs=0.1)
    for poses in (1, 500, 20_000):
        assert 2 * poses * np.exp(-negligible(poses)) <= 1.0001e-7
