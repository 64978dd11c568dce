"""Samples of gains: means, differences and ratios with intervals that cover."""

import numpy as np
import pytest

from voa_core.checks import Floats
from voa_evaluation.values.samples import Gathering, Sample, interval_of, ratio_of, standard_error_of

SHARES = np.array([0.25, 0.75])


def drawn(rng: np.random.Generator, mean: float, cases: int = 12, scans: int = 20) -> Sample:
    """Gains of cases that differ by 0.1, over scans that they share and that vary by 0.5."""
    shared = 0.5 * rng.standard_normal((2, scans))
    gathering = Gathering()
    for _ in range(cases):
        gathering.add(SHARES, mean + 0.1 * float(rng.standard_normal()) + shared)
    return gathering.sample()


def test_the_interval_covers_the_mean_of_cases_and_of_scans() -> None:
    rng = np.random.default_rng(1)
    covered = 0
    for _ in range(400):
        interval = interval_of([drawn(rng, 0.2), drawn(rng, 0.4)])
        assert interval.count == 24
        covered += interval.low <= 0.3 <= interval.high
    assert 0.90 <= covered / 400 <= 0.99


def test_what_two_gains_share_cancels_in_their_difference() -> None:
    one = drawn(np.random.default_rng(2), 0.2)
    other = Sample(one.cases + 0.1, one.scans + 0.1 * SHARES[:, None])
    difference = interval_of([other - one])
    assert difference.value == pytest.approx(0.1)
    assert difference.high - difference.low == pytest.approx(0.0, abs=1e-9)
    assert interval_of([one + one.scaled(-1.0)]).value == pytest.approx(0.0)


def test_the_means_over_cases_and_over_scans_agree() -> None:
    sample = drawn(np.random.default_rng(3), 0.3)
    assert sample.scans.mean(axis=1).sum() == pytest.approx(sample.mean)


def test_a_ratio_covers_and_needs_a_sure_denominator() -> None:
    rng = np.random.default_rng(6)
    covered = 0
    for _ in range(300):
        own: Floats = 0.3 + 0.1 * rng.standard_normal((2, 40))
        lead: Floats = 0.6 + 0.1 * rng.standard_normal((2, 40))
        over, under = Gathering(), Gathering()
        over.add(SHARES, own)
        under.add(SHARES, lead)
        ratio = ratio_of([over.sample()], [under.sample()])
        assert ratio is not None
        covered += ratio.low <= 0.5 <= ratio.high
    assert 0.90 <= covered / 300 <= 0.99
    noise = drawn(rng, 0.0)
    assert ratio_of([noise], [noise]) is None
    assert standard_error_of([noise]) > 0.0


def test_no_case_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one case"):
        Gathering().sample()
