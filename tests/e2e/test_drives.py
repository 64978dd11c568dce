"""Lidars of every make, parked and driving past five stops, live through a router and by replay: one look a stop."""

import json
import math
import os
import random
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest
from zenoh import CongestionControl

from tests.support.bus import Stranger, stranger
from tests.support.drives import (
    ODOM,
    SCAN,
    START_S,
    Change,
    Drive,
    Put,
    around,
    box,
    published,
    record,
    restamped,
    scenario,
)
from tests.support.lidar_drivers import DRIVERS, flicker, lost_packets
from tests.support.routers import Router, router
from tests.support.waiting import wait_for
from tests.voa_cli.labs import Lab, service_on
from voa_cli.main import main
from voa_msgs.sessions import ScanRequest
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes
from voa_ros.messages import LaserScan, Stamp
from voa_ros.topics import LASER_SCAN, ODOMETRY, rmw_key

BY_ODOMETRY = 'from = "odometry"\nstd = { xy_m = 0.003, yaw_rad = 0.005 }'
SECONDS = 60.0


class Bench:
    """A service on a router whose mapping can be changed, and a stranger that publishes."""

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
        """Store the scenario of the box."""
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
                # The stub says bool; it is an object whose `matching` tells.
                wait_for(lambda own=publisher: own.matching_status.matching, "the topic to be subscribed to")  # type: ignore[misc]
        wait_for(lambda: all(self.report(name) for name in names), "the mapping")
        return names

    def report(self, name: str) -> Any:
        found = [each for each in self.get("/v1/robots")["items"] if (each["robot"], each["source"]) == (name, "ros2")]
        return found[0] if found else None

    def put(self, key: str, payload: bytes) -> None:
        """Publish faster than any robot, and wait rather than drop."""
        self.bus.session.put(key, payload, congestion_control=CongestionControl.BLOCK)

    def live(self, name: str, puts: list[Put]) -> Any:
        """Publish as a bridge does, as fast as that goes; returns the report when every scan has been worked on."""
        for put in puts:
            self.put(f"{name}/{put.topic}", put.payload)
        return self.worked_on(name, puts)

    def in_time(self, robots: dict[str, list[Put]]) -> None:
        """Publish what several robots say, at the times at which it arrives."""
        puts = sorted(
            ((put, name) for name, of_robot in robots.items() for put in of_robot), key=lambda each: each[0].at_s
        )
        began, never = time.monotonic(), threading.Event()
        for put, name in puts:
            never.wait(max(0.0, put.at_s - START_S - (time.monotonic() - began)))
            self.put(f"{name}/{put.topic}", put.payload)

    def worked_on(self, name: str, puts: list[Put]) -> Any:
        """The robot's report when every scan has been worked on."""
        scans = sum(put.type == LASER_SCAN for put in puts)
        wait_for(lambda: self.report(name)["scans"] == scans, f"{scans} scans of {name}", SECONDS)
        return self.report(name)

    def replayed(self, capsys: pytest.CaptureFixture[str], name: str, puts: list[Put], scenario_id: str) -> list[Any]:
        """Replay what a robot published, with the mapping in force; returns the looks of its session."""
        own = [put._replace(topic=f"{name}/{put.topic}") for put in puts]
        path = record(self.folder / f"drive-{next(self._names)}.mcap", own)
        options = ["--scenario", scenario_id, "--robots", str(self.mapping), "--url", self.lab.url, "--json"]
        code = main(["replay", str(path), *options])
        out, err = capsys.readouterr()
        assert code == 0, err
        (session,) = [each["session"] for each in json.loads(out)["robots"] if each["robot"] == name]
        return self.looks(session)

    def looks(self, session: str) -> list[Any]:
        """The looks in a session's history."""
        items = self.get(f"/v1/sessions/{session}/history?limit=100")["items"]
        return [entry for entry in items if entry["kind"] == "scan"]


@pytest.fixture(scope="module")
def own_router() -> Iterator[Router]:
    with router() as own:
        yield own


