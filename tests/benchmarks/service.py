"""Proves what the service adds to the mathematics, and shows how long each step of a large scenario takes.

Scan update, 500 poses: CPU time of the server per request, less that of the numerics and of the store, which spans
inside the request measure (`spanned.py`), against FastAPI and pydantic that echo the same bodies from a `def` endpoint
under the same server (`echo.py`); the ratio says how many times dearer ours is. Steps, 2 000 poses x 64 sensor
configurations: wall time of each call, from the scenario to a ranking under the new belief, with the server's CPU time
beside; they have no peer.
"""

import json
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

import httpx2
import numpy as np

from tests.benchmarks import scene
from tests.benchmarks.measure import Result
from tests.benchmarks.spanned import Spans
from voa_client.local import Running, running

_SCHEDULED = 2
"""Number of the clock, of those that Linux keeps for a process, that counts the time for which it has run."""
_ROUNDS, _REQUESTS = 7, 100
_CPU = "ms CPU"
_GRASPS = 20


def run() -> list[Result]:
    """The scan update against the echo, then the steps, under the rule of the paper and the rule for live robots."""
    with tempfile.TemporaryDirectory(prefix="voa-bench-") as folder:
        place = Path(folder)
        return [*_against_echo(place), *_steps(place, "exponential"), *_steps(place, "beam")]


@contextmanager
def _service(place: Path) -> Iterator[Running]:
    options = ["--database-url", f"sqlite:///{place / 'bench.db'}", "--log-level", "WARNING"]
    with running("voa_service", options, place / "service.log") as service:
        yield service


def _against_echo(place: Path) -> list[Result]:
    spans = Spans(place / "spans")
    options = ["--spans", str(place / "spans"), "--database-url", f"sqlite:///{place / 'spanned.db'}"]
    with (
        running("tests.benchmarks.spanned", [*options, "--log-level", "WARNING"], place / "spanned.log") as ours,
        running("tests.benchmarks.echo", [], place / "echo.log") as echo,
        httpx2.Client(base_url=ours.url, timeout=300) as http,
        httpx2.Client(base_url=echo.url) as peer,
    ):
        scenario = post(http, "/v1/scenarios", scenario_of(http, place, "exponential", poses=500, sensors=4))
        session = post(http, "/v1/sessions", {"scenario": scenario["id"]})
        path = f"/v1/sessions/{session['id']}/scans"
        scan = scan_of(http, scenario["id"])
        post(peer, "/prepare", post(http, path, scan))
        body = json.dumps(scan)
        rounds: list[tuple[float, float, float, float]] = []
        for _ in range(_ROUNDS):
            before = spans.read()
            whole = _cpu_per_request(ours.pid, lambda: _raw(http, path, body))
            numerics, store = ((now - then) / _REQUESTS for now, then in zip(spans.read(), before, strict=True))
            rounds.append((whole, numerics, store, _cpu_per_request(echo.pid, lambda: _raw(peer, "/scans", body))))
    numerics, store, theirs = (median(each) for each in list(zip(*rounds, strict=True))[1:])
    mine = median(whole - inside - stored for whole, inside, stored, _ in rounds)
    of_scan = "scan update over HTTP, 500 poses"
    return [
        Result(f"{of_scan}, besides numerics and commit / FastAPI echo", mine / theirs, 1e3 * mine, 1e3 * theirs, _CPU),
        Result(f"{of_scan}: numerics", None, 1e3 * numerics, None, _CPU),
        Result(f"{of_scan}: reads and commit of the store", None, 1e3 * store, None, _CPU),
    ]


