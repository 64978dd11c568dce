"""Bench for drives: a service on a Zenoh router, robots that publish on it, and the replay of what they published."""

import json
import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
import pytest
from zenoh import CongestionControl

from tests.support.bus import Stranger, stranger
from tests.support.drives import ODOM, SCAN, START_S, Drive, Put, box, record, scenario
from tests.support.routers import Router
from tests.support.waiting import wait_for
from tests.voa_cli.labs import Lab, service_on
from voa_cli.main import main
from voa_msgs.sessions import ScanRequest
from voa_ros.topics import LASER_SCAN

BY_ODOMETRY = 'from = "odometry"\nstd = { xy_m = 0.003, yaw_rad = 0.005 }'
SECONDS = 60.0


class Bench:
    """Service on a router, with a mapping that tests change, and a session that publishes as robots do."""

    def __init__(self, lab: Lab, bus: Stranger, folder: Path) -> None:
        self.lab = lab
        self.bus = bus
        self.folder = folder
        self.mapping = folder / "robots.toml"
        self._names = iter(range(1_000))
        self._object: str | None = None

    def post(self, path: str, body: Any) -> Any:
        answer = httpx2.post(f"{self.lab.url}{path}", json=body, timeout=SECONDS)
        assert answer.is_success, answer.text
        return answer.json()

    def get(self, path: str) -> Any:
        answer = httpx2.get(f"{self.lab.url}{path}", timeout=SECONDS)
        assert answer.is_success, answer.text
        return answer.json()

    def scenario(self, preset: str, **changes: Any) -> str:
        """Store the scenario of the box and return its identifier."""
        if self._object is None:
            files = {"file": ("box.obj", box().encode())}
            self._object = httpx2.post(f"{self.lab.url}/v1/objects", files=files, timeout=SECONDS).json()["id"]
        return str(self.post("/v1/scenarios", scenario(self._object, preset, **changes))["id"])

    def robot(self, session: str, more: str = "", look: str = "", place: str = "") -> str:
        """Map a new robot to a session, and no other; returns its name when its topics are subscribed to."""
        return self.robots([session], more, look, place)[0]

    def robots(self, sessions: list[str], more: str = "", look: str = "", place: str = "") -> list[str]:
        """Map a new robot to each session, and no others; returns their names when their topics are subscribed to."""
        names = [f"robot_{next(self._names)}" for _ in sessions]
        look = look or '{ mode = "stationary", scans = 10 }'
        self.mapping.write_text(
            "\n".join(
                f'[[robot]]\nname = "{name}"\nsession = "{session}"\n{more}\nlook = {look}\n'
                f"[robot.place]\n{place or BY_ODOMETRY}\n"
                for name, session in zip(names, sessions, strict=True)
            )
        )
        topics = (SCAN,) if place else (SCAN, ODOM)
        for topic in [f"{name}/{topic}" for name in names for topic in topics]:
            with self.bus.session.declare_publisher(topic) as publisher:
                # The stub says bool; it is an object with the attribute `matching`.
                wait_for(lambda own=publisher: own.matching_status.matching, "the topic to be subscribed to")  # type: ignore[misc] # bound in each round, which mypy cannot infer
        wait_for(lambda: all(self.report(name) for name in names), "the mapping")
        return names

    def report(self, name: str) -> Any:
        reports = self.get("/v1/robots")["items"]
        return next((each for each in reports if (each["robot"], each["source"]) == (name, "ros2")), None)

    def put(self, key: str, payload: bytes) -> None:
        """Publish a message, and wait instead of dropping it."""
        self.bus.session.put(key, payload, congestion_control=CongestionControl.BLOCK)

    def live(self, name: str, puts: list[Put]) -> Any:
        """Publish as a bridge does, as fast as possible; returns the report after the last scan was processed."""
        for put in puts:
            self.put(f"{name}/{put.topic}", put.payload)
        return self.worked_on(name, puts)

    def in_time(self, robots: dict[str, list[Put]]) -> None:
        """Publish the messages of several robots at their times of arrival."""
        puts = sorted(
            ((put, name) for name, of_robot in robots.items() for put in of_robot), key=lambda each: each[0].at_s
        )
        began, never = time.monotonic(), threading.Event()
        for put, name in puts:
            never.wait(max(0.0, put.at_s - START_S - (time.monotonic() - began)))
            self.put(f"{name}/{put.topic}", put.payload)

    def worked_on(self, name: str, puts: list[Put]) -> Any:
        """Wait until every scan was processed, and return the report about the robot."""
        scans = sum(put.type == LASER_SCAN for put in puts)
        wait_for(lambda: self.report(name)["scans"] == scans, f"{scans} scans of {name}", SECONDS)
        return self.report(name)

    def replayed(self, capsys: pytest.CaptureFixture[str], name: str, puts: list[Put], scenario_id: str) -> list[Any]:
        """Replay what a robot published, with the present mapping; returns the looks of its session."""
        own = [put._replace(topic=f"{name}/{put.topic}") for put in puts]
        path = record(self.folder / f"drive-{next(self._names)}.mcap", own)
        options = ["--scenario", scenario_id, "--robots", str(self.mapping), "--url", self.lab.url, "--json"]
        code = main(["replay", str(path), *options])
        out, err = capsys.readouterr()
        assert code == 0, err
        (session,) = [each["session"] for each in json.loads(out)["robots"] if each["robot"] == name]
        return self.looks(session)

    def looks(self, session: str) -> list[Any]:
        """List the looks in the history of a session."""
        items = self.get(f"/v1/sessions/{session}/history?limit=100")["items"]
        return [entry for entry in items if entry["kind"] == "scan"]


