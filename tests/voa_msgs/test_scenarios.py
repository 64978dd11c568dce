"""Scenarios on the wire: two forms of scores, defaults, and the request that stores a scenario again."""

from datetime import UTC, datetime
from typing import Any

import pytest
from pydantic import ValidationError

from tests.support.serving import changed, data_scenario
from voa_msgs.scenarios import GivenScores, MeasuredScores, Scenario, ScenarioRequest
from voa_msgs.updates import BeamUpdate


def test_scores_are_probabilities_or_measured_successes() -> None:
    given = ScenarioRequest.model_validate(data_scenario())
    successes = {"attempts": 10, "successes": [[1, 2, 3], [4, 5, 6]]}
    measured = ScenarioRequest.model_validate(data_scenario(scores=successes))
    assert type(given.scores) is GivenScores
    assert measured.scores == MeasuredScores.model_validate(successes)


def test_a_scenario_is_updated_by_the_beam_rule_from_a_uniform_prior_unless_stated() -> None:
    body = data_scenario()
    del body["update"]
    request = ScenarioRequest.model_validate(body)
    assert (request.update, request.prior, request.workspace, request.min_gain) == (BeamUpdate(), None, None, 0.005)


@pytest.mark.parametrize(
    ("where", "value"),
    [
        ("name", ""),
        ("poses", []),
        ("grasps", []),
        ("sensors", []),
        ("poses.0.position", [0.0, 0.0]),
        ("poses.0.quaternion_wxyz", [1.0, 0.0, 0.0]),
        ("scores.probabilities.0.0", 1.5),
        ("scores", {"attempts": 0, "successes": [[0]]}),
        ("scores", {"attempts": 1, "probabilities": [[0.5]]}),
        ("min_gain", 1.5),
        ("predictions.Q1.P1", []),
    ],
)
def test_a_scenario_with_another_value_is_refused_at_its_place(where: str, value: Any) -> None:
    with pytest.raises(ValidationError) as error:
        ScenarioRequest.model_validate(changed(data_scenario(), where, value))
    assert str(error.value.errors()[0]["loc"][0]) == where.split(".", maxsplit=1)[0]


def test_a_stored_scenario_gives_back_its_request() -> None:
    request = ScenarioRequest.model_validate(data_scenario(min_gain=0.01, prior=[0.5, 0.25, 0.25]))
    added = {"id": "S", "created_at": datetime(2026, 1, 1, tzinfo=UTC), "warnings": []}
    stored = Scenario.model_validate(request.model_dump() | added)
    assert stored.request() == request
    assert type(stored.request()) is ScenarioRequest
