"""Rankings over HTTP: equal ones are one, each with its own session's version; an abandoned one is cancelled."""

import asyncio
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from fastapi import Request, Response

from tests.support.places import seen_from, spread_scenario
from tests.support.serving import POSES, Service, data_scenario, json_of, scan_of, serving
from tests.support.waiting import wait_for
from tests.voa_service.runtime.test_queues import Gate
from voa_msgs.rankings import VoaRequest
from voa_service.http.routes.responses import unless_gone
from voa_service.rpc.entry import Rpc

BELIEF = [0.2, 0.3, 0.5]


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("shared"), workers=1, queue=1) as running:
        yield running


@pytest.fixture(scope="module")
def scenario(service: Service) -> str:
    return service.create(data_scenario())


@pytest.fixture
def busy(service: Service, scenario: str) -> Iterator[Gate]:
    """The one worker is at something else until the gate is open."""
    gate = Gate()
    held = service.inside.heavy.submit(gate.work(0))
    assert gate.begun.acquire(timeout=30)
    yield gate
    gate.open.set()
    held.result(30)


def test_equal_rankings_take_one_place_and_have_one_answer(service: Service, scenario: str, busy: Gate) -> None:
    session = service.open(scenario)
    for belief in (BELIEF, BELIEF):
        service.http.put(f"/v1/sessions/{session}/belief", json={"belief": belief}).raise_for_status()
    other = service.open(scenario)
    service.http.put(f"/v1/sessions/{other}/belief", json={"belief": BELIEF}).raise_for_status()
    paths = [f"/v1/sessions/{each}/voa" for each in (session, other)] * 3
    with ThreadPoolExecutor(len(paths)) as pool:
        calls = [pool.submit(service.http.post, path, json={}) for path in paths]
        calls += [pool.submit(service.http.get, paths[0])]  # the same in other words
        wait_for(lambda: service.inside.heavy.inside == 2, "the ranking to be in line")
        busy.open.set()
        answers = [call.result(30) for call in calls]
    assert {answer.status_code for answer in answers} == {200}  # one more place than one would have been refused
    bodies = [answer.json() for answer in answers]
    assert [body.pop("version") for body in bodies] == [2, 1, 2, 1, 2, 1, 2]
    assert all(body == bodies[0] for body in bodies)


def test_an_answer_is_kept_for_equal_requests(service: Service, scenario: str) -> None:
    body = {"scenario": scenario, "belief": BELIEF, "outcomes": True}
    first = service.post("/v1/rankings", body)
    held = service.inside.rankings.kept.held
    assert service.post("/v1/rankings", body) == first
    assert (
        Rpc(service.inside).answer("ranking.compute", json_of(body)).body
        == service.http.post("/v1/rankings", json=body).content
    )
    assert service.inside.rankings.kept.held == held
    for change in ({"outcomes": False}, {"belief": [0.3, 0.2, 0.5]}, {"definition": "executed"}, {"min_gain": 0.5}):
        service.post("/v1/rankings", body | change)
        assert service.inside.rankings.kept.held > held
        held = service.inside.rankings.kept.held


def keys(service: Service, *sessions: str, **request: Any) -> set[Any]:
    """Keys of the answers to one request in several sessions."""
    body = VoaRequest.model_validate(request)
    return {service.inside.rankings.of_session(session, body).key for session in sessions}


def test_sessions_with_equal_beliefs_share_an_answer_if_their_looks_are_equal(service: Service, scenario: str) -> None:
    one, other = (service.open(scenario, prior=[1.0, 0.0, 0.0]) for _ in range(2))
    assert len(keys(service, one, other)) == 1
    service.post(f"/v1/sessions/{one}/scans", scan_of([0.5, 0.5, None, 1.0], "Q1"))
    assert len(keys(service, one, other)) == 2, "a certain belief stays, and the looks differ"
    taken = [
        {row["sensor"]: row["looks_taken"] for row in service.post(f"/v1/sessions/{session}/voa", {})["ranking"]}
        for session in (one, other)
    ]
    assert taken == [{"Q1": 1, "Q2": 0}, {"Q1": 0, "Q2": 0}]
    service.post(f"/v1/sessions/{other}/scans", scan_of([0.5, 0.5, None, 1.0], "Q1"))
    assert len(keys(service, one, other)) == 1, "looks without displaced copies are equal anywhere"


