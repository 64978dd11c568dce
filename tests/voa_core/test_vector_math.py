"""Exponentials and logarithms of our own, against those of the library."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from voa_core.checks import Floats
from voa_core.vector_math import (
    _EXP,
    HALVING_WIDTH,
    LOWEST,
    bound_of_half_to_the,
    exp_of_negative,
    half_to_the,
    take_logarithms,
)

EXPONENTS = -np.concatenate([[0.0], np.linspace(0.0, 40.0, 4001), np.logspace(-12, 1, 200)])


def test_coefficients_are_those_of_a_chebyshev_interpolation() -> None:
    middle = -LOWEST / 128.0
    derived = np.polynomial.Chebyshev.interpolate(lambda t: np.exp(t - middle), 9, domain=[-middle, middle])
    coefficients = derived.convert(kind=np.polynomial.Polynomial).coef
    assert list(_EXP[1:]) == pytest.approx([float(each) for each in coefficients[1:]], rel=1e-4)
    assert 0.0 <= _EXP[0] - coefficients[0] + 1e-15 < 5e-6


def test_exponentials_are_exact_to_a_millionth_of_a_millionth() -> None:
    own = [exp_of_negative(float(x)) for x in EXPONENTS]
    np.testing.assert_allclose(own, np.exp(EXPONENTS), rtol=1e-12)
    assert exp_of_negative(-1e300) == exp_of_negative(-math.inf) == pytest.approx(math.exp(-40.0))


POWERS = np.concatenate([[0.0], np.linspace(0.0, 57.7, 20_001), np.arange(57) + 0.5, np.logspace(-12, 1, 200)])


def halves_of(function: Callable[..., float], powers: Floats) -> Floats:
    numbers = np.zeros(1)
    return np.array([function(float(power), numbers, numbers.view(np.int64), 0) for power in powers])


def test_powers_of_a_half_are_exact_to_a_millionth_of_a_millionth() -> None:
    np.testing.assert_allclose(halves_of(half_to_the, POWERS), np.exp2(-POWERS), rtol=1e-12)
    np.testing.assert_allclose(halves_of(half_to_the, np.array([60.0, 1e300, math.inf])), math.exp(-40.0), rtol=1e-12)


def test_the_bound_of_powers_of_a_half_lies_above_by_little() -> None:
    ratios = halves_of(bound_of_half_to_the, POWERS) / np.exp2(-POWERS)
    assert ratios.min() > 1.0
    assert ratios.max() < 1.0002
    assert (halves_of(bound_of_half_to_the, np.array([60.0, 1e300, math.inf])) > math.exp(-40.0)).all()


def test_the_width_of_halving_is_that_of_a_normal_density() -> None:
    halved = 2.0 ** -((HALVING_WIDTH * 1.7) ** 2)
    assert halved == pytest.approx(math.exp(-0.5 * 1.7**2), rel=1e-15)


def test_logarithms() -> None:
    values = np.concatenate([np.logspace(-307, 308, 5000), [1.0, math.sqrt(2.0), 1.0 - 1e-16, 2.0**-1022]])
    own = values.copy()
    take_logarithms(own, np.zeros(len(own), dtype=np.int64))
    np.testing.assert_allclose(own, np.log(values), rtol=1e-14, atol=1e-15)
    none = np.array([0.0, 2.0**-1040])
    take_logarithms(none, np.zeros(2, dtype=np.int64))
    assert (none == -np.inf).all()
