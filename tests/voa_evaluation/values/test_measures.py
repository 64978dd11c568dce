"""Measures of agreement: rank correlation beside the oracle's, partial order with confidence."""

import numpy as np
import pytest

from voa_evaluation.values.measures import order_agreement, tau_of_oracle, tau_of_promise
from voa_evaluation.values.truth import Truth


def truth_with(values: list[float], noise: float, scans: int = 400) -> Truth:
    rng = np.random.default_rng(8)
    gains = np.array(values)[:, None, None] + noise * rng.standard_normal((len(values), 2, scans))
    return Truth(np.array([0.5, 0.5]), gains, 0.3)


def test_pairs_that_may_be_equal_do_not_count() -> None:
    truth = truth_with([0.1, 0.1, 0.5], 0.1)
    order = order_agreement(np.array([0.3, 0.2, 0.9]), truth)
    assert (order.alike, order.sure, order.pairs) == (2.0, 2, 3)
    reverse = order_agreement(np.array([0.3, 0.2, 0.1]), truth)
    assert (reverse.alike, reverse.sure) == (0.0, 2)


def test_a_tied_promise_counts_one_half() -> None:
    assert order_agreement(np.array([0.2, 0.2, 0.2]), truth_with([0.1, 0.3, 0.5], 0.05)).alike == 1.5


def test_the_oracle_reaches_one_without_noise_and_less_with_it() -> None:
    values, rng = [0.1, 0.15, 0.2, 0.25, 0.3], np.random.default_rng(9)
    assert tau_of_oracle(truth_with(values, 0.0), rng) == pytest.approx(1.0)
    noisy = tau_of_oracle(truth_with(values, 1.0, 50), rng)
    assert noisy is not None
    assert noisy < 0.9


def test_a_promise_without_an_order_has_no_tau() -> None:
    truth = truth_with([0.1, 0.2, 0.3], 0.0)
    assert tau_of_promise(np.array([0.2, 0.2, 0.2]), truth) is None
    assert tau_of_promise(np.array([0.3, 0.2, 0.1]), truth) == pytest.approx(-1.0)
    assert tau_of_oracle(truth_with([0.2, 0.2], 0.0), np.random.default_rng(1)) is None
