"""Exponentials and logarithms in loops that run in vector registers, which calls of a library would not."""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import frugal_kernel, sum_kernel

LOWEST = -40.0
"""Exponent below which `exp_of_negative` falls no further: e^-40 is 4.2e-18."""
_SHARE, _MIDDLE = 1.0 / 64.0, 0.3125
# exp(t - 0.3125) as a polynomial in t for |t| <= 0.3125, by Chebyshev interpolation: its sixth square is exp(x).
# tests/voa_core/test_vector_math.py derives the coefficients again.
_EXP = (
    0.7316156289466457,
    0.7316156289466444,
    0.3658078144713666,
    0.12193593815720898,
    0.030483984695859265,
    0.00609679693971202,
    0.0010161284351348882,
    0.00014516115478515633,
    1.8195437500000008e-05,
    2.022100000000001e-06,
)
# 2^-t as a polynomial in t for |t| <= 1/2, of the least largest relative error (7.8e-13), and one from above (1.6e-4).
_HALVES = (
    0.999999999999764,
    -0.6931471805465075,
    0.24022650698873377,
    -0.05550410939355957,
    0.009618128544002146,
    -0.001333345205263195,
    0.00015403851076051245,
    -1.5309739497482155e-05,
    1.3175988780034231e-06,
)
_HALVES_BOUND = (1.000008067243192, -0.693316447081855, 0.24263054027328204, -0.055176083093079344)
_MOST_HALVINGS = -LOWEST * math.log2(math.e)
_TO_WHOLE = 1.5 * 2.0**52  # a float64 that is added to this is rounded, and its whole part fills the lowest bits
HALVING_WIDTH = math.sqrt(0.5 * math.log2(math.e))
"""Factor h with which 2^-(h x)^2 = exp(-x^2 / 2)."""

_EXPONENT_BITS, _BIAS = 52, 1023
_MANTISSA, _ONE = (1 << 52) - 1, 1023 << 52
_LN_2, _SQRT_2 = math.log(2.0), math.sqrt(2.0)
_LEAST_NORMAL = 2.0**-1022


@sum_kernel
def exp_of_negative(x: float) -> float:
    """exp(x) for x <= 0 within 1e-12 of it, without branches; e^-40 for all x below -40."""
    t = max(x, LOWEST) * _SHARE + _MIDDLE
    p = _EXP[9]
    p = p * t + _EXP[8]
    p = p * t + _EXP[7]
    p = p * t + _EXP[6]
    p = p * t + _EXP[5]
    p = p * t + _EXP[4]
    p = p * t + _EXP[3]
    p = p * t + _EXP[2]
    p = p * t + _EXP[1]
    p = p * t + _EXP[0]
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    return p * p


@frugal_kernel
def half_to_the(power: float, numbers: Floats, bits: NDArray[np.int64], i: int) -> float:
    """2^-power for a power of at least 0 within 1e-12 of it, without branches; e^-40 for all larger powers.

    Args:
        power: at least 0.
        numbers: (n,) scratch: compiled loops over `i` keep it in vector registers.
        bits: the same memory as `numbers`, seen as integers.
        i: index of the number that is used up.
    """
    power = min(power, _MOST_HALVINGS)
    numbers[i] = power + _TO_WHOLE
    halvings = bits[i] << _EXPONENT_BITS
    t = power - (numbers[i] - _TO_WHOLE)
    p = _HALVES[8]
    p = p * t + _HALVES[7]
    p = p * t + _HALVES[6]
    p = p * t + _HALVES[5]
    p = p * t + _HALVES[4]
    p = p * t + _HALVES[3]
    p = p * t + _HALVES[2]
    p = p * t + _HALVES[1]
    numbers[i] = p * t + _HALVES[0]
    bits[i] = bits[i] - halvings
    halved: float = numbers[i]
    return halved


@frugal_kernel
def bound_of_half_to_the(power: float, numbers: Floats, bits: NDArray[np.int64], i: int) -> float:
    """Upper bound of `half_to_the`, at most 0.02 % above it, with fewer operations; its arguments are the same."""
    power = min(power, _MOST_HALVINGS)
    numbers[i] = power + _TO_WHOLE
    halvings = bits[i] << _EXPONENT_BITS
    t = power - (numbers[i] - _TO_WHOLE)
    p = _HALVES_BOUND[3]
    p = p * t + _HALVES_BOUND[2]
    p = p * t + _HALVES_BOUND[1]
    numbers[i] = p * t + _HALVES_BOUND[0]
    bits[i] = bits[i] - halvings
    halved: float = numbers[i]
    return halved


@sum_kernel
def take_logarithms(values: Floats, bits: NDArray[np.int64]) -> None:
    """Replace `values` (k,), at least 0, by their natural logarithms; a number below 2^-1022 by -inf.

    `bits` is scratch, of at least as many numbers.
    """
    whole = values.view(np.int64)
    mantissas = bits.view(np.float64)
    for i in range(len(values)):
        bits[i] = (whole[i] & _MANTISSA) | _ONE
    for i in range(len(values)):
        exponent = float((whole[i] >> _EXPONENT_BITS) - _BIAS)
        m = mantissas[i]
        large = m > _SQRT_2
        m = 0.5 * m if large else m
        exponent = exponent + 1.0 if large else exponent
        s = (m - 1.0) / (m + 1.0)
        u = s * s
        p = 1.0 / 19.0
        p = p * u + 1.0 / 17.0
        p = p * u + 1.0 / 15.0
        p = p * u + 1.0 / 13.0
        p = p * u + 1.0 / 11.0
        p = p * u + 1.0 / 9.0
        p = p * u + 1.0 / 7.0
        p = p * u + 1.0 / 5.0
        p = p * u + 1.0 / 3.0
        log = exponent * _LN_2 + (2.0 * s + 2.0 * s * u * p)
        values[i] = log if values[i] >= _LEAST_NORMAL else -math.inf
