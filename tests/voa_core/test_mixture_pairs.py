"""Log-likelihoods of pairs under the mixture, against the sum of the logarithms of all densities in float64."""

import math
from typing import Any

import numpy as np
import pytest

from voa_core.checks import Floats
from voa_core.kernels import Array
from voa_core.mixture import Mixture
from voa_core.mixture_pairs import _predicted_returns, log_likelihoods

INF = math.inf
MIXTURE = Mixture(
    hit_peak=0.33,
    short=0.05,
    random=0.02,
    lost=0.07,
    nothing=0.48,
    decay_per_m=1.0,
    sigma_m=0.005,
    noise_ratio=0.01,
    range_max=3.5,
    temper=0.25,
    factors=1,
)
DOUBLE, SINGLE = np.float64, np.float32


def full_sum(observed: Array, predicted: Array, mixture: Mixture) -> Floats:
    """Sum over beams of the logarithm of every density, (m, n), by the table in `rules.beam.Beam`."""
    z, expected = observed.astype(np.float64)[:, None], predicted.astype(np.float64)[None]
    returns, seen = np.isfinite(z), np.isfinite(expected)
    mean = np.where(seen, expected, 1.0)
    within = np.clip(mean, 1e-9, mixture.range_max)
    off = np.where(returns & seen, (np.where(returns, z, 0.0) - mean), 0.0)
    sigma = np.maximum(mixture.sigma_m, mixture.noise_ratio * within)
    decay = mixture.short * np.exp(-mixture.decay_per_m * np.where(returns, z, 0.0))
    hit = mixture.hit_peak / sigma * np.exp(-0.5 * (off / sigma) ** 2)
    before = np.where(off <= 0.0, decay / -np.expm1(-mixture.decay_per_m * within), 0.0)
    both = hit + before + mixture.random
    behind = (mixture.nothing - mixture.lost) / mixture.range_max
    none = behind + decay / -math.expm1(-mixture.decay_per_m * mixture.range_max) + mixture.random
    density = np.where(seen, np.where(returns, both, mixture.lost), np.where(returns, none, mixture.nothing))
    with np.errstate(divide="ignore"):
        logs: Floats = np.log(density).sum(axis=2)
    return logs


def arcs(n: int, beams: int, seed: int, share: float = 1.0) -> Floats:
    """Predictions (n, beams) of objects that a part of the beams meet, across the last beam too; some meet none."""
    random = np.random.default_rng(seed)
    first, length = random.integers(0, beams, n), random.integers(0, max(1, int(share * beams)), n)
    inside = (np.arange(beams) - first[:, None]) % beams < length[:, None]
    ranges: Floats = np.where(inside, random.uniform(0.3, 0.34, (n, 1)) + random.normal(0.0, 0.01, (n, beams)), INF)
    return ranges


