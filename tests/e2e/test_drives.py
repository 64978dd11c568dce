"""Lidars of every make, parked and driving past five stops, live through a router and by replay: one look a stop."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.support.drive_bench import Bench, at_the_stops, both, finds_the_box, seen
from tests.support.drives import START_S, Change, Drive, around, published, restamped
from tests.support.lidar_drivers import DRIVERS, flicker, lost_packets
from tests.support.waiting import wait_for
from voa_ros.messages import LaserScan, Stamp

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
    refused = bench.bus.subscribe(bench.bus.keys.refused("*", "*"))
    puts = published(drive, DRIVERS["lds-01"], 5.0, change=spinning_up)
    report, looks = both(bench, capsys, "lds-01", puts)
    assert at_the_stops(looks, drive)
    assert finds_the_box(bench, report["session"])
    assert (report["looks"], report["refused"]) == (2, 1)
    assert report["last_refusal"].startswith("not-accepted: ")
    assert "no_beams" in report["last_refusal"]
    (problem,) = wait_for(lambda: [each for each in refused if report["session"] in each.key], "the refusal")
    assert (problem.json["type"], problem.json["reason"]) == ("urn:voa:problem:not-accepted", "no_beams")
