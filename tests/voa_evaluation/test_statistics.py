"""Bootstrap intervals and rank correlation against known values."""

import numpy as np
import pytest
from scipy.stats import kendalltau

from voa_evaluation.statistics import (
    bootstrap_mean,
    bootstrap_rank_correlation,
    bootstrap_ratio,
    rank_correlation,
)


def test_the_interval_of_a_share_is_the_binomials() -> None:
    interval = bootstrap_mean([np.array([1.0] * 40 + [0.0] * 60)], 0)
    assert (interval.value, interval.count) == (0.4, 100)
    assert (interval.low, interval.high) == pytest.approx((0.4 - 1.96 * 0.049, 0.4 + 1.96 * 0.049), abs=0.012)
    assert interval.excludes_zero


def test_pairing_removes_what_both_share() -> None:
    rng = np.random.default_rng(1)
    ours = (rng.random(200) < 0.5).astype(float)
    theirs = ours.copy()
    theirs[:10] = 0.0
    paired = bootstrap_mean([ours - theirs], 0)
    assert paired.value == pytest.approx((ours - theirs).mean())
    assert paired.high - paired.low < 0.08
    assert (bootstrap_mean([ours], 0).high - bootstrap_mean([ours], 0).low) > 0.12


def test_strata_are_resampled_within_themselves() -> None:
    interval = bootstrap_mean([np.ones(30), np.zeros(70)], 0)
    assert (interval.low, interval.value, interval.high) == pytest.approx((0.3, 0.3, 0.3))
    assert not bootstrap_mean([np.array([1.0, -1.0] * 20)], 0).excludes_zero


def test_the_seed_decides() -> None:
    values = [np.arange(20, dtype=float)]
    assert bootstrap_mean(values, 3) == bootstrap_mean(values, 3)
    assert bootstrap_mean(values, 3) != bootstrap_mean(values, 4)


def test_nothing_has_no_mean() -> None:
    with pytest.raises(ValueError, match="at least one observation"):
        bootstrap_mean([np.zeros(0)], 0)
    with pytest.raises(ValueError, match="at least one observation"):
        bootstrap_ratio(np.zeros(3), np.zeros(3), 0)


def test_a_ratio_is_sum_over_sum() -> None:
    interval = bootstrap_ratio(np.array([2.0, 0.0, 1.0]), np.array([4.0, 0.0, 2.0]), 0)
    assert (interval.value, interval.low, interval.high, interval.count) == pytest.approx((0.5, 0.5, 0.5, 6))


def test_tau_of_known_orders() -> None:
    up = np.array([1.0, 2.0, 3.0, 4.0])
    assert rank_correlation(up, up) == 1.0
    assert rank_correlation(up, -up) == -1.0
    # One of six pairs is turned round: (5 - 1) / 6.
    assert rank_correlation(up, np.array([1.0, 2.0, 4.0, 3.0])) == pytest.approx(2.0 / 3.0)
    assert rank_correlation(up, np.ones(4)) is None


def test_resampled_taus_are_scipys() -> None:
    rng = np.random.default_rng(0)
    beforehand = np.array([0.1, 0.1, 0.3, 0.4, 0.2])
    achieved = rng.integers(-1, 2, (40, 5)).astype(float)
    interval = bootstrap_rank_correlation(beforehand, achieved, 5, resamples=200)
    chosen = np.random.default_rng(5).integers(0, 40, (200, 40))
    taus = [kendalltau(beforehand, np.round(achieved[rows].mean(axis=0), 12)).statistic for rows in chosen]
    assert interval is not None
    assert interval.value == pytest.approx(kendalltau(beforehand, np.round(achieved.mean(axis=0), 12)).statistic)
    assert (interval.low, interval.high) == pytest.approx(tuple(np.percentile(taus, [2.5, 97.5])))
    assert bootstrap_rank_correlation(np.ones(5), achieved, 0) is None


def test_means_that_differ_by_a_rounding_error_have_no_order() -> None:
    beforehand = np.array([0.1, 0.2, 0.3])
    measured = np.array([[0.1, 0.3, 0.2], [0.2, 0.1, 0.3], [0.3, 0.2, 0.1]])
    assert np.ptp(measured.mean(axis=0)) > 0.0
    assert rank_correlation(beforehand, measured.mean(axis=0)) is None
    assert bootstrap_rank_correlation(beforehand, measured, 0) is None


def test_equal_observations_up_to_rounding_have_no_rank_correlation() -> None:
    measured = np.tile([0.1 + 0.2, 0.3, 0.3], (4, 1))
    assert bootstrap_rank_correlation(np.array([0.1, 0.2, 0.3]), measured, 0) is None


def test_an_order_that_no_resample_shows_has_no_interval() -> None:
    beforehand, measured = np.array([0.1, 0.2]), np.array([[0.0, 1.0]] + [[0.0, 0.0]] * 400)
    assert None in [bootstrap_rank_correlation(beforehand, measured, seed, resamples=1) for seed in range(20)]
