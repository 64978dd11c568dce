"""Middleware around the application: request ids, limits on bodies, and the response to a defect of the service."""

from collections.abc import Iterator

import pytest

from tests.support.serving import Service, serving
from tests.support.waiting import wait_for
from voa_service.settings import Limits
from voa_service.usecases.scenarios import Scenarios


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    limits = Limits(body_bytes=10_000, numbers=50)
    with serving(tmp_path_factory.mktemp("small"), limits=limits) as service:
        yield service


JSON = {"content-type": "application/json"}


@pytest.mark.parametrize(("size", "status"), [(10_000, 422), (10_001, 413)])
def test_a_body_is_limited_to_the_byte(small: Service, size: int, status: int) -> None:
    body = b'"' + b"a" * (size - 2) + b'"'
    assert small.http.post("/v1/scenarios", content=body, headers=JSON).status_code == status
    chunks = iter([body[:5_000], body[5_000:]])
    assert small.http.post("/v1/scenarios", content=chunks, headers=JSON).status_code == status


@pytest.mark.parametrize(("values", "status"), [(51, 422), (52, 413)])
def test_a_body_is_limited_to_the_value(small: Service, values: int, status: int) -> None:
    body = ("[" + ",".join("0" * values) + "]").encode()
    assert small.http.post("/v1/scenarios", content=body, headers=JSON).status_code == status


def test_a_false_content_length_is_detected(small: Service) -> None:
    chunks = iter([b'"' + b"a" * 10_001 + b'"'])
    answer = small.http.post("/v1/scenarios", content=chunks, headers=JSON | {"content-length": "5"})
    assert answer.status_code == 413


def test_a_character_may_be_split_between_chunks(small: Service) -> None:
    body = '"é"'.encode()
    answer = small.http.post("/v1/scenarios", content=iter([body[:2], body[2:]]), headers=JSON)
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:voa:problem:invalid-request")


def test_a_byte_order_mark_is_no_part_of_the_body(small: Service) -> None:
    body = b"\xef\xbb\xbf" + b'{"scenario": "nothing"}'
    answer = small.http.post("/v1/sessions", content=body, headers=JSON)
    assert answer.json()["type"] == "urn:voa:problem:unknown-name"


def test_a_defect_is_500_with_a_request_id_and_no_detail(small: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Scenarios) -> None:
        raise RuntimeError("the secret of the house")

    monkeypatch.setattr(Scenarios, "lidars", fail)
    answer = small.http.get("/v1/lidars", headers={"x-request-id": "robot-1"})
    assert answer.status_code == 500
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["x-request-id"] == answer.json()["request_id"] == "robot-1"
    assert answer.json()["type"] == "urn:voa:problem:internal"
    assert "secret" not in answer.text


def test_ready_is_503_when_the_store_does_not_answer(small: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    ready = small.get("/readyz")
    assert (ready["status"], ready["wire_version"], ready["zenoh"]) == ("ready", 1, "off")

    def fail() -> None:
        raise OSError("the disk is gone")

    monkeypatch.setattr(small.inside.health.store, "ping", fail)
    wait_for(lambda: small.http.get("/readyz").status_code == 503, "readiness to be tried again, once a second")
    assert small.http.get("/readyz").json()["type"] == "urn:voa:problem:not-ready"
    assert small.get("/livez") == {"status": "alive"}
