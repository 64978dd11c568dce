"""Prediction errors: percentiles of differences between measured and predicted ranges."""

import math

import pytest

from voa_recordings.replay.prediction_errors import percentile


@pytest.mark.parametrize(
    ("ordered", "share", "value"),
    [
        ([], 0.5, None),
        ([3.0], 0.95, 3.0),
        ([0.0, 10.0], 0.95, 9.5),
        ([1.0, 2.0, 4.0], 0.5, 2.0),
        ([1.0, 5.0], 1.0, 5.0),
    ],
)
def test_percentiles_are_linear(ordered: list[float], share: float, value: float | None) -> None:
    result = percentile(ordered, share)
    assert result == value or (result is not None and value is not None and math.isclose(result, value))
