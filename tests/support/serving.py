"""Service in this process, and small scenarios and scans to send to it."""

import copy
import json
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from starlette.testclient import TestClient

from tests.voa_core.worlds import BOX_FACES
from voa_service.bootstrap import services
from voa_service.http.app import create_app
from voa_service.services import Services
from voa_service.settings import Settings
from voa_store.drivers import sqlite_driver

Json = dict[str, Any]

POSES = ("P1", "P2", "P3")
LIDAR: Json = {
    "beams": 4,
    "angle_min": 0.0,
    "angle_increment": 0.1,
    "range_min": 0.1,
    "range_max": 2.0,
    "zero": "missing",
}
PREDICTIONS: Json = {
    "Q1": {"P1": [0.5, 0.5, None, 1.0], "P2": [0.6, None, None, 1.0], "P3": [0.9, 0.5, 0.5, None]},
    "Q2": {"P1": [0.5, 0.5, None, 1.0], "P2": [0.5, 0.5, None, 1.0], "P3": [0.5, 0.5, 0.8, 1.0]},
}
SCORES = [[0.9, 0.1, 0.2], [0.1, 0.8, 0.3]]
TURNED = [0.7071067811865476, 0.0, 0.0, 0.7071067811865476]


def box_obj(x: float = 0.04, y: float = 0.06, z: float = 0.05) -> str:
    """Write a box of x by y by z metres, which stands on the table around the z axis, as an OBJ file."""
    corners = [((i - 0.5) * x, (j - 0.5) * y, k * z) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    lines = [f"v {a} {b} {c}" for a, b, c in corners]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in BOX_FACES]
    return "\n".join(lines) + "\n"


def data_scenario(**changes: Any) -> Json:
    """Scenario with three poses, two grasps, two sensor configurations, and all predictions given as data."""
    body = {
        "name": "data",
        "poses": [{"name": name} for name in POSES],
        "grasps": [{"name": "G1", "data": {"width_m": 0.018}}, {"name": "G2"}],
        "scores": {"probabilities": SCORES},
        "sensors": [{"name": name, "x": 0.0, "y": 0.0, "yaw_rad": 0.0} for name in ("Q1", "Q2")],
        "lidar": LIDAR,
        "update": {"rule": "exponential", "no_return_m": 1.0},
        "predictions": PREDICTIONS,
    }
    return copy.deepcopy(body | changes)


def mesh_scenario(object_id: str, **changes: Any) -> Json:
    """Scenario of a box at yaw 0 and 90 degrees, with two grasps, and an LDS-01 that looks from the east and north."""
    body = {
        "name": "mesh",
        "object": object_id,
        "poses": [
            {"name": "A", "position": [0.0, 0.0, 0.0], "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0]},
            {"name": "B", "position": [0.0, 0.0, 0.0], "quaternion_wxyz": TURNED},
        ],
        "grasps": [{"name": "G1"}, {"name": "G2"}],
        "scores": {"attempts": 10, "successes": [[9, 1], [2, 8]]},
        "sensors": [
            {"name": "E", "x": 0.3, "y": 0.0, "yaw_rad": 3.141592653589793},
            {"name": "N", "x": 0.0, "y": 0.3, "yaw_rad": -1.5707963267948966, "cost": 0.01},
        ],
        "lidar": {"preset": "lds-01", "height_m": 0.02},
        "update": {"rule": "exponential", "no_return_m": 1.0},
    }
    return copy.deepcopy(body | changes)


def scan_of(ranges: Sequence[float | None], sensor: str = "Q1", **more: Any) -> Json:
    return {"sensor": sensor, "scan": {"ranges": list(ranges)} | more}


def as_scan(predicted: list[float | None]) -> Json:
    """Convert predicted ranges to the scan of a perfect lidar: their null is a no-return, that of a scan is missing."""
    return {"ranges": predicted, "no_return": [i for i, value in enumerate(predicted) if value is None]}


def changed(body: Json, where: str, value: Any) -> Json:
    """Copy `body` with another value at a path such as "poses.0.name"."""
    copied = copy.deepcopy(body)
    *parents, last = where.split(".")
    node: Any = copied
    for step in parents:
        node = node[int(step) if isinstance(node, list) else step]
    node[int(last) if isinstance(node, list) else last] = value
    return copied


@dataclass(frozen=True)
class Service:
    """A service in this process."""

    http: TestClient
    inside: Services
    database: Path

    def create(self, body: Json) -> str:
        """Store a scenario and return its id."""
        return self._made("/v1/scenarios", body)

    def open(self, scenario: str, **more: Any) -> str:
        """Open a session and return its id."""
        return self._made("/v1/sessions", {"scenario": scenario} | more)

    def upload(self, content: str | bytes, name: str = "box.obj", **form: str) -> str:
        """Store a mesh and return its id."""
        answer = self.http.post("/v1/objects", files={"file": (name, content)}, data=form)
        assert answer.status_code in (200, 201), answer.text
        return str(answer.json()["id"])

    def post(self, path: str, body: Any, **headers: str) -> Any:
        """Return the body of the response to a call that must succeed."""
        answer = self.http.post(path, json=body, headers=headers)
        assert answer.is_success, answer.text
        return answer.json()

    def get(self, path: str) -> Any:
        """Return the body of the response to a call that must succeed."""
        answer = self.http.get(path)
        assert answer.is_success, answer.text
        return answer.json()

    def stored(self) -> list[str]:
        """List every row of the database, with its table."""
        # By the service's own SQLite: two of them in one process undo each other's locks.
        with closing(sqlite_driver().connect(str(self.database))) as connection:
            names = [name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
            return [f"{name} {row!r}" for name in names for row in connection.execute(f'SELECT * FROM "{name}"')]  # noqa: S608

    def _made(self, path: str, body: Json) -> str:
        return str(self.post(path, body)["id"])


@contextmanager
def serving(folder: Path, **settings: Any) -> Iterator[Service]:
    """Run the service on a database in `folder`; an unexpected error gives status 500 and is not raised."""
    database = folder / "voa.db"
    given: Json = {"database_url": f"sqlite:///{database}", "workers": 2, "cache_mebibytes": 64} | settings
    with services(Settings(**given)) as inside, client(inside) as http:
        yield Service(http, inside, database)


def client(inside: Services) -> TestClient:
    """Make a client of a service in this process, which it calls by a loopback address."""
    return TestClient(create_app(inside), "http://127.0.0.1", raise_server_exceptions=False)


def json_of(body: Any) -> bytes:
    """Write JSON as Python does, NaN and Infinity included."""
    return json.dumps(body).encode()