@contextmanager
def benches(folder: Path, own_router: Router) -> Iterator[Bench]:
    mapping = folder / "robots.toml"
    mapping.write_text("")
    with (
        service_on(own_router, folder, ["--robots", str(mapping)]) as lab,
        stranger(own_router.endpoint) as bus,
    ):
        yield Bench(lab, bus, folder)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory, own_router: Router) -> Iterator[Bench]:
    with benches(tmp_path_factory.mktemp("bench"), own_router) as own:
        yield own


def seen(looks: list[Any]) -> list[Any]:
    """Ranges of each look, and the place it was taken from."""
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
    """Do as `both` does, on a scenario that is stored."""
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
    """Whether there is one look for each stop, taken there."""
    places = [entry["request"]["sensor_pose"] for entry in looks]
    return len(places) == len(drive.stops) and all(
        math.hypot(place["x"] - x, place["y"] - y) < 0.01 for place, (x, y, _) in zip(places, drive.stops, strict=True)
    )


LAYOUTS = [(name, hz) for name, driver in DRIVERS.items() for hz in driver.rates_hz]


@pytest.mark.parametrize(("name", "hz"), LAYOUTS)
def test_five_stops_are_five_looks(bench: Bench, capsys: pytest.CaptureFixture[str], name: str, hz: float) -> None:
    drive = Drive(around(5), driving_s=1.0)
    if DRIVERS[name].messages_per_turn > 1:
        drive = Drive(around(2), standing_s=1.0, driving_s=0.5)
    report, looks = both(bench, capsys, DRIVERS[name].preset, published(drive, DRIVERS[name], hz))
    assert at_the_stops(looks, drive), report
    assert report["last_look"]["accepted"]
    assert finds_the_box(bench, report["session"])


@pytest.mark.parametrize("name", ["lds-02", "ld19", "ydlidar-x4"])
def test_a_parked_robot_is_one_look(bench: Bench, capsys: pytest.CaptureFixture[str], name: str) -> None:
    drive = Drive(around(1), standing_s=20.0)
    report, looks = both(bench, capsys, name, published(drive, DRIVERS[name], 10.0))
    assert at_the_stops(looks, drive)
    assert report["waiting_for"] == "the robot to move on: this stop's look is taken"
    assert finds_the_box(bench, report["session"])


def flickering(share: float, value: float) -> Change:
    rng = np.random.default_rng(7)
    return lambda _, scan: flicker(scan, share, rng, value)


def losing(share: float) -> Change:
    rng = np.random.default_rng(7)
    return lambda _, scan: lost_packets(scan, share, rng)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("lds-01", losing(0.3)),
        ("lds-01", flickering(0.5, 0.0)),
        ("ld19", flickering(0.5, math.inf)),
        ("lds-02", flickering(0.3, math.inf)),
    ],
)
def test_beams_that_answer_now_and_then(
    bench: Bench, capsys: pytest.CaptureFixture[str], name: str, change: Change
) -> None:
    drive = Drive(around(3))
    report, looks = both(bench, capsys, name, published(drive, DRIVERS[name], 5.0, change=change))
    assert at_the_stops(looks, drive), report
    assert finds_the_box(bench, report["session"])


def shifted(stamp: Stamp, seconds: float) -> Stamp:
    return Stamp.of(max(0.0, stamp.seconds + seconds))


def set_back(at_s: float, seconds: float) -> Callable[[Stamp], Stamp]:
    return lambda stamp: shifted(stamp, -seconds if stamp.seconds > START_S + at_s else 0.0)


CLOCKS: list[tuple[str, Callable[[Stamp], Stamp], bool]] = [
    ("without a clock", lambda _: Stamp(), True),
    ("without a clock, and the odometry with one", lambda _: Stamp(), False),
    ("frozen", lambda _: Stamp(77, 7), True),
    ("frozen, and the odometry's runs", lambda _: Stamp(77, 7), False),
    ("set back by 3 s while driving", set_back(4.0, 3.0), True),
    ("set back by 100 s while parked", set_back(1.0, 100.0), True),
    ("the scan's alone is set back by 100 s", set_back(6.0, 100.0), False),
    (
        "of a simulation that starts again",
        lambda stamp: shifted(stamp, -START_S - (7.0 if stamp.seconds > 1007.0 else 0.0)),
        True,
    ),
    ("another one than the odometry's", lambda stamp: shifted(stamp, 1.7e9), False),
]


