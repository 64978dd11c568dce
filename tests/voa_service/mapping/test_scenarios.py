"""Scenarios from messages: defaults written out, and tables, poses and names that contradict each other refused."""

from typing import Any

import pytest

from tests.support.scenarios import core_scenario
from tests.support.serving import POSES, SCORES, data_scenario
from voa_core.errors import InvalidInput
from voa_core.workspace import Workspace
from voa_msgs.scenarios import ScenarioRequest
from voa_service.mapping.scenarios import filled_in

SENSOR = {"name": "Q1", "x": 0.0, "y": 0.0, "yaw_rad": 0.0}
UPRIGHT = {"position": [0.0, 0.0, 0.0], "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0]}


def test_every_default_of_lidar_and_rule_is_written_out_once() -> None:
    request = ScenarioRequest.model_validate(data_scenario(update={"rule": "gaussian"}))
    filled = filled_in(request, {})
    assert (filled.lidar.noise_m, filled.lidar.dropout) == (0.01, 0.05)
    assert filled.update.model_dump(exclude_none=True)["sigma_m"] == 1.0
    assert filled.update.no_return_m == request.lidar.range_max
    assert filled_in(filled, {}) == filled


def test_the_mathematics_has_the_names_and_numbers_of_the_message() -> None:
    box = {"min": [-0.5, -0.25], "max": [0.5, 0.25]}
    scenario = core_scenario(workspace=box, prior=[0.5, 0.25, 0.25], min_gain=0.125)
    assert (scenario.poses.names, scenario.table.names) == (POSES, ("G1", "G2"))
    assert scenario.table.scores.tolist() == SCORES
    assert scenario.workspace == Workspace((-0.5, -0.25), (0.5, 0.25))
    assert (scenario.prior.p.tolist(), scenario.min_gain) == ([0.5, 0.25, 0.25], 0.125)
    assert core_scenario().workspace is None


def test_measured_scores_are_successes_of_attempts() -> None:
    measured = core_scenario(scores={"attempts": 4, "successes": [[4, 2, 0], [1, 3, 4]]})
    assert measured.table.scores.tolist() == [[1.0, 0.5, 0.0], [0.25, 0.75, 1.0]]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"sensors": [SENSOR, SENSOR]}, "sensors: expected names that differ, got a name twice"),
        (
            {"scores": {"probabilities": SCORES[:1]}},
            r"one row per grasp \(2\), one entry per pose \(3\), got 1 rows of 3",
        ),
        ({"scores": {"probabilities": [[0.5] * 3, [0.5] * 2]}}, "got 2 rows of 2, 3"),
        ({"poses": [{"name": "P1"} | UPRIGHT, {"name": "P2"}, {"name": "P3"}]}, "of every pose, or of none"),
        ({"prior": [0.5, 0.5]}, "prior"),
    ],
)
def test_a_scenario_that_contradicts_itself_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidInput, match=words):
        core_scenario(**changes)
