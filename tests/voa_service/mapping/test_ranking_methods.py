"""Methods of rankings: expectations over all poses, or over samples of them where there are too many."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from tests.support.serving import Json, box_obj, mesh_scenario, serving
from voa_core.errors import InvalidInput
from voa_core.lidars import SensorConfiguration
from voa_msgs.rankings import VoaRequest
from voa_service.mapping.models import Model
from voa_service.mapping.ranking_methods import MOST_EXACT_WEIGHTS, ranking_method
from voa_service.mapping.ranking_tasks import RankingTask, ranking_task


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Model]:
    with serving(tmp_path_factory.mktemp("models")) as service:
        stored = service.inside.sessions.models.get(service.create(mesh_scenario(service.upload(box_obj()))))
        assert stored is not None
        yield stored


def task(model: Model, places: int = 1, **fields: object) -> RankingTask:
    own = ranking_task(model, None, VoaRequest.model_validate(fields), None)
    return replace(own, sensors=(SensorConfiguration("a", 0.3, 0.0, 0.0),) * places)


@pytest.mark.parametrize(("fields", "large"), [
    ({}, "sampled"), ({"scans": "exact"}, "sampled"), ({"scans": "simulated", "samples": 1}, "exact"),
    ({"outcomes": True}, "exact"),
])  # fmt: skip
def test_above_320_million_weights_poses_are_sampled_where_they_can_be(model: Model, fields: Json, large: str) -> None:
    most = MOST_EXACT_WEIGHTS // task(model, **fields).weights_of_place
    assert ranking_method(task(model, most, **fields)) == "exact"
    assert ranking_method(task(model, most + 1, **fields)) == large


def test_a_stated_method_holds_at_any_size(model: Model) -> None:
    assert ranking_method(task(model, method="sampled")) == "sampled"
    assert ranking_method(task(model, MOST_EXACT_WEIGHTS, method="exact")) == "exact"
    assert ranking_method(task(model, method="exact", scans="simulated", outcomes=True)) == "exact"


@pytest.mark.parametrize(("fields", "remedy"), [
    ({"scans": "simulated"}, '`scans` = "exact"'), ({"outcomes": True}, "where `outcomes` are listed"),
])  # fmt: skip
def test_samples_of_poses_with_simulated_scans_or_outcomes_are_refused(model: Model, fields: Json, remedy: str) -> None:
    with pytest.raises(InvalidInput, match="method") as refused:
        ranking_method(task(model, method="sampled", **fields))
    assert remedy in str(refused.value)
