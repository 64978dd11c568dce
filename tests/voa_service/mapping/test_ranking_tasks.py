"""Requests to rank looks: every default depends on the scenario, the request and the session's looks."""

from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import pytest

from tests.support.places import spread_scenario
from tests.support.serving import Json, Service, box_obj, data_scenario, mesh_scenario, serving
from voa_core.errors import InvalidInput, UnknownName
from voa_core.lidars import SensorUncertainty
from voa_core.looks import Driving
from voa_core.places import Viewpoint
from voa_msgs.looks import LookAnnouncement
from voa_msgs.rankings import VoaRequest
from voa_service.mapping.looks import LookRecord, PlaceRecord
from voa_service.mapping.models import Model
from voa_service.mapping.ranking_tasks import RankingTask, SessionLooks, ranking_task
from voa_service.mapping.under_way import announced

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
STD: Json = {"xy_m": 0.01, "yaw_rad": 0.02}
OWN_STD = SensorUncertainty(0.03, 0.04)


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Model]]:
    """Scenarios with data alone, with a mesh, and with a mesh that spreads."""
    with serving(tmp_path_factory.mktemp("models")) as service:
        ids = {
            "data": service.create(data_scenario()),
            "mesh": service.create(mesh_scenario(service.upload(box_obj()))),
            "spread": spread_scenario(service),
        }
        yield {name: model_of(service, id_) for name, id_ in ids.items()}


def model_of(service: Service, id_: str) -> Model:
    model = service.inside.sessions.models.get(id_)
    assert model is not None
    return model


def task(model: Model, looks: SessionLooks | None = None, **fields: Any) -> RankingTask:
    return ranking_task(model, None, VoaRequest.model_validate(fields), None, looks or SessionLooks())


@pytest.mark.parametrize(
    ("scenario", "fields", "std", "scans"),
    [
        ("data", {}, None, "exact"),
        ("mesh", {}, None, "exact"),
        ("spread", {}, None, "simulated"),
        ("mesh", {"sensor_std": STD}, None, "simulated"),
        ("mesh", {}, OWN_STD, "simulated"),
        ("mesh", {"sensor_std": {"xy_m": 0.0, "yaw_rad": 0.0}}, OWN_STD, "exact"),
        ("data", {"sensor_std": STD}, OWN_STD, "exact"),
        ("data", {"scans": "simulated"}, None, "simulated"),
        ("spread", {"scans": "exact"}, OWN_STD, "exact"),
    ],
)
def test_scans_are_simulated_where_there_are_displacements(
    models: dict[str, Model], scenario: str, fields: Json, std: SensorUncertainty | None, scans: str
) -> None:
    own = task(models[scenario], SessionLooks(record=LookRecord(std=std)), **fields)
    assert own.scans == scans
    assert own.definition == {"exact": "posterior", "simulated": "executed"}[scans]
    assert own.samples == (None if scans == "exact" else {"data": 86, "mesh": 128, "spread": 128}[scenario])


@pytest.mark.parametrize("definition", ["posterior", "executed"])
@pytest.mark.parametrize("scans", ["exact", "simulated"])
def test_a_stated_definition_holds_for_both_kinds_of_scans(
    models: dict[str, Model], scans: str, definition: str
) -> None:
    assert task(models["spread"], scans=scans, definition=definition).definition == definition


def test_the_std_is_that_of_the_request_else_of_the_sessions_last_sensor_pose(models: dict[str, Model]) -> None:
    looks = SessionLooks(record=LookRecord(std=OWN_STD))
    assert task(models["mesh"], looks).std == OWN_STD
    assert task(models["mesh"], looks, sensor_std=STD).std == SensorUncertainty(0.01, 0.02)
    assert task(models["mesh"], looks, sensor_std={"xy_m": 0.0, "yaw_rad": 0.0}).std is None
    assert task(models["mesh"]).std is None


def test_samples_are_those_of_the_request(models: dict[str, Model]) -> None:
    assert task(models["spread"], samples=7).samples == 7
    assert task(models["spread"], samples=7).weights_of_place == 7 * 2 * 2
    assert task(models["spread"], scans="exact", samples=7).samples is None
    assert task(models["spread"], scans="exact").weights_of_place == 4


