"""Exponentials and logarithms in loops that run in vector registers, which calls of a library would not."""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import frugal_kernel, kernel, sum_kernel

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
# 2^-t as a polynomial in t for |t| <= 1/2, by Chebyshev interpolation with a node at 0 (relative error: 3e-16).
_EXACT_HALVES = (
    1.0,
    -0.69314718055995,
    0.24022650695910097,
    -0.05550410866444772,
    0.009618129107606888,
    -0.0013333558230164974,
    0.0001540353044173605,
    -1.5252657260200837e-05,
    1.321544258792169e-06,
    -1.0208690299958306e-07,
    7.072585949269223e-09,
)
# 2^-t in the same way, in float32 (relative error: 3e-9; of the rounded coefficients, 3e-8).
_FLOAT32_HALVES = tuple(
    np.float32(each)
    for each in (
        1.0,
        -0.6931472067028326,
        0.24022650922288757,
        -0.05550327226670302,
        0.009618056678524637,
        -0.0013400428177615838,
        0.0001546144469856913,
    )
)
_MOST_FLOAT32_HALVINGS = np.float32(125.0)  # its power of a half is above the smallest normal float32
_TO_WHOLE_FLOAT32, _NONE_FLOAT32 = np.float32(1.5 * 2.0**23), np.float32(0.0)
_EXPONENT_BITS_FLOAT32 = np.int32(23)
_MOST_EXACT_HALVINGS = 1010.0  # 2^-1010 is about e^-700: less is not worth a float64's last exponents
_MOST_HALVINGS = 1000.0  # its power of a half is well above the smallest normal float64
_TO_WHOLE = 1.5 * 2.0**52  # a float64 that is added to this is rounded, and its whole part fills the lowest bits
HALVING_WIDTH = math.sqrt(0.5 * math.log2(math.e))
"""Factor h with which 2^-(h x)^2 = exp(-x^2 / 2)."""

_EXPONENT_BITS, _BIAS = 52, 1023
_MANTISSA, _ONE = (1 << 52) - 1, 1023 << 52
_LN_2, _LOG2_E, _SQRT_2 = math.log(2.0), math.log2(math.e), math.sqrt(2.0)
_LEAST_NORMAL = 2.0**-1022
_AT_ONCE = 512  # numbers: their scratch stays in the first-level cache


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
    """2^-power for a power of at least 0 within 1e-12 of it, without branches; 2^-1000 for all above 1000.

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


@frugal_kernel
def exact_half_to_the(power: float, numbers: Floats, bits: NDArray[np.int64], i: int) -> float:
    """2^-power for a power of at least 0 within 1e-15 of it, without branches; 0 for a power above 1010.

    NaN remains NaN. The arguments are those of `half_to_the`. The polynomial is summed in pairs: a processor works on
    several of them at a time.
    """
    within = _MOST_EXACT_HALVINGS if power > _MOST_EXACT_HALVINGS else power
    numbers[i] = within + _TO_WHOLE
    halvings = bits[i] << _EXPONENT_BITS
    t = within - (numbers[i] - _TO_WHOLE)
    u = t * t
    v = u * u
    lowest = (_EXACT_HALVES[3] * t + _EXACT_HALVES[2]) * u + (_EXACT_HALVES[1] * t + _EXACT_HALVES[0])
    middle = (_EXACT_HALVES[7] * t + _EXACT_HALVES[6]) * u + (_EXACT_HALVES[5] * t + _EXACT_HALVES[4])
    highest = _EXACT_HALVES[10] * u + (_EXACT_HALVES[9] * t + _EXACT_HALVES[8])
    numbers[i] = (highest * v + middle) * v + lowest
    bits[i] = bits[i] - halvings
    return 0.0 if power > _MOST_EXACT_HALVINGS else numbers[i]


@frugal_kernel
def half_to_the_float32(power: np.float32, numbers: NDArray[np.float32], bits: NDArray[np.int32], i: int) -> np.float32:
    """2^-power in float32 for a power of at least 0 within 3e-7 of it, without branches; 0 for a power above 125.

    The arguments are those of `half_to_the`, in 32 bits.
    """
    within = min(power, _MOST_FLOAT32_HALVINGS)
    numbers[i] = within + _TO_WHOLE_FLOAT32
    halvings = bits[i] << _EXPONENT_BITS_FLOAT32
    t = within - (numbers[i] - _TO_WHOLE_FLOAT32)
    u = t * t
    lowest = (_FLOAT32_HALVES[3] * t + _FLOAT32_HALVES[2]) * u + (_FLOAT32_HALVES[1] * t + _FLOAT32_HALVES[0])
    highest = _FLOAT32_HALVES[6] * u + (_FLOAT32_HALVES[5] * t + _FLOAT32_HALVES[4])
    numbers[i] = highest * (u * u) + lowest
    bits[i] = bits[i] - halvings
    return _NONE_FLOAT32 if power > _MOST_FLOAT32_HALVINGS else numbers[i]


@kernel
def take_exponentials(numbers: Floats) -> None:
    """Replace numbers x of at most 0, (k,), by e^x within (1e-15 - 3e-16 x) e^x; below -700 by 0. NaN remains NaN."""
    bits = np.zeros(_AT_ONCE, dtype=np.int64)
    for first in range(0, len(numbers), _AT_ONCE):
        _take_exponentials(numbers[first : first + _AT_ONCE], bits)


@frugal_kernel
def _take_exponentials(values: Floats, bits: NDArray[np.int64]) -> None:
    numbers = bits.view(np.float64)
    for i in range(len(values)):
        values[i] = exact_half_to_the(-_LOG2_E * values[i], numbers, bits, i)


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