def _steps(place: Path, rule: str) -> list[Result]:
    results = []
    with _service(place) as service, httpx2.Client(base_url=service.url, timeout=600) as http:
        body = scenario_of(http, place, rule, poses=2_000, sensors=64)

        def step(name: str, call: Callable[[], dict[str, Any]]) -> dict[str, Any]:
            cpu, began = cpu_seconds(service.pid), time.perf_counter()
            answer = call()
            wall, spent = time.perf_counter() - began, cpu_seconds(service.pid) - cpu
            title = f"2000 poses x 64 sensors, {rule}: {name}"
            results.append(Result(title, None, 1e3 * wall, None, f"ms wall ({1e3 * spent:.0f} ms CPU)"))
            return answer

        scenario = step("create scenario", lambda: post(http, "/v1/scenarios", body))
        session = step("open session", lambda: post(http, "/v1/sessions", {"scenario": scenario["id"]}))
        scan = scan_of(http, str(scenario["id"]))
        looks, scans = f"/v1/sessions/{session['id']}/voa", f"/v1/sessions/{session['id']}/scans"
        first = step("ranking, first (predictions and weights)", lambda: post(http, looks, {}))
        step("scan update", lambda: post(http, scans, scan))
        step(f"ranking, again ({first['precision']})", lambda: post(http, looks, {}))
    return results


def scenario_of(http: httpx2.Client, place: Path, rule: str, poses: int, sensors: int) -> dict[str, Any]:
    """A scenario of the cup at any tilt; its mesh is uploaded."""
    mesh = place / "cup.obj"
    cup = scene.cup("10k")
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in cup.vertices]
    mesh.write_text("\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in cup.faces]), encoding="utf-8")
    uploaded = http.post("/v1/objects", files={"file": (mesh.name, mesh.read_bytes())})
    uploaded.raise_for_status()
    held = scene.poses(cup, poses, planar=False)
    assert held.positions is not None
    assert held.quaternions_wxyz is not None
    geometry = zip(held.names, held.positions.tolist(), held.quaternions_wxyz.tolist(), strict=True)
    return {
        "name": f"bench {rule} {poses}",
        "object": uploaded.json()["id"],
        "poses": [{"name": name, "position": at, "quaternion_wxyz": how} for name, at, how in geometry],
        "grasps": [{"name": f"G{index}"} for index in range(_GRASPS)],
        "scores": {"probabilities": scene.scores(_GRASPS, poses).round(3).tolist()},
        "sensors": [
            {"name": own.name, "x": own.x, "y": own.y, "yaw_rad": own.yaw_rad} for own in scene.sensors(sensors)
        ],
        "lidar": {"preset": "lds-01", "height_m": scene.LIDAR.height_m},
        "update": {"rule": rule},
    }


def scan_of(http: httpx2.Client, scenario: str) -> dict[str, Any]:
    """The scan that the first pose gives at the first sensor configuration, with noise."""
    stored = http.get(f"/v1/scenarios/{scenario}").json()
    sensor = stored["sensors"][0]["name"]
    predicted = post(http, f"/v1/scenarios/{scenario}/predictions", {"sensors": [sensor]})
    noise = np.random.default_rng(1).normal(0.0, 0.005, stored["lidar"]["beams"])
    exact = predicted["ranges"][0][0]
    ranges = [None if r is None else r + float(off) for r, off in zip(exact, noise, strict=True)]
    return {"sensor": sensor, "scan": {"ranges": ranges, "no_return": [i for i, r in enumerate(exact) if r is None]}}


def post(http: httpx2.Client, path: str, body: object) -> dict[str, Any]:
    answer = http.post(path, json=body)
    answer.raise_for_status()
    content: dict[str, Any] = answer.json()
    return content


def _raw(http: httpx2.Client, path: str, body: str) -> None:
    http.post(path, content=body, headers={"Content-Type": "application/json"}).raise_for_status()


def _cpu_per_request(pid: int, call: Callable[[], None]) -> float:
    before = cpu_seconds(pid)
    for _ in range(_REQUESTS):
        call()
    return (cpu_seconds(pid) - before) / _REQUESTS


def cpu_seconds(pid: int) -> float:
    """CPU time of a process so far, of all its threads, from the clock that Linux keeps for each process."""
    return time.clock_gettime((~pid << 3) | _SCHEDULED)
