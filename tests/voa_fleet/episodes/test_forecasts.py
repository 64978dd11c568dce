"""Forecasts of looks."""

import math

import numpy as np
import pytest

from voa_fleet.episodes.forecasts import Forecast


def test_expected_entropy() -> None:
    clear, silent = np.eye(2), np.full((2, 2), 0.5)
    entropies = Forecast(np.zeros((2, 2)), np.array([clear, silent])).expected_entropies([0.5, 0.5])
    assert entropies == pytest.approx([0.0, math.log(2.0)])
    assert Forecast(np.zeros((1, 2)), np.array([silent])).expected_entropies([1.0, 0.0]) == pytest.approx([0.0])


def test_expected_beams_are_weighted_by_the_belief() -> None:
    forecast = Forecast(np.array([[4.0, 0.0], [1.0, 1.0]]), np.zeros((2, 2, 2)))
    assert forecast.expected_beams([0.25, 0.75]) == pytest.approx([1.0, 1.0])
    assert forecast.expected_beams([1.0, 0.0]) == pytest.approx([4.0, 1.0])
