"""Interval of a probability that is estimated from successes of attempts."""

from math import sqrt


def wilson(successes: int, attempts: int, z: float = 1.96) -> tuple[float, float]:
    """Compute Wilson's interval of a probability from k successes of n attempts (E. B. Wilson, JASA 22, 1927).

    Args:
        successes: k.
        attempts: n; of 0 attempts the interval is (0, 1).
        z: quantile of the normal distribution; 1.96 gives 95 %.

    Returns:
        Lower and upper end.
    """
    if attempts == 0:
        return 0.0, 1.0
    share, extra = successes / attempts, z * z / attempts
    middle = (share + extra / 2.0) / (1.0 + extra)
    half = z * sqrt(share * (1.0 - share) / attempts + extra / (4.0 * attempts)) / (1.0 + extra)
    return max(0.0, middle - half), min(1.0, middle + half)
