"""Statuses of the HTTP interface, and the messages of its responses."""

import pytest
from pydantic import BaseModel

from tests.contract.values import GOOD, UNIFORM, scans
from tests.support.serving import POSES, PREDICTIONS, Json, Service, data_scenario, scan_of
from voa_msgs.lidars import LidarPresets
from voa_msgs.objects import MeshFile, Object, ObjectPage, StablePoses
from voa_msgs.rankings import RankedGrasps, Ranking
from voa_msgs.scenarios import Predictions, Scenario, ScenarioPage
from voa_msgs.sessions import HistoryPage, Session, SessionPage, UpdatedEstimate


def test_creating_is_201_the_same_content_again_200_deleting_204_and_then_404(service: Service) -> None:
    body = data_scenario(name="created once")
    first, again = (service.http.post("/v1/scenarios", json=body) for _ in range(2))
    assert (first.status_code, again.status_code) == (201, 200)
    assert first.json() == again.json()
    opened = service.http.post("/v1/sessions", json={"scenario": first.json()["id"]})
    assert opened.status_code == 201
    path = f"/v1/sessions/{opened.json()['id']}"
    assert service.http.get(path).status_code == 200
    gone = service.http.delete(path)
    assert (gone.status_code, gone.content) == (204, b"")
    assert service.http.get(path).status_code == 404
    assert service.http.delete(path).status_code == 404


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("/v1/objects", ObjectPage),
        ("/v1/lidars", LidarPresets),
        ("/v1/scenarios", ScenarioPage),
        ("/v1/scenarios/{scenario}", Scenario),
        ("/v1/objects/{object}", Object),
        ("/v1/objects/{object}/stable-poses", StablePoses),
        ("/v1/objects/{object}/mesh", MeshFile),
        ("/v1/objects/{object}/mesh?most_faces=100", MeshFile),
        ("/v1/sessions", SessionPage),
        ("/v1/sessions/{session}", Session),
        ("/v1/sessions/{session}/voa", Ranking),
        ("/v1/sessions/{session}/voa?definition=executed&outcomes=true", Ranking),
        ("/v1/sessions/{session}/grasps", RankedGrasps),
        ("/v1/sessions/{session}/history", HistoryPage),
        ("/v1/sessions/{session}/history?beliefs=true", HistoryPage),
    ],
)
def test_an_answer_is_its_message(service: Service, mesh_id: str, path: str, message: type[BaseModel]) -> None:
    scenario = service.get(f"/v1/scenarios/{mesh_id}")
    session = service.open(mesh_id)
    service.post(scans(session), scan_of([0.28] * 360, "E"))
    answer = service.http.get(path.format(scenario=mesh_id, object=scenario["object"], session=session))
    assert answer.headers["content-type"] == "application/json"
    message.model_validate_json(answer.content)


@pytest.mark.parametrize(
    ("path", "body", "message"),
    [
        ("/v1/updates", {"belief": UNIFORM} | scan_of(GOOD), UpdatedEstimate),
        ("/v1/rankings", {"belief": UNIFORM, "outcomes": True}, Ranking),
    ],
)
def test_a_stateless_answer_is_its_message_with_version_null(
    service: Service, data_id: str, path: str, body: Json, message: type[BaseModel]
) -> None:
    before = service.stored()
    answer = service.post(path, body | {"scenario": data_id})
    message.model_validate(answer, strict=False)
    assert answer["version"] is None
    assert service.stored() == before


def test_predictions_are_their_message_with_or_without_a_body(service: Service, data_id: str) -> None:
    path = f"/v1/scenarios/{data_id}/predictions"
    answers = [service.http.post(path), service.http.post(path, json={}), service.http.post(path, json=None)]
    assert [answer.status_code for answer in answers] == [200, 200, 200]
    predicted = [Predictions.model_validate_json(answer.content) for answer in answers]
    assert predicted[0] == predicted[1] == predicted[2]
    assert (predicted[0].sensors, predicted[0].poses) == (["Q1", "Q2"], list(POSES))
    assert predicted[0].ranges == [[PREDICTIONS[sensor][pose] for pose in POSES] for sensor in ("Q1", "Q2")]


def test_a_request_id_is_given_back_if_it_is_sane_and_made_up_if_not(service: Service) -> None:
    for offered, kept in (("robot-7:42", True), ("x" * 65, False), ("a b", False), ("", False)):
        answer = service.http.get("/v1/lidars", headers={"x-request-id": offered})
        assert (answer.headers["x-request-id"] == offered) is kept
        assert answer.headers["x-request-id"]


def test_lists_go_on_where_the_page_before_ended(service: Service, data_id: str) -> None:
    opened = [service.open(data_id) for _ in range(5)]
    listed: list[str] = []
    query = "limit=2"
    while query:
        page = service.get(f"/v1/sessions?{query}")
        assert len(page["items"]) <= 2
        listed += [item["id"] for item in page["items"]]
        query = f"limit=2&after={page['next']}" if page["next"] else ""
    assert listed[-5:] == opened
    assert len(set(listed)) == len(listed)
    assert "belief" not in service.get("/v1/sessions")["items"][0]
