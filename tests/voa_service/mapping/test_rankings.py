"""Rankings as messages: looks by net value with a recommendation, and grasps by expected score."""

from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import Json, data_scenario, serving
from voa_core.errors import UnknownName
from voa_core.filtering import Belief
from voa_core.weights import wanted
from voa_msgs.rankings import Ranking, VoaRequest
from voa_service.mapping.models import Model
from voa_service.mapping.ranking_tasks import RankingTask, ranking_task
from voa_service.mapping.ranking_weights import Weighing
from voa_service.mapping.rankings import ranked_grasps_message, ranking_message

GIVEN = [0.5, 0.5, 0.0]
EXACT: Json = {"rule": "margin", "margin_m": 0.01, "no_return_m": 1.0}


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A scenario whose sensor Q1 distinguishes all poses, and Q2 none with a probability above 0."""
    with serving(tmp_path_factory.mktemp("models")) as service:
        yield service.inside.sessions.models.get(service.create(data_scenario(update=EXACT)))


def ranked(task: RankingTask) -> Ranking:
    return ranking_message(task, Weighing("float64", True, wanted), map)


def test_looks_are_ranked_by_net_value_and_the_first_is_recommended(model: Model) -> None:
    ranking = ranked(ranking_task(model, GIVEN, VoaRequest(outcomes=True), None))
    first, second = ranking.ranking
    assert (first.sensor, second.sensor) == ("Q1", "Q2")
    assert second.voa == pytest.approx(0.0, abs=1e-12)
    # Before: G1 succeeds with (0.9 + 0.1) / 2; after the look: G1 at P1, G2 at P2.
    assert ranking.best_grasp_before == "G1"
    assert ranking.expected_score_before == pytest.approx(0.5)
    assert first.voa == pytest.approx(0.85 - 0.5)
    assert first.expected_score_after == pytest.approx(0.85)
    assert [(outcome.pose, outcome.best_grasp) for outcome in first.outcomes or []] == [("P1", "G1"), ("P2", "G2")]
    assert ranking.recommendation.model_dump() == {
        "action": "look",
        "sensor": "Q1",
        "net_value": first.net_value,
        "then": None,
    }
    assert (first.ties_with_first, second.ties_with_first, ranking.version) == (True, False, None)


def test_a_grasp_is_recommended_where_no_look_gains_enough(model: Model) -> None:
    ranking = ranked(ranking_task(model, GIVEN, VoaRequest(min_gain=0.5), None))
    assert ranking.recommendation.model_dump() == {"action": "grasp", "grasp": "G1", "expected_score": 0.5}
    assert all(look.outcomes is None for look in ranking.ranking)


def test_only_the_requested_looks_and_grasps_take_part(model: Model) -> None:
    ranking = ranked(ranking_task(model, GIVEN, VoaRequest(sensors=["Q2"], grasps=["G2"]), None))
    assert [look.sensor for look in ranking.ranking] == ["Q2"]
    assert ranking.best_grasp_before == "G2"
    assert ranking.expected_score_before == pytest.approx(0.45)


def test_grasps_are_ranked_by_expected_score_and_named_alone_or_with_commas(model: Model) -> None:
    belief = Belief.of([0.0, 1.0, 0.0])
    every = ranked_grasps_message(model.scenario, belief, None, 7)
    assert [(grasp.name, grasp.expected_score) for grasp in every.grasps] == [("G2", 0.8), ("G1", 0.1)]
    assert every.version == 7
    assert ranked_grasps_message(model.scenario, belief, ["G1,G2"], 7) == every
    assert [grasp.name for grasp in ranked_grasps_message(model.scenario, belief, ["G1"], 7).grasps] == ["G1"]


def test_a_name_with_a_comma_is_not_split(tmp_path: Path) -> None:
    body = data_scenario(grasps=[{"name": "a,b"}, {"name": "a"}])
    with serving(tmp_path) as service:
        model = service.inside.sessions.models.get(service.create(body))
        assert model is not None
        message = ranked_grasps_message(model.scenario, Belief.uniform(3), ["a,b"], 0)
        assert [grasp.name for grasp in message.grasps] == ["a,b"]
        with pytest.raises(UnknownName):
            ranked_grasps_message(model.scenario, Belief.uniform(3), ["a,c"], 0)
