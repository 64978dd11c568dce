"""Exponentials and logarithms of our own, against those of the library."""

import math
import re
from collections.abc import Callable
from decimal import Decimal
from typing import Any

import numba
import numpy as np
import pytest

from tests.voa_core.test_jit import UNCOMPILED
from voa_core.checks import Floats
from voa_core.vector_math import (
    _EXACT_HALVES,
    _EXP,
    _FLOAT32_HALVES,
    HALVING_WIDTH,
    LOWEST,
    bound_of_half_to_the,
    exact_half_to_the,
    exp_of_negative,
    half_to_the,
    half_to_the_float32,
    take_exponentials,
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
    powers = np.concatenate([POWERS, np.linspace(57.7, 1000.0, 5_001)])
    np.testing.assert_allclose(halves_of(half_to_the, powers), np.exp2(-powers), rtol=1e-12)
    assert (
        halves_of(half_to_the, np.array([1001.0, 1e300, math.inf])) == halves_of(half_to_the, np.array([1e3]))
    ).all()


@pytest.mark.parametrize(("coefficients", "error"), [(_EXACT_HALVES, 3.5e-16), (_FLOAT32_HALVES, 4e-8)])
def test_polynomials_of_halves_are_exact_to_a_rounding(coefficients: tuple[float, ...], error: float) -> None:
    for t in (Decimal(each) / 1000 for each in range(-500, 501)):
        value = Decimal(0)
        for coefficient in reversed(coefficients):
            value = value * t + Decimal(float(coefficient))
        assert abs(value / Decimal(2) ** -t - 1) < error
    assert coefficients[0] == 1.0


def test_exact_powers_of_a_half_are_exact_to_a_few_roundings() -> None:
    powers = np.concatenate([POWERS, np.linspace(57.0, 1010.0, 9973), np.arange(1010) + 0.5])
    np.testing.assert_allclose(halves_of(exact_half_to_the, powers), np.exp2(-powers), rtol=1e-15)
    assert halves_of(exact_half_to_the, np.array([0.0, 3.0, 1010.001, 1e300, math.inf])).tolist() == [1, 0.125, 0, 0, 0]
    assert math.isnan(halves_of(exact_half_to_the, np.array([math.nan]))[0])


def test_powers_of_a_half_in_float32_are_exact_to_a_few_roundings() -> None:
    numbers = np.zeros(1, dtype=np.float32)
    powers = np.concatenate([POWERS, np.linspace(57.0, 125.0, 4001), [125.1, 1e30, math.inf]]).astype(np.float32)
    own = [half_to_the_float32(power, numbers, numbers.view(np.int32), 0) for power in powers]
    expected = np.where(powers > 125.0, 0.0, np.exp2(-powers.astype(np.float64)))
    np.testing.assert_allclose(own, expected, rtol=3e-7)
    assert own[0] == 1.0


@pytest.mark.parametrize("count", [0, 1, 511, 512, 513, 1200])
def test_exponentials_of_many_numbers(count: int) -> None:
    numbers = np.append(-np.logspace(-17, math.log10(699.9), 1199), 0.0)[1200 - count :]
    own = numbers.copy()
    take_exponentials(own)
    assert (np.abs(own - np.exp(numbers)) <= (1e-15 - 3e-16 * numbers) * np.exp(numbers)).all()


def test_exponentials_of_numbers_at_the_ends() -> None:
    ends = np.array([0.0, -701.0, -math.inf, math.nan])
    take_exponentials(ends)
    assert ends[:3].tolist() == [1.0, 0.0, 0.0]
    assert math.isnan(ends[3])


@pytest.mark.skipif(UNCOMPILED, reason="nothing is compiled, so nothing runs in vector registers")
def test_exponentials_are_taken_several_at_a_time() -> None:
    """A compiled loop over numbers that do not lie side by side, such as the rows of a loop over a matrix, does not."""
    written: Any = take_exponentials
    compiled = numba.njit(nogil=True, error_model="numpy")(written.py_func)
    compiled(np.zeros(3))
    assert re.search(r"= fmul .*<\d+ x double>", "".join(compiled.inspect_llvm().values()))


def test_the_bound_of_powers_of_a_half_lies_above_by_little() -> None:
    ratios = halves_of(bound_of_half_to_the, POWERS) / np.exp2(-POWERS)
    assert ratios.min() > 1.0
    assert ratios.max() < 1.0002
    assert (halves_of(bound_of_half_to_the, np.array([60.0, 1e300, math.inf])) >= 2.0**-1000).all()


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