def test_sessions_with_displaced_copies_share_no_answer(service: Service) -> None:
    spread = spread_scenario(service)
    one, other = (service.open(spread, prior=[1.0, 0.0]) for _ in range(2))
    assert len(keys(service, one, other)) == 1
    for session in (one, other):
        service.post(f"/v1/sessions/{session}/scans", seen_from(service, "E", "A"))
    assert len(keys(service, one, other)) == 2
    before = keys(service, one)
    service.http.put(f"/v1/sessions/{one}/belief", json={"belief": None}).raise_for_status()
    service.http.put(f"/v1/sessions/{other}/belief", json={"belief": None}).raise_for_status()
    assert len(keys(service, one, other) | before) == 2


def test_the_std_of_the_last_sensor_pose_and_announced_looks_are_part_of_a_question(service: Service) -> None:
    spread = spread_scenario(service)
    one, other, third = (service.open(spread, prior=[1.0, 0.0]) for _ in range(3))
    place = {"x": 0.3, "y": 0.0, "yaw_rad": 3.141592653589793, "std": {"xy_m": 0.01, "yaw_rad": 0.0}}
    service.post(f"/v1/sessions/{one}/scans", seen_from(service, place, "A"))
    service.http.put(f"/v1/sessions/{one}/belief", json={"belief": None}).raise_for_status()
    service.post(f"/v1/sessions/{other}/looks", {"sensor": "E"})
    assert len(keys(service, one, other, third)) == 3
    assert len(keys(service, other, third, pending=[])) == 1
    service.post(f"/v1/sessions/{third}/looks", {"sensor": "E", "robot": "another"})
    assert len(keys(service, other, third)) == 1


def test_more_outcomes_than_an_answer_may_hold_are_refused(tmp_path_factory: pytest.TempPathFactory) -> None:
    with serving(tmp_path_factory.mktemp("few"), limits={"numbers": 100}) as few:
        body = {"scenario": few.create(data_scenario()), "belief": None, "outcomes": True}
        sensors = [{"x": 0.0, "y": 0.0, "yaw_rad": 0.0}] * (100 // (4 * len(POSES)))
        assert few.http.post("/v1/rankings", json=body | {"sensors": ["Q1", "Q2"]}).status_code == 200
        refused = few.http.post("/v1/rankings", json=body | {"sensors": [*sensors, sensors[0]]})
        assert refused.status_code == 413
        assert f"at most {len(sensors)} sensors at a time" in refused.json()["detail"]


def request_of(receive: Callable[[], Any]) -> Request:
    return Request({"type": "http"}, receive)


def test_work_for_a_client_that_goes_is_cancelled() -> None:
    async def story() -> tuple[int, bool]:
        gone, cancelled = asyncio.Event(), asyncio.Event()

        async def receive() -> dict[str, Any]:
            await gone.wait()
            return {"type": "http.disconnect"}

        async def work() -> Response:
            gone.set()
            try:
                await asyncio.Event().wait()
            finally:
                cancelled.set()
            return Response()

        async with asyncio.timeout(30):
            response = await unless_gone(request_of(receive), work())
        return response.status_code, cancelled.is_set()

    assert asyncio.run(story()) == (499, True)


def test_work_for_a_client_that_stays_is_done_and_its_errors_are_the_clients() -> None:
    async def stays() -> dict[str, Any]:
        await asyncio.Event().wait()
        return {}

    async def done() -> Response:
        return Response(status_code=202)

    async def failing() -> Response:
        raise LookupError("gone")

    async def story() -> int:
        with pytest.raises(LookupError, match="gone"):
            await unless_gone(request_of(stays), failing())
        return (await unless_gone(request_of(stays), done())).status_code

    assert asyncio.run(story()) == 202