@pytest.mark.parametrize(("m", "n", "beams"), [(1, 1, 1), (3, 7, 5), (9, 4, 40), (2, 1030, 12), (2, 20, 90)])
def test_they_are_the_full_sum(m: int, n: int, beams: int) -> None:
    observed, predicted = arcs(m, beams, 1), arcs(n, beams, 2)
    ours = log_likelihoods(observed, predicted, MIXTURE)
    np.testing.assert_allclose(ours, full_sum(observed, predicted, MIXTURE), rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize("dtype", [DOUBLE, SINGLE])
def test_without_beams_or_returns_nothing_is_compared(dtype: type[np.floating]) -> None:
    empty = np.zeros((2, 0), dtype=dtype)
    assert log_likelihoods(empty, empty, MIXTURE).tolist() == [[0.0, 0.0], [0.0, 0.0]]
    silent = np.full((2, 3), INF, dtype=dtype)
    np.testing.assert_allclose(log_likelihoods(silent, silent, MIXTURE), 3.0 * math.log(0.48), rtol=1e-7)


# Standard deviations between two returns, and the mixtures under which the float32 density of such a pair is tested.
OFFS = np.concatenate([[0.0], np.linspace(1e-3, 12.0, 1500), [20.0, 60.0, 300.0]])
MIXTURES: list[dict[str, Any]] = [
    {},
    {"random": 3e-6, "short": 1e-7},
    {"random": 2.0, "hit_peak": 0.01},
    {"sigma_m": 0.2, "noise_ratio": 0.3},
]


@pytest.mark.parametrize("changed", MIXTURES)
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_in_float32_the_density_of_two_returns_is_off_by_little(changed: dict[str, Any], side: float) -> None:
    mixture = MIXTURE._replace(**changed)
    sigma = max(mixture.sigma_m, mixture.noise_ratio * 1.7)
    observed = np.full((1, 1), 1.7, dtype=np.float32)
    predicted = np.maximum(1.7 + side * sigma * OFFS, 0.01).astype(np.float32)[:, None]
    ours = log_likelihoods(observed, predicted, mixture)[0]
    expected = full_sum(observed, predicted, mixture)[0]
    off = np.abs(1.7 - predicted[:, 0]) / np.maximum(mixture.sigma_m, mixture.noise_ratio * predicted[:, 0])
    error = np.abs(ours - expected) - np.spacing(np.abs(expected).astype(np.float32))  # the result's own rounding
    assert ours.dtype == np.float32
    assert (error <= np.minimum(1e-6 + 3e-7 * off**2, 2e-5)).all()


@pytest.mark.parametrize(("n", "beams"), [(60, 20), (60, 200), (515, 40)])
def test_in_float32_whole_scans_are_off_by_no_more_than_the_sum_over_their_beams(n: int, beams: int) -> None:
    scans = arcs(n, beams, 3).astype(np.float32)
    ours, expected = log_likelihoods(scans[:50], scans, MIXTURE), full_sum(scans[:50], scans, MIXTURE)
    both = np.isfinite(scans[:50]).astype(int) @ np.isfinite(scans).T.astype(int)
    assert (np.abs(ours - expected) <= 2e-6 * (1 + both) + 3e-7 * np.abs(expected)).all()
    weights = [np.exp(0.25 * (logs - logs.max(axis=1, keepdims=True))) for logs in (ours, expected)]
    assert np.abs(weights[0] - weights[1]).max() <= 1e-5


@pytest.mark.parametrize(
    "changed",
    [
        {"random": 0.0},
        {"random": 1e-200},
        {"random": 1e-30},
        {"sigma_m": 1e-12, "noise_ratio": 0.0},
        {"sigma_m": 1e-12, "noise_ratio": 0.0, "hit_peak": 0.0},
        {"lost": 0.0},
        {"lost": 0.0, "nothing": 0.0},
        {"random": 0.0, "short": 0.0, "hit_peak": 0.0, "lost": 0.48},
        {"short": 0.0},
        {"decay_per_m": 1e-6},
        {"decay_per_m": 300.0},
    ],
)
def test_mixtures_that_exclude_something_or_are_uneven_agree_too(changed: dict[str, Any]) -> None:
    mixture = MIXTURE._replace(**changed)
    for dtype, tolerance in ((DOUBLE, 1e-12), (SINGLE, 2e-6)):
        observed, predicted = arcs(5, 30, 5, 0.3).astype(dtype), arcs(40, 30, 6, 0.3).astype(dtype)
        observed[:, 3] = INF
        observed[1], predicted[1] = INF, predicted[0]
        predicted[2] = observed[2]
        ours, expected = log_likelihoods(observed, predicted, mixture), full_sum(observed, predicted, mixture)
        assert ours.dtype == dtype
        assert not np.isnan(ours).any()
        np.testing.assert_array_equal(ours == -INF, expected == -INF)
        some = expected > -INF
        np.testing.assert_allclose(ours[some], expected[some], rtol=tolerance, atol=30 * tolerance)


def test_densities_of_next_to_nothing_count_as_0() -> None:
    scans = np.array([[0.5, INF], [INF, INF]])
    hardly = MIXTURE._replace(lost=1e-150)
    assert (log_likelihoods(scans, scans, hardly) == -INF).tolist() == [[False, False], [True, False]]
    barely = MIXTURE._replace(random=0.0, hit_peak=0.0, short=1e-150, lost=0.48)
    assert (log_likelihoods(scans, scans, barely) == -INF).tolist() == [[True, True], [False, False]]


@pytest.mark.parametrize("dtype", [DOUBLE, SINGLE])
def test_returns_of_neighbours_fill_narrow_windows_across_the_last_beam(dtype: type[np.floating]) -> None:
    middles = np.random.default_rng(7).integers(-20, 20, 400)
    inside = np.abs((np.arange(360) - middles[:, None] + 180) % 360 - 180) <= 5
    ranges = np.where(inside, 0.4, INF)[:, inside.any(axis=0)]
    tables = _predicted_returns(ranges.astype(dtype), MIXTURE, dtype)
    widths = tables.windows[:, 1] - tables.windows[:, 0]
    assert (tables.means > 0.0).sum() > 0.75 * widths.sum()
    assert sorted(tables.order.tolist()) == list(range(400))
    assert tables.counts.tolist() == [11.0] * 400
    assert tables.means.dtype == tables.inverse_widths.dtype == tables.shorts.dtype == dtype
