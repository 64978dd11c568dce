"""Make tests/voa_store/releases/VERSION: a database that an earlier release has written, with its responses.

    git worktree add /tmp/old COMMIT
    python -m tests.support.make_release /tmp/old VERSION

The service of that release runs from its folder and gets calls, most of them under an idempotency key. Release 0.1.0 is
commit 09fcbbf, and 0.2.0 is 21824e7. `database.sql` is the SQLite database as SQL text, and `calls.json` every call
that changes a session, with its response.
"""

import json
import os
import shutil
import socket
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import httpx2

from tests.support.serving import Json, as_scan, box_obj, data_scenario, mesh_scenario, scan_of

RELEASES = Path(__file__).parents[1] / "voa_store" / "releases"
LIDAR: Json = {
    "beams": 24,
    "angle_min": 0.0,
    "angle_increment": 0.2617993877991494,
    "range_min": 0.05,
    "range_max": 2.0,
    "zero": "no_return",
    "height_m": 0.02,
}
NEAR = [0.001, -0.002, 0.003, 0.0]
"""Errors of the ranges, metres, repeated over the beams."""


@contextmanager
def running(release: Path, database: str) -> Iterator[httpx2.Client]:
    """Run the service of a release, from its folder, on a database."""
    folders = [release / name for name in ("", "service", "clients", "assets")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, folders))}
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port, handed = listening.getsockname()[1], str(listening.fileno())
        command = [sys.executable, "-m", "voa_service", "--fd", handed, "--database-url", database]
        process = subprocess.Popen(command, env=environment, cwd=release, pass_fds=[listening.fileno()])
    try:
        with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=120.0) as http:
            yield http
    finally:
        process.terminate()
        process.wait(30)


class Recorder:
    """Sends calls, and keeps each of them with its response."""

    def __init__(self, http: httpx2.Client) -> None:
        self.http = http
        self.calls: list[Json] = []

    def send(self, method: str, path: str, body: Json | None = None, *, keyed: bool = True) -> Any:
        """Send a call and return the body of its response."""
        key = f"call-{len(self.calls)}" if keyed else None
        text = None if body is None else json.dumps(body)
        headers = {"Content-Type": "application/json"} | ({} if key is None else {"Idempotency-Key": key})
        answer = self.http.request(method, path, content=text, headers=headers)
        answer.raise_for_status()
        call = {"method": method, "path": path, "body": text, "key": key}
        self.calls.append(call | {"status": answer.status_code, "response": answer.text})
        return answer.json() if answer.text else None


def record(http: httpx2.Client) -> list[Json]:
    """Make scenarios and sessions of every kind that a release knows; return the calls with their responses."""
    calls = Recorder(http)
    mesh = http.post("/v1/objects", files={"file": ("box.obj", box_obj().encode())}).json()["id"]
    _with_data(calls)
    for rule in ("beam", "margin"):
        body = mesh_scenario(mesh, name=rule, lidar=LIDAR, update={"rule": rule})
        scenario = http.post("/v1/scenarios", json=body).raise_for_status().json()["id"]
        _with_mesh(calls, scenario, {"sensor_pose": {"x": 0.0, "y": -0.3, "yaw_rad": 1.5}})
        if rule == "beam":
            std = {"xy_m": 0.01, "yaw_rad": 0.02}
            _with_mesh(calls, scenario, {"sensor_pose": {"x": 0.3, "y": 0.0, "yaw_rad": 3.1, "std": std}}, ["G1"])
    return calls.calls


def _with_data(calls: Recorder) -> None:
    scenario = calls.http.post("/v1/scenarios", json=data_scenario()).raise_for_status().json()["id"]
    root = f"/v1/sessions/{calls.send('POST', '/v1/sessions', {'scenario': scenario})['id']}"
    calls.send("POST", f"{root}/scans", scan_of([0.51, 0.5, None, 1.0]))
    calls.send("POST", f"{root}/scans", scan_of([None] * 4))
    calls.send("POST", f"{root}/scans", scan_of([0.5, 0.5, 0.7, 1.01], "Q2"), keyed=False)
    calls.send("POST", f"{root}/grasp-outcomes", {"grasp": "G1", "success": False})
    calls.send("PUT", f"{root}/belief", {"belief": [0.2, 0.3, 0.5]})
    calls.send("POST", f"{root}/scans", scan_of([0.6, 0.0, 0.5, 1.0], no_return=[1]))
    gone = calls.send("POST", "/v1/sessions", {"scenario": scenario}, keyed=False)["id"]
    calls.send("DELETE", f"/v1/sessions/{gone}")


def _with_mesh(calls: Recorder, scenario: str, pose: Json, outcomes: list[str] | None = None) -> None:
    root = f"/v1/sessions/{calls.send('POST', '/v1/sessions', {'scenario': scenario})['id']}"
    predicted = calls.http.post(f"/v1/scenarios/{scenario}/predictions", json={}).raise_for_status().json()["ranges"]
    for sensor, of_poses in zip(("E", "N"), predicted, strict=True):
        calls.send("POST", f"{root}/scans", {"sensor": sensor, "scan": as_scan(_measured(of_poses[0]))})
    calls.send("POST", f"{root}/scans", pose | {"scan": as_scan(_measured(predicted[0][1]))})
    for grasp in outcomes or []:
        calls.send("POST", f"{root}/grasp-outcomes", {"grasp": grasp, "success": True})


def _measured(ranges: list[float | None]) -> list[float | None]:
    return [value and round(value + NEAR[index % len(NEAR)], 4) for index, value in enumerate(ranges)]


def main(release: Path, version: str) -> None:
    """Write the database of a release, and what it responded."""
    folder = RELEASES / version
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as temporary:
        file = Path(temporary) / "voa.db"
        with running(release, f"sqlite:///{file}") as http:
            calls = record(http)
        with closing(sqlite3.connect(file)) as connection:
            (folder / "database.sql").write_text("\n".join(connection.iterdump()) + "\n", encoding="utf-8")
    lines = ",\n".join(json.dumps(call) for call in calls)
    (folder / "calls.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), sys.argv[2])
