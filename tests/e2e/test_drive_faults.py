"""Lidars that are mounted or set up in unusual ways: upside down, several frames, wrong headers, another domain."""

import random
from dataclasses import replace

import pytest

from tests.support.drive_bench import Bench, at_the_stops, both, finds_the_box
from tests.support.drives import Change, Drive, around, published
from tests.support.lidar_drivers import DRIVERS
from tests.support.waiting import wait_for
from voa_ros.messages import LaserScan
from voa_ros.topics import rmw_key


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
