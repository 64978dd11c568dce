"""Stable poses from the service: worked out once, beside the rankings, and refused with the reason."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.support.serving import Service, box_obj, data_scenario, serving
from tests.voa_service.runtime.test_queues import Gate
from voa_service.rpc.entry import Rpc


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with serving(tmp_path, workers=1, queue=1) as running:
        yield running


def stl(mesh: trimesh.Trimesh) -> bytes:
    content: bytes = trimesh.exchange.stl.export_stl(mesh)
    return content


def ball(points: int) -> bytes:
    """The hull of points on a sphere of 0.1 m."""
    places = np.random.default_rng(2).normal(size=(points, 3))
    places *= 0.1 / np.linalg.norm(places, axis=1, keepdims=True)
    return stl(trimesh.convex.convex_hull(places))


def test_what_was_worked_out_is_kept_by_content_and_counts_as_memory_held(service: Service) -> None:
    object_ = service.upload(box_obj())
    held = service.inside.objects.cache.held
    first = service.inside.objects.stable_poses(object_)
    assert service.inside.objects.stable_poses(object_) is first
    assert service.inside.objects.cache.held > held
    assert service.get(f"/v1/objects/{object_}/stable-poses") == first.model_dump()


def test_a_ranking_does_not_wait_for_stable_poses_nor_they_for_it(service: Service) -> None:
    body = {"scenario": service.create(data_scenario()), "belief": [0.2, 0.3, 0.5]}
    path = f"/v1/objects/{service.upload(box_obj())}/stable-poses"
    portal = service.http.portal
    assert portal is not None

    def rest() -> int:
        return service.http.get(path).status_code

    def rank() -> int:
        return service.http.post("/v1/rankings", json=body).status_code

    for busy, waits, goes_on in ((service.inside.rests, rest, rank), (service.inside.heavy, rank, rest)):
        gate = Gate()
        held = [portal.start_task_soon(busy.run, gate.work(i)) for i in range(2)]
        assert gate.begun.acquire(timeout=30)
        assert (waits(), goes_on()) == (503, 200)
        gate.open.set()
        assert [future.result(30) for future in held] == [0, 1]


def test_over_zenoh_they_wait_in_the_same_line(service: Service) -> None:
    assert Rpc(service.inside).queue("object.stable_poses") is service.inside.rests


def test_a_fine_ball_is_answered_within_two_seconds(service: Service) -> None:
    object_ = service.upload(stl(trimesh.creation.icosphere(subdivisions=4, radius=0.1)), "ball.stl")
    began = time.process_time()
    (anyhow,) = service.get(f"/v1/objects/{object_}/stable-poses")["items"]
    assert time.process_time() - began < 2.0
    assert anyhow["probability"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("what", "content", "reason"),
    [
        ("a sheet", box_obj(0.04, 0.06, 0.0).encode(), "expected a mesh with a volume"),
        ("a ball of 50 196 faces", None, "at most 50000 triangles in its convex hull"),
    ],
)
def test_what_cannot_rest_is_refused_with_the_reason(
    service: Service, what: str, content: bytes | None, reason: str
) -> None:
    object_ = service.upload(ball(25_100), "ball.stl") if content is None else service.upload(content)
    for _ in range(2):
        answer = service.http.get(f"/v1/objects/{object_}/stable-poses")
        assert (answer.status_code, answer.json()["type"]) == (422, "urn:voa:problem:invalid-mesh")
        assert reason in answer.json()["detail"]
