"""Case of bad input, the service that the cases are sent to, and values that several tables share."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from tests.support.quiet_robot import QuietRobot
from tests.support.serving import Json, Service, box_obj, data_scenario, json_of, mesh_scenario, scan_of, serving
from voa_service.settings import Limits

LIMITS = Limits(
    beams=64,
    poses=20,
    sensors=10,
    grasps=10,
    faces=100,
    upload_bytes=500_000,
    body_bytes=3_000_000,
    numbers=100_000,
    parts=250_000,
)
NAN, INF, HUGE = float("nan"), float("inf"), 10**400
INVALID, UNKNOWN, NO_MESH, CONFLICT = "invalid-request", "unknown-name", "no-mesh", "claim-conflict"
TYPE = "unsupported-media-type"


class World(NamedTuple):
    """Service with stored scenarios and sessions, and their identifiers, which the cases name in braces."""

    service: Service
    data: str
    mesh: str
    object: str
    data_session: str
    mesh_session: str


@contextmanager
def stocked_service(folder: Path) -> Iterator[World]:
    """A service with two scenarios, a session on each, and a robot mapped to a scenario and one to a session."""
    with serving(folder, limits=LIMITS) as service:
        box = service.upload(box_obj())
        mesh = mesh_scenario(box, lidar={"preset": "lds-01", "beams": 60, "angle_increment": 0.1, "height_m": 0.02})
        data_id, mesh_id = service.create(data_scenario()), service.create(mesh)
        sessions = service.open(data_id), service.open(mesh_id)
        service.post(f"/v1/sessions/{sessions[0]}/scans", scan_of([0.5, 0.5, None, 1.0]))
        robots = service.inside.robots
        robots.mapped("free", "free/scan", QuietRobot(), scenario=data_id)
        robots.mapped("fixed", "fixed/scan", QuietRobot(), session=sessions[0])
        yield World(service, data_id, mesh_id, box, *sessions)


class Case(NamedTuple):
    """Request with bad input, and the problem expected; braces in path and body stand for identifiers of the world."""

    name: str
    path: str
    body: Any
    status: int = 422
    kind: str = INVALID
    says: str = ""
    method: str = "POST"
    headers: Mapping[str, str] = MappingProxyType({})


def without(body: Json, name: str) -> Json:
    return {key: value for key, value in body.items() if key != name}


def nested(levels: int) -> Any:
    value: Any = 0
    for _ in range(levels):
        value = [value]
    return value


GOOD = [0.5, 0.5, None, 1.0]
SCANS = "/v1/sessions/{data_session}/scans"
HERE: Json = {"x": 0.3, "y": 0.0, "yaw_rad": 3.14}

UPDATE: Json = {"scenario": "{data}", "belief": [0.2, 0.3, 0.5], **scan_of(GOOD)}
RANK: Json = {"scenario": "{data}", "belief": [0.2, 0.3, 0.5]}
VOA = "/v1/sessions/{data_session}/voa"
OUTCOMES = "/v1/sessions/{data_session}/grasp-outcomes"
PREDICT = "/v1/scenarios/{data}/predictions"
RAW_SCAN = json.dumps(scan_of(GOOD)).encode()
JSON = {"content-type": "application/json"}
BIG = b"[" + b"0" * 3_000_001 + b"]"
SESSION = "/v1/sessions/{data_session}"


def filled(text: str, world: World) -> str:
    for name in ("data", "mesh", "object", "data_session", "mesh_session"):
        text = text.replace("{" + name + "}", getattr(world, name))
    return text


def send(world: World, case: Case) -> Any:
    http, path = world.service.http, filled(case.path, world)
    match case.body:
        case None:
            return http.request(case.method, path, headers=case.headers)
        case bytes():
            return http.request(case.method, path, content=case.body, headers=case.headers)
        case [bytes(), *_]:
            return http.request(case.method, path, content=iter(case.body), headers=case.headers)
        case _:
            body = filled(json_of(case.body).decode(), world)
            return http.request(case.method, path, content=body, headers=JSON | dict(case.headers))


def check_problem(answer: Any, status: int, kind: str, says: str) -> None:
    """The answer is the problem document that it must be."""
    assert answer.status_code == status, answer.text[:500]
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem["type"] == f"urn:voa:problem:{kind}"
    assert problem["status"] == status
    assert problem["title"]
    assert says in problem["detail"]
    assert problem["request_id"] == answer.headers["x-request-id"]
