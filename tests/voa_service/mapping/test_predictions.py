"""Predictions as data and as messages: complete for every sensor and pose, or refused with what is absent."""

from typing import Any

import pytest

from tests.support.scenarios import core_scenario
from tests.support.serving import PREDICTIONS, changed, data_scenario
from voa_core.errors import InvalidInput, UnknownName
from voa_core.scans import NO_RETURN
from voa_service.mapping.predictions import predicted_ranges, predictions_message, stacked

NAMES = (["Q1", "Q2"], ["P1", "P2", "P3"])


def test_data_become_arrays_of_poses_by_beams_in_the_order_of_the_scenario() -> None:
    backwards = {sensor: dict(reversed(of_pose.items())) for sensor, of_pose in PREDICTIONS.items()}
    data = predicted_ranges(backwards, *NAMES)
    assert data["Q1"].tolist() == [
        [0.5, 0.5, NO_RETURN, 1.0],
        [0.6, NO_RETURN, NO_RETURN, 1.0],
        [0.9, 0.5, 0.5, NO_RETURN],
    ]
    assert list(data) == ["Q1", "Q2"]


@pytest.mark.parametrize(
    ("where", "value", "error", "words"),
    [
        ("Q3", PREDICTIONS["Q1"], UnknownName, "no sensor 'Q3'"),
        ("Q1.P4", [0.5] * 4, UnknownName, "no pose 'P4'"),
        ("Q1", {"P1": [0.5]}, InvalidInput, "predictions.Q1: expected ranges for every pose, got none for 'P2'"),
        ("Q1.P1", [0.5], InvalidInput, r"predictions.Q1: expected equally many beams for every pose, got \[1, 4\]"),
    ],
)
def test_incomplete_data_are_refused(where: str, value: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        predicted_ranges(changed(PREDICTIONS, where, value), *NAMES)


def test_a_message_has_a_null_for_each_no_return() -> None:
    scenario = core_scenario()
    message = predictions_message(scenario, scenario.sensors[:1])
    assert (message.sensors, message.poses) == (["Q1"], list(scenario.poses.names))
    assert message.ranges == [list(PREDICTIONS["Q1"].values())]


def test_rows_are_stacked_in_order() -> None:
    assert stacked([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]).tolist() == [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"predictions": None}, "no predictions of 'Q1' and no object"),
        ({"predictions": {"Q1": PREDICTIONS["Q1"]}}, "no predictions of 'Q2' and no object"),
        (
            {"lidar": data_scenario()["lidar"] | {"beams": 5}},
            r"predictions.Q1: expected 5 beams \(lidar.beams\), got 4",
        ),
    ],
)
def test_a_scenario_without_a_mesh_needs_predictions_of_every_sensor(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidInput, match=words):
        core_scenario(**changes)