@contextmanager
def benches(folder: Path, own_router: Router) -> Iterator[Bench]:
    mapping = folder / "robots.toml"
    mapping.write_text("")
    with (
        service_on(own_router, folder, ["--robots", str(mapping)]) as lab,
        stranger(own_router.endpoint) as bus,
    ):
        yield Bench(lab, bus, folder)


def seen(looks: list[Any]) -> list[Any]:
    """Ranges of each look, and the pose from which it was taken."""
    requests = [ScanRequest.model_validate(entry["request"]) for entry in looks]
    return [(each.scan.ranges, each.scan.no_return, each.sensor_pose) for each in requests]


def both(
    bench: Bench, capsys: pytest.CaptureFixture[str], preset: str, puts: list[Put], more: str = "", look: str = ""
) -> tuple[Any, list[Any]]:
    """Publish live, and replay; asserts that both give the same looks, and returns the report and the looks."""
    return both_on(bench, capsys, bench.scenario(preset), puts, more, look)


def both_on(
    bench: Bench,
    capsys: pytest.CaptureFixture[str],
    scenario_id: str,
    puts: list[Put],
    more: str = "",
    look: str = "",
    place: str = "",
) -> tuple[Any, list[Any]]:
    """Publish live, and replay, on a stored scenario; asserts equal looks, and returns the report and the looks."""
    session = bench.post("/v1/sessions", {"scenario": scenario_id})["id"]
    name = bench.robot(session, more, look, place)
    report = bench.live(name, puts)
    looks = bench.looks(session)
    assert seen(looks) == seen(bench.replayed(capsys, name, puts, scenario_id))
    return report, looks


def finds_the_box(bench: Bench, session: str, yaw: str = "A") -> bool:
    state = bench.get(f"/v1/sessions/{session}")
    believed = dict(zip(state["poses"], state["belief"], strict=True))
    return bool(max(believed, key=lambda pose: believed[pose]) == yaw)


def at_the_stops(looks: list[Any], drive: Drive) -> bool:
    """True if there is exactly one look for each stop, taken at its place."""
    places = [entry["request"]["sensor_pose"] for entry in looks]
    return len(places) == len(drive.stops) and all(
        math.hypot(place["x"] - x, place["y"] - y) < 0.01 for place, (x, y, _) in zip(places, drive.stops, strict=True)
    )
