"""Values and conversions that the tests of the contract over HTTP share."""

import math

GOOD = [0.52, 0.5, None, 1.0]
UNIFORM = [1.0 / 3.0] * 3
BELIEF = [0.2, 0.3, 0.5]


def scans(session: str) -> str:
    """Path of the scans of a session."""
    return f"/v1/sessions/{session}/scans"


def as_twin(predicted: list[float | None]) -> list[float]:
    """Predicted ranges as the brute-force twin takes them: infinity for a no-return."""
    return [math.inf if value is None else value for value in predicted]


def measured(ranges: list[float | None]) -> list[float]:
    """Measured ranges as the brute-force twin takes them: NaN for a missing beam."""
    return [math.nan if value is None else value for value in ranges]