def test_no_look_is_lost_because_of_a_clock(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    drive = Drive(around(3), standing_s=2.8, driving_s=1.4)
    scenario_id = bench.scenario("lds-02")
    right = published(drive, DRIVERS["lds-02"], 5.0)
    sessions = [bench.post("/v1/sessions", {"scenario": scenario_id})["id"] for _ in CLOCKS]
    names = bench.robots(sessions)
    puts = {name: restamped(right, clock, odometry=both) for name, (_, clock, both) in zip(names, CLOCKS, strict=True)}
    bench.in_time(puts)
    for name, session, (what, _, _) in zip(names, sessions, CLOCKS, strict=True):
        report = bench.worked_on(name, puts[name])
        looks = bench.looks(session)
        assert at_the_stops(looks, drive), (what, report)
        assert finds_the_box(bench, session), what
        assert seen(looks) == seen(bench.replayed(capsys, name, puts[name], scenario_id)), what


def test_a_look_that_is_not_accepted_does_not_use_up_the_stop(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    def spinning_up(number: int, scan: LaserScan) -> LaserScan:
        return replace(scan, ranges=(0.0,) * len(scan.ranges)) if number < 10 else scan

    drive = Drive(around(1), standing_s=8.0)
    refused = bench.bus.hear(bench.bus.keys.refused("*", "*"))
    puts = published(drive, DRIVERS["lds-01"], 5.0, change=spinning_up)
    report, looks = both(bench, capsys, "lds-01", puts)
    assert at_the_stops(looks, drive)
    assert finds_the_box(bench, report["session"])
    assert (report["looks"], report["refused"]) == (2, 1)
    assert report["last_refusal"].startswith("not-accepted: ")
    assert "no_beams" in report["last_refusal"]
    (problem,) = wait_for(lambda: [each for each in refused if report["session"] in each.key], "the refusal")
    assert (problem.json["type"], problem.json["reason"]) == ("urn:voa:problem:not-accepted", "no_beams")


def test_an_upside_down_lidar_sees_the_scene_as_it_is(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    def mirrored(_: int, scan: LaserScan) -> LaserScan:
        return replace(scan, ranges=scan.ranges[:1] + scan.ranges[:0:-1])  # beam i of a full turn from 0 points to -i

    drive = Drive(around(2))
    puts = published(drive, DRIVERS["lds-01"], 5.0, yaw="C", change=mirrored)
    report, looks = both(bench, capsys, "lds-01", puts, "lidar = { upside_down = true }")
    assert at_the_stops(looks, drive)
    assert finds_the_box(bench, report["session"], "C")


@pytest.mark.parametrize("frame", ["", 'frame_id = "echo_0"'])
def test_echoes_on_one_topic(bench: Bench, capsys: pytest.CaptureFixture[str], frame: str) -> None:
    rng = random.Random(1)  # noqa: S311  # noise, not a secret

    def echo(number: int, scan: LaserScan) -> LaserScan:
        if number % 3 == 0:
            return replace(scan, frame_id="echo_0")
        return replace(scan, frame_id=f"echo_{number % 3}", ranges=tuple(rng.uniform(0.2, 2.0) for _ in scan.ranges))

    drive = Drive(around(1), standing_s=4.0)
    report, looks = both(bench, capsys, "lds-01", published(drive, DRIVERS["lds-01"], 15.0, change=echo), frame)
    if frame:
        assert at_the_stops(looks, drive)
        assert finds_the_box(bench, report["session"])
    else:
        assert looks == []
        assert "scans of 3 frames" in report["last_refusal"]
        assert report["waiting_for"] == "scans of one frame"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda _, scan: replace(scan, angle_increment=-scan.angle_increment), "angle_min 0 and angle_max"),
        (lambda _, scan: replace(scan, angle_increment=1.0, angle_max=359.0), "57.3 turns"),
    ],
)
def test_headers_that_contradict_themselves_are_refused(
    bench: Bench, capsys: pytest.CaptureFixture[str], change: Change, says: str
) -> None:
    puts = published(Drive(around(1), standing_s=4.0), DRIVERS["lds-01"], 5.0, change=change)
    report, looks = both(bench, capsys, "lds-01", puts)
    assert looks == []
    assert report["last_refusal"].startswith("beam-grid-mismatch: ")
    assert says in report["last_refusal"]
    assert report["waiting_for"] == "a scan that can be used"


