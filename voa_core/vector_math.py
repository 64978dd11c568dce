"""Exponentials and logarithms in loops that run in vector registers, which calls of a library would not."""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import sum_kernel

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
_BOUND = (0.7316196289466417, 0.7315974061946907, 0.365804779553189, 0.12268190872762266, 0.030608240718068558)

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


@sum_kernel
def bound_of_exp(x: float) -> float:
    """Upper bound of exp(x) for x <= 0, at most 0.1 % above it, with fewer operations; e^-40 for all x below -40."""
    t = max(x, LOWEST) * _SHARE + _MIDDLE
    p = _BOUND[4]
    p = p * t + _BOUND[3]
    p = p * t + _BOUND[2]
    p = p * t + _BOUND[1]
    p = p * t + _BOUND[0]
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    return p * p


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
