"""Messages from bytes: what is refused before it costs anything, and how large bodies wait for their turn."""

import asyncio
import json
import threading
import tracemalloc
from typing import Any

import pytest

from tests.support.serving import PREDICTIONS, data_scenario, json_of, scan_of
from voa_msgs.rankings import VoaRequest
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import ScanRequest
from voa_service.failures import Failure
from voa_service.requests.bodies import LARGE_BYTES, Reader, json_object, json_value, read
from voa_service.runtime.queues import WorkQueue
from voa_service.settings import Limits

LIMITS = Limits(beams=8, poses=20, sensors=10, grasps=10, parts=1_000, numbers=100_000)


def refused(kind: Any, body: bytes, limits: Limits = LIMITS) -> Failure:
    with pytest.raises(Failure) as error:
        read(kind, body, limits)
    return error.value


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (b'{"a": 1, "a": 1}', "'a' twice"),
        (b'{"a": {"b": [{"c": 1, "d": 2, "c": 3}]}}', "'c' twice"),
        (b'{"\\u0061": 1, "a": 2}', "'a' twice"),
        (b'{"a": ' + b"1" * 40 + b', "a": [' + b"0," * LARGE_BYTES + b"0]}", "'a' twice"),
    ],
)
def test_a_key_that_comes_twice_is_refused_wherever_it_stands(text: bytes, name: str) -> None:
    with pytest.raises(Failure, match=name) as error:
        json_object(text, LIMITS)
    assert error.value.status == 422


def test_small_and_large_bodies_are_read_alike() -> None:
    body = json_of(scan_of([0.5, None, 1e-3, 2], stamp={"at": [1, 2.5, -0.0, 1e300]}))
    padded = body[:-1] + b" " * LARGE_BYTES + b"}"
    assert json_value(padded, LIMITS) == json_value(body, LIMITS) == json.loads(body)


@pytest.mark.parametrize(
    ("payload", "status"),
    [
        (b"[" + b"0," * 100_001 + b"0]", 413),
        (b"[" * 1_001, 413),
        (b'""' * 1_001, 413),
        (b'"' + b"\\n" * 1_001 + b'"', 413),
        (b"{" + b",".join(b'"k%d": 0' % i for i in range(21)) + b"}", 422),
    ],
)
def test_what_would_be_large_in_memory_is_refused(payload: bytes, status: int) -> None:
    assert refused(ScanRequest, payload).status == status


def test_a_list_is_measured_before_its_items_are_looked_at() -> None:
    failure = refused(ScanRequest, json_of(scan_of([-1.0] * 9)))
    assert failure.detail == "body.scan.ranges: expected at most 8 (beams), got 9"
    assert len(failure.more["errors"]) == 1


def test_only_the_first_twenty_mistakes_are_collected_each_where_it_stands() -> None:
    poses = [{"name": "P1"}, {"name": 1}, {"name": "P2"}, {"nome": "P3"}]
    errors = refused(ScenarioRequest, json_of(data_scenario(poses=poses))).more["errors"]
    assert [each["field"] for each in errors] == ["body.poses.3.nome", "body.poses.1.name", "body.poses.3.name"]
    many = {f"Q{i}": dict.fromkeys(PREDICTIONS["Q1"], [-1.0] * 8) for i in range(10)}
    errors = refused(ScenarioRequest, json_of(data_scenario(predictions=many))).more["errors"]
    assert len(errors) == 20
    assert errors[0]["field"] == "body.predictions.Q0.P1.0"


def test_wrong_items_cost_no_memory_of_their_own() -> None:
    limits = Limits()
    body = b'{"sensor": "Q1", "scan": {"ranges": [' + b"-1," * 4_000 + b"-1]}}"
    rows = json_of(data_scenario(scores={"probabilities": [[2.0] * 20_000 for _ in range(10)]}))
    for kind, content in ((ScanRequest, body), (ScenarioRequest, rows)):
        tracemalloc.start()
        refused(kind, content, limits)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 2**20 + 16 * len(content)


def test_far_too_many_fields_are_named_by_the_first() -> None:
    body = json_of(scan_of([1.0]) | {f"k{i}": 0 for i in range(300)})
    failure = refused(ScanRequest, body, Limits())
    assert failure.detail == "body.k0: no such field: expected one of sensor, sensor_pose, scan (and more)"
    assert len(failure.more["errors"]) <= 20


def test_fields_have_their_names_in_json_alone() -> None:
    request = read(VoaRequest, b'{"from": "Q1", "cost_per_m": 1}', LIMITS)
    assert request.from_ == "Q1"
    for body in (b'{"from_": "Q1"}', json_of({"from_": "Q1"} | {f"k{i}": 0 for i in range(300)})):
        detail = refused(VoaRequest, body, Limits()).detail
        assert detail.startswith("body.from_: no such field: expected one of ")
        assert ", from, " in detail


def test_whole_numbers_are_read_as_the_numbers_they_are() -> None:
    scores = [[0, 1] * 1_000, [0.5, 1] * 1_000]
    body = json_of(data_scenario(scores={"probabilities": scores}))
    rows = read(ScenarioRequest, body, Limits()).scores.model_dump()["probabilities"]
    assert rows == scores
    assert {type(score) for row in rows for score in row} == {float}


def test_large_bodies_are_read_in_their_own_queue_and_one_too_many_is_refused() -> None:
    queue = WorkQueue("large", 1, 0)
    reader = Reader(Limits(), queue)
    small = json_of(scan_of([1.0]))
    large = small[:-1] + b" " * LARGE_BYTES + b"}"
    free = threading.Event()
    try:
        held = queue.submit(free.wait)
        assert asyncio.run(reader.received(ScanRequest, small)).sensor == "Q1"
        with pytest.raises(Failure, match="large requests are under way") as error:
            asyncio.run(reader.received(ScanRequest, large))
        assert error.value.status == 503
        with pytest.raises(Failure, match="large requests are under way"):
            reader.fields(large)
        free.set()
        held.result()
        assert asyncio.run(reader.received(ScanRequest, large)).sensor == "Q1"
        assert reader.message(ScanRequest, reader.fields(large), len(large)).sensor == "Q1"
    finally:
        free.set()
        queue.close()
