"""Every request of the OpenAPI document has an example, and the examples work as they are, in one sequence."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from voa_msgs import examples
from voa_service import bootstrap
from voa_service.http.app import create_app
from voa_service.settings import Settings


@pytest.fixture
def http(tmp_path: Path) -> Iterator[TestClient]:
    with bootstrap.services(Settings(database_url=f"sqlite:///{tmp_path}/voa.db")) as services:
        yield TestClient(create_app(services), "http://127.0.0.1")


def test_every_json_body_has_an_example(http: TestClient) -> None:
    document = http.get("/openapi.json").json()
    bodies = [
        operation["requestBody"]["content"]["application/json"]["schema"]
        for path in document["paths"].values()
        for operation in path.values()
        if "application/json" in operation.get("requestBody", {}).get("content", {})
    ]
    assert len(bodies) == 11
    for schema in bodies:
        [reference] = [option["$ref"] for option in schema.get("anyOf", [schema]) if "$ref" in option]
        assert document["components"]["schemas"][reference.rpartition("/")[2]]["examples"]


def test_the_examples_follow_each_other(http: TestClient) -> None:
    scenario = http.post("/v1/scenarios", json=examples.SCENARIO).json()["id"]
    assert scenario == examples.SCENARIO_ID
    session = http.post("/v1/sessions", json=examples.SESSION).json()["id"]
    path = f"/v1/sessions/{session}"
    answers = [
        http.post(f"/v1/scenarios/{scenario}/predictions", json=examples.PREDICTIONS),
        http.post(f"{path}/voa", json=examples.VOA),
        http.post(f"{path}/scans", json=examples.SCAN),
        http.post(f"{path}/grasp-outcomes", json=examples.OUTCOME),
        http.put(f"{path}/belief", json=examples.BELIEF),
        http.post("/v1/updates", json=examples.UPDATE),
        http.post("/v1/rankings", json=examples.RANKING),
    ]
    assert [answer.status_code for answer in answers] == [200] * len(answers)
    assert answers[2].json()["update"]["accepted"]
    assert http.get(path).json()["version"] == 3
    assert http.post(f"{path}/looks", json=examples.LOOK).status_code == 201