def test_pairs_may_be_valued_of_few_places(models: dict[str, Model], monkeypatch: pytest.MonkeyPatch) -> None:
    assert task(models["mesh"], lookahead=2).may_rank_pairs
    assert not task(models["mesh"], lookahead=1).may_rank_pairs
    monkeypatch.setattr("voa_service.mapping.ranking_tasks.MOST_PLACES_IN_PAIRS", 0)
    assert not task(models["mesh"], lookahead=2).may_rank_pairs


def test_announced_looks_are_pending_unless_the_request_says_otherwise(models: dict[str, Model]) -> None:
    free = {"x": 0.5, "y": 0.1, "yaw_rad": 3.0, "std": STD}
    places: list[Json] = [{"sensor": "E"}, {"sensor_pose": free}, {"sensor": "E"}]
    under_way = tuple(announced(str(i), LookAnnouncement.model_validate(place), NOON) for i, place in enumerate(places))
    looks = SessionLooks(under_way=under_way)
    assert [(sensor.name, sensor.x) for sensor in task(models["spread"], looks).pending] == [
        ("E", 0.3),
        ("sensor_pose", 0.5),
        ("E", 0.3),
    ]
    assert task(models["spread"], looks, pending=[]).pending == ()
    assert [sensor.name for sensor in task(models["spread"], looks, pending=["N", "N"]).pending] == ["N", "N"]
    with pytest.raises(UnknownName):
        task(models["spread"], pending=["W"])


@pytest.mark.parametrize(("start", "x", "y"), [("N", 0.0, 0.3), ({"x": 1.0, "y": -2.0}, 1.0, -2.0), ("far", 9.0, 0.0)])
def test_a_drive_begins_at_a_listed_or_ranked_sensor_or_at_a_point(
    models: dict[str, Model], start: Any, x: float, y: float
) -> None:
    sensors = ["E", {"name": "far", "x": 9.0, "y": 0.0, "yaw_rad": 0.0}]
    own = task(models["mesh"], sensors=sensors, cost_per_m=0.1, from_=start)
    assert own.driving == Driving(x, y, 0.1)


def test_a_drive_from_nowhere_is_refused(models: dict[str, Model]) -> None:
    assert task(models["mesh"]).driving is None
    assert task(models["mesh"], from_="N").driving == Driving(0.0, 0.3, 0.0)
    with pytest.raises(InvalidInput, match="from"):
        task(models["mesh"], cost_per_m=0.1)
    with pytest.raises(UnknownName) as refused:
        task(models["mesh"], cost_per_m=0.1, from_="W")
    assert refused.value.known == ["E", "N"]


def test_the_least_gain_is_that_of_the_request_else_of_the_scenario(models: dict[str, Model]) -> None:
    assert (task(models["mesh"]).min_gain, task(models["mesh"], min_gain=0.0).min_gain) == (0.005, 0.0)


def test_looks_taken_are_counted_at_the_place_of_each_candidate(models: dict[str, Model]) -> None:
    east, near = Viewpoint("E", 0.3, 0.0, 3.0, None), Viewpoint(None, 0.5, 0.1, 3.0, 0.02)
    record = LookRecord((PlaceRecord(east, 2, 64), PlaceRecord(near, 3, 64)))
    candidate = {"x": 0.51, "y": 0.1, "yaw_rad": 3.01}
    own = task(models["spread"], SessionLooks(record=record), sensors=["E", "N", candidate])
    assert [own.looks_taken(sensor) for sensor in own.sensors] == [2, 0, 3]


def test_the_outcomes_of_a_look_are_counted_by_the_sensor_agent_s_belief(models: dict[str, Model]) -> None:
    own = ranking_task(models["data"], [0.5, 0.5, 0.0], VoaRequest(), None)
    other = ranking_task(models["data"], [0.5, 0.5, 0.0], VoaRequest(sensor_belief=[0.0, 0.0, 1.0]), None)
    assert (own.possible_poses, other.possible_poses) == (2, 1)
    assert own.outer is own.belief
    assert other.outer.p.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("fields", "error", "match"),
    [
        ({"grasps": ["G9"]}, UnknownName, "G9"),
        ({"sensors": ["W"]}, UnknownName, "W"),
        ({"sensor_belief": [1.0]}, InvalidInput, "sensor_belief"),
    ],
)
def test_requests_that_do_not_fit_the_scenario_are_refused(
    models: dict[str, Model], fields: Json, error: type[Exception], match: str
) -> None:
    with pytest.raises(error, match=match):
        task(models["mesh"], **fields)
