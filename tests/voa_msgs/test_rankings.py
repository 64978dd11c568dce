"""Requests for rankings and their responses: defaults, bounds, and the two recommendations."""

from typing import Any

import pytest
from pydantic import ValidationError

from voa_msgs.rankings import GraspNow, Look, Ranking, RankingRequest, VoaRequest

GRASP = {"action": "grasp", "grasp": None, "expected_score": 0.0}
LOOK = {"action": "look", "sensor": "Q1", "net_value": 0.25, "then": None}
PAIR = LOOK | {"then": "Q2"}
RANKING: dict[str, Any] = {
    "version": None,
    "definition": "posterior",
    "method": "exact",
    "precision": "float64",
    "expected_score_before": 0.5,
    "best_grasp_before": "G1",
    "ranking": [],
}


def test_a_request_ranks_all_sensors_and_grasps_and_leaves_the_rest_to_the_scenario() -> None:
    assert VoaRequest().model_dump() == {
        "sensors": None,
        "scans": None,
        "samples": None,
        "method": None,
        "definition": None,
        "sensor_std": None,
        "lookahead": 2,
        "from": None,
        "cost_per_m": 0.0,
        "pending": None,
        "grasps": None,
        "sensor_belief": None,
        "min_gain": None,
        "outcomes": False,
    }


def test_a_departure_is_read_by_its_name_on_the_wire_and_written_so() -> None:
    for given in ("Q1", {"x": 0.5, "y": -1.0}):
        request = VoaRequest.model_validate({"from": given, "cost_per_m": 0.1})
        assert request.model_dump(exclude_defaults=True) == {"from": given, "cost_per_m": 0.1}
    assert VoaRequest(from_="Q1").from_ == "Q1"


@pytest.mark.parametrize(
    "wrong",
    [
        {"sensors": []},
        {"grasps": []},
        {"definition": "aecd"},
        {"min_gain": 1.1},
        {"min_gain": -0.1},
        {"outcomes": 1},
        {"scans": "sampled"},
        {"samples": 0},
        {"samples": 4_097},
        {"lookahead": 0},
        {"lookahead": 3},
        {"cost_per_m": -0.1},
        {"from": {"x": 0.0}},
        {"from": ""},
        {"sensor_std": {"xy_m": -0.1, "yaw_rad": 0.0}},
        {"pending": ["Q1"] * 65},
    ],
)
def test_a_request_with_another_value_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        VoaRequest.model_validate(wrong)


def test_a_request_without_a_session_must_state_its_belief_or_null() -> None:
    assert RankingRequest(scenario="S", belief=None).belief is None
    with pytest.raises(ValidationError, match="belief"):
        RankingRequest.model_validate({"scenario": "S"})


@pytest.mark.parametrize(("recommendation", "kind"), [(GRASP, GraspNow), (LOOK, Look), (PAIR, Look)])
def test_the_action_decides_on_the_kind_of_a_recommendation(recommendation: dict[str, Any], kind: type) -> None:
    ranking = Ranking.model_validate(RANKING | {"recommendation": recommendation})
    assert type(ranking.recommendation) is kind
    assert ranking.recommendation.model_dump() == recommendation


@pytest.mark.parametrize("recommendation", [{"action": "wait"}, GRASP | {"sensor": "Q1"}, {"action": "look"}])
def test_a_recommendation_of_another_form_is_refused(recommendation: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        Ranking.model_validate(RANKING | {"recommendation": recommendation})
