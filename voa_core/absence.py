"""The probability that the object lies at none of the listed poses, as odds in logarithms.

Logarithms keep what a probability cannot: after a hundred scans of an empty table the object can still be put there.
"""

import math

from voa_core.checks import number


def log_odds_of(absent: float) -> float:
    """Logarithm of the odds of a probability above 0 and below 1; raises InvalidInput for another."""
    absent = number("absent", absent, above=0.0, below=1.0)
    return math.log(absent) - math.log1p(-absent)


def probability_of(log_odds: float) -> float:
    """Probability from the logarithm of its odds, which may be infinite."""
    if log_odds >= 0.0:
        return 1.0 / (1.0 + math.exp(-log_odds))
    return math.exp(log_odds) / (1.0 + math.exp(log_odds))


def updated_log_odds(log_odds: float, log_absent: float, log_evidence: float) -> float | None:
    """Update the odds of absence by a scan: absent' = absent w_0 / (absent w_0 + (1 - absent) exp(log_evidence)).

    Args:
        log_odds: before the scan.
        log_absent: ln w_0, of a table without the object.
        log_evidence: ln of the scan's weight under the belief over the poses.

    Returns:
        The logarithm of the odds after it; None where both weights are 0, so that nothing explains the scan.
    """
    if log_absent == log_evidence == -math.inf:
        return None
    if math.isinf(log_odds):
        return log_odds
    return log_odds + log_absent - log_evidence
