"""Exponentials and logarithms of our own, against those of the library."""

import math

import numpy as np
import pytest

from voa_core.vector_math import _BOUND, _EXP, LOWEST, bound_of_exp, exp_of_negative, take_logarithms

EXPONENTS = -np.concatenate([[0.0], np.linspace(0.0, 40.0, 4001), np.logspace(-12, 1, 200)])


def test_coefficients_are_those_of_a_chebyshev_interpolation() -> None:
    middle = -LOWEST / 128.0
    for own, degree in ((_EXP, 9), (_BOUND, 4)):
        derived = np.polynomial.Chebyshev.interpolate(lambda t: np.exp(t - middle), degree, domain=[-middle, middle])
        coefficients = derived.convert(kind=np.polynomial.Polynomial).coef
        assert list(own[1:]) == pytest.approx([float(each) for each in coefficients[1:]], rel=1e-4)
        assert 0.0 <= own[0] - coefficients[0] + 1e-15 < 5e-6


def test_exponentials_are_exact_to_a_millionth_of_a_millionth() -> None:
    own = [exp_of_negative(float(x)) for x in EXPONENTS]
    np.testing.assert_allclose(own, np.exp(EXPONENTS), rtol=1e-12)
    assert exp_of_negative(-1e300) == exp_of_negative(-math.inf) == pytest.approx(math.exp(-40.0))


def test_the_bound_lies_above_by_little() -> None:
    ratios = np.array([bound_of_exp(float(x)) for x in EXPONENTS]) / np.exp(EXPONENTS)
    assert ratios.min() > 1.0
    assert ratios.max() < 1.001
    assert bound_of_exp(-1e300) > math.exp(-40.0)


def test_logarithms() -> None:
    values = np.concatenate([np.logspace(-307, 308, 5000), [1.0, math.sqrt(2.0), 1.0 - 1e-16, 2.0**-1022]])
    own = values.copy()
    take_logarithms(own, np.zeros(len(own), dtype=np.int64))
    np.testing.assert_allclose(own, np.log(values), rtol=1e-14, atol=1e-15)
    none = np.array([0.0, 2.0**-1040])
    take_logarithms(none, np.zeros(2, dtype=np.int64))
    assert (none == -np.inf).all()
