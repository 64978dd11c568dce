"""Values of looks in a recorded experiment, by the formulas and by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.voa_core.worlds import lidar_of
from voa_core.errors import InvalidInput, UnknownName
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.recorded import RecordedRanges, scenario_of_recorded, value_recorded_looks
from voa_core.rules.registry import rule_of
from voa_core.scenario import Scenario

LIDAR = replace(lidar_of(2), range_min=0.4)
TABLE = GraspTable.of_probabilities(["G", "H"], [[1.0, 0.0], [0.0, 0.6]], 2)
PREDICTED: list[list[float | None]] = [[0.5, None], [0.3, 0.5]]


def scenario_with(rule: str = "margin", predicted: RecordedRanges = PREDICTED) -> Scenario:
    return scenario_of_recorded(["A", "B"], TABLE, LIDAR, rule_of(rule, LIDAR), {"Q": predicted})


def test_a_look_that_separates_the_poses_has_the_value_of_certainty() -> None:
    look = value_recorded_looks(scenario_with(), {"Q": [[0.501, None], [0.299, 0.5]]})["Q"]
    assert look.voa == look.aecd == pytest.approx(0.5 * 1.0 + 0.5 * 0.6 - 0.5)
    assert [done.belief.p.tolist() for done in look.updates] == [[1.0, 0.0], [0.0, 1.0]]


def test_the_executed_value_is_that_of_the_measured_scans_alone() -> None:
    look = value_recorded_looks(scenario_with(), {"Q": [[0.3, 0.5], [0.3, 0.5]]})["Q"]
    assert look.voa == pytest.approx(0.3)
    assert look.aecd == pytest.approx(0.6 - 0.5)


def test_ranges_below_the_limit_of_the_lidar_count() -> None:
    (_, near) = value_recorded_looks(scenario_with(), {"Q": PREDICTED})["Q"].updates
    assert near.accepted
    assert near.belief.p.tolist() == [0.0, 1.0]


def test_none_and_infinity_are_no_returns_and_nan_is_missing() -> None:
    scenario = scenario_with("exponential", np.array([[0.5, math.inf], [0.3, 0.5]]))
    by_none, by_infinity, by_nan = (
        value_recorded_looks(scenario, {"Q": [[0.5, value], [0.3, 0.5]]})["Q"].updates[0]
        for value in (None, math.inf, math.nan)
    )
    assert by_none.belief.p.tolist() == by_infinity.belief.p.tolist()
    # Without its second beam the scan fits pose B better than it did.
    assert by_nan.belief.p[1] > by_none.belief.p[1]


def test_a_belief_replaces_the_prior() -> None:
    look = value_recorded_looks(scenario_with(), {"Q": PREDICTED}, Belief.of([1.0, 0.0]))["Q"]
    assert look.voa == 0.0


def test_ranges_of_another_shape_are_refused() -> None:
    with pytest.raises(
        InvalidInput, match=r"predicted of 'Q': expected 2 poses of 2 beams, got 1 poses of \[3\] beams"
    ):
        scenario_with(predicted=[[0.5, None, 0.5]])
    with pytest.raises(InvalidInput, match="measured of 'Q'"):
        value_recorded_looks(scenario_with(), {"Q": [[0.5, None], [0.5]]})


def test_a_sensor_without_predictions_is_refused() -> None:
    with pytest.raises(UnknownName, match="there is no sensor 'R'"):
        value_recorded_looks(scenario_with(), {"R": PREDICTED})