@pytest.mark.parametrize(("domain", "yaw"), [("", "A"), ("domain = 7", "C")])
def test_only_the_mapped_domain_is_listened_to(bench: Bench, domain: str, yaw: str) -> None:
    session = bench.post("/v1/sessions", {"scenario": bench.scenario("lds-02")})["id"]
    name = bench.robot(session, domain)
    drive = Drive(around(1), standing_s=4.0)
    ours = published(drive, DRIVERS["lds-02"], 5.0, yaw="A")
    others = published(drive, DRIVERS["lds-02"], 5.0, yaw="C", seed=2)
    for number, puts in ((0, ours), (7, others)):
        for put in puts:
            bench.put(rmw_key(f"{name}/{put.topic}", put.type, number), put.payload)
    wait_for(lambda: bench.looks(session), "the look")
    assert finds_the_box(bench, session, yaw)
    assert len(bench.looks(session)) == 1


def test_every_scan_of_a_parked_robot_gets_a_warning(bench: Bench, capsys: pytest.CaptureFixture[str]) -> None:
    puts = published(Drive(around(1), standing_s=4.0), DRIVERS["lds-02"], 5.0)
    report, looks = both(bench, capsys, "lds-02", puts, look='{ mode = "every" }')
    assert len(looks) >= 20
    assert report["warnings"][0]["kind"] == "every-while-parked"


CASES = Path(os.environ.get("VOA_CASES", Path(__file__).resolve().parents[3] / "shared" / "cases")) / "lidar"
needs_cases = pytest.mark.skipif(not CASES.is_dir(), reason=f"no recordings at {CASES}; VOA_CASES names another place")
EAST = 'from = "sensor"\nsensor = "E"'
UPSIDE_DOWN = "lidar = { upside_down = true }"


@needs_cases
@pytest.mark.parametrize(
    ("name", "yaw", "more", "place"),
    [
        ("02-beam-count-varies.mcap", "A", "", EAST),
        ("05-zeros-while-spinning-up.mcap", "A", "", ""),
        ("07-upside-down.mcap", "A", UPSIDE_DOWN, ""),
        ("08-increment-sign.mcap", "", "", ""),
        ("09-degrees.mcap", "", "", EAST),
        ("11-three-echoes.mcap", "", "", ""),
        ("11-three-echoes.mcap", "A", 'frame_id = "world_1_0"', ""),
        ("12-inf-flicker.mcap", "A", "", EAST),
        ("14-storage-renamed", "A", "", EAST),
        ("15-metadata-empty", "A", "", EAST),
        ("16-second-part-missing", "A", "", EAST),
        ("17-killed-recorder", "A", "", EAST),
        ("18-ros1.bag", "A", "", EAST),
        ("20-dropped-packets.mcap", "A", "", EAST),
        ("21-topic-by-topic.mcap", "A", "", ""),
    ],
)
def test_a_recording_gives_the_same_looks_live_and_by_replay(
    bench: Bench, capsys: pytest.CaptureFixture[str], name: str, yaw: str, more: str, place: str
) -> None:
    files = {"file": ("box.obj", (CASES / "box.obj").read_bytes())}
    stored = httpx2.post(f"{bench.lab.url}/v1/objects", files=files, timeout=SECONDS).json()["id"]
    scenario_id = bench.post("/v1/scenarios", json.loads((CASES / "scenario.json").read_text()) | {"object": stored})[
        "id"
    ]
    types = {LASER_SCAN.name: LASER_SCAN, ODOMETRY.name: ODOMETRY}
    puts = [
        Put(message.log_ns * 1e-9, message.topic.strip("/"), types[message.type_name], message.data)
        for message in Recording(CASES / name, RosTypes()).messages()
    ]
    report, looks = both_on(bench, capsys, scenario_id, puts, more, place=place)
    assert len(looks) == (1 if yaw else 0), report
    if yaw:
        assert finds_the_box(bench, report["session"], yaw)
