"""Mapped topics on a real router: `voa doctor` reports each reason for which scans are not used."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import zenoh
import zenoh.ext

from tests.support.lidar_drivers import DRIVERS, Scene
from tests.support.routers import Router
from tests.voa_doctor.publishing import Messages, publishing, scan, sent
from voa_client import ZenohAddress
from voa_client.zenoh_session import joined
from voa_doctor.findings import Budget, Finding
from voa_doctor.topics import Listening, check_topics
from voa_ros.cdr import encode_laser_scan, encode_odometry, encode_pose
from voa_ros.messages import LaserScan, Odometry, Pose, PoseWithCovariance, Stamp
from voa_ros.robots import load
from voa_ros.topics import LASER_SCAN, MessageType, rmw_key

SENSOR = '{ from = "sensor", sensor = "Q1" }'
ODOMETRY = '{ from = "odometry" }'
AMCL = '{ from = "amcl" }'
SCAN = "tb3_1 /tb3_1/scan"
KEY = "tb3_1/scan"
POINTS = MessageType("sensor_msgs/msg/PointCloud2", "RIHS01_x")
MOST = 4096


def findings(
    router: Router, more: str = "", place: str = SENSOR, seconds: float = 5.0, most_beams: int = MOST
) -> dict[str, Finding]:
    """Findings on the topics of one robot, by check."""
    robots = load(f'[[robot]]\nname = "tb3_1"\nsession = "s"\nplace = {place}\n{more}\n')
    with joined(ZenohAddress.parse(router.endpoint)) as session:
        result = list(check_topics(session, Listening(robots, seconds, most_beams), Budget(20.0)))
    assert all(bool(finding.advice) is (finding.state != "ok") for finding in result)
    return {finding.check: finding for finding in result}


def in_turn(key: str, scans: list[LaserScan]) -> Messages:
    """Scans of a driver one after the other, stamped now."""
    return sent(key, lambda step: replace(scans[step % len(scans)], stamp=Stamp.of(time.time())))


def driven(name: str) -> list[LaserScan]:
    room = Scene.room(1.5, [(0.0, 0.0, 0.1, 0.04, 0.0)])
    driver = DRIVERS[name]
    return driver.play(room, lambda _: (0.3, 0.2, 0.1), 20, driver.rates_hz[0], np.random.default_rng(3))


def each_twice(step: int) -> list[tuple[str, bytes]]:
    payload = encode_laser_scan(scan(step))
    return [(KEY, payload), (rmw_key(KEY, LASER_SCAN), payload)]


def echoes(step: int) -> list[tuple[str, bytes]]:
    at = Stamp.of(time.time())
    return [(KEY, encode_laser_scan(scan(step, frame_id=f"echo_{echo}", at=at))) for echo in range(3)]


def two_domains(step: int) -> list[tuple[str, bytes]]:
    keys = (rmw_key(KEY, LASER_SCAN, domain) for domain in (7, 0))
    return [(key, encode_laser_scan(scan(step + at))) for at, key in enumerate(keys)]


def shifted(seconds: float) -> Callable[[int], LaserScan]:
    return lambda step: scan(step, at=Stamp.of(time.time() + seconds))


NOW = Stamp.of(time.time())
SCANS = {
    "all is well": (sent(KEY, scan), "", "ok", "360 beams, stamped 0.", ""),
    "by rmw_zenoh": (sent(rmw_key(KEY, LASER_SCAN), scan), "", "ok", "360 beams, stamped 0.", ""),
    "each twice": (each_twice, "", "ok", "360 beams, stamped 0.", ""),
    "increment against angle_max": (
        sent(KEY, lambda step: scan(step, angle_increment=-0.01745)), "", "wrong",
        "angle_min 0 and angle_max 6.26573", "correct the driver's settings",
    ),
    "degrees": (
        sent(KEY, lambda step: scan(step, angle_increment=1.0, angle_max=359.0)), "", "wrong",
        "360 beams of angle_increment 1 rad are 57.3 turns", "correct the driver's settings",
    ),
    "frames, none said": (
        echoes, "", "wrong", "this topic has scans of 3 frames: 'echo_0', 'echo_1', 'echo_2'",
        'frame_id = "echo_0"',
    ),
    "frames, one said": (echoes, 'frame_id = "echo_1"', "ok", "360 beams, stamped 0.", ""),
    "frame that does not come": (
        echoes, 'frame_id = "front"', "wrong",
        "all scans are of frame 'echo_0', 'echo_1', 'echo_2', and the mapping says 'front'", "correct frame_id",
    ),
    "another domain": (
        sent(rmw_key(KEY, LASER_SCAN, 7), scan), "", "wrong",
        "messages arrive in ROS domain 7 only, but the mapping says 0", "set domain = 7",
    ),
    "two domains": (two_domains, "", "ok", "those of ROS domain 7 are ignored", ""),
    "the domain of the mapping": (two_domains, "domain = 7", "ok", "those of ROS domain 0 are ignored", ""),
    "stamps 0": (
        sent(KEY, lambda step: scan(step, at=Stamp())), "", "warning", "360 beams, stamped 0: no harm is done",
        "make the driver stamp",
    ),
    "stamps frozen": (
        sent(KEY, lambda step: scan(step, at=NOW)), "", "warning", "360 beams, and the stamp does not change",
        "make the driver stamp",
    ),
    "one message again and again": (
        sent(KEY, lambda _: scan(0, at=NOW)), "", "wrong", "the same message was received 8 times",
        "restart the driver",
    ),
    "stamps back and forth": (
        sent(KEY, lambda step: scan(step, at=Stamp.of(time.time() - step % 2))), "", "warning",
        "some stamps go back in time", "a single driver publishes",
    ),
    "simulated time": (
        sent(KEY, lambda step: scan(step, at=Stamp.of(40.0 + step / 5))), "", "warning", "simulated time",
        "use_sim_time",
    ),
    "a clock that is behind": (sent(KEY, shifted(-60.0)), "", "warning", "s before it was received", "NTP"),
    "a clock that is ahead": (sent(KEY, shifted(60.0)), "", "warning", "s after it was received", "NTP"),
    "no return": (
        sent(KEY, lambda step: scan(step, ranges=(0.0,) * 180 + (math.inf,) * 180)), "", "wrong",
        "no beam of 8 scans measures a distance", "check that the lidar turns",
    ),
    "too many beams": (
        sent(KEY, lambda step: scan(step, ranges=(0.5,) * 5521, angle_increment=0.001)), "", "wrong",
        "scans of 5521 beams: at most 4096 are allowed", "VOA_LIMITS__BEAMS=5521",
    ),
    "irregular beams": (in_turn(KEY, driven("lds-02")), "", "ok", "beams, irregular, stamped 0.", ""),
    "segments": (in_turn(KEY, driven("sick-picoscan150")), "", "ok", "beams, gathered into turns, stamped 0.", ""),
    "another type, by its key": (
        lambda _: [(rmw_key(KEY, POINTS), b"\0\1\0\0")], "", "wrong", "found a sensor_msgs/msg/PointCloud2",
        "expected a sensor_msgs/msg/LaserScan",
    ),
    "another type, by its bytes": (
        lambda _: [(KEY, encode_pose(PoseWithCovariance(NOW, "map", Pose.planar(0.0, 0.0, 0.0))))], "", "wrong",
        "found a geometry_msgs/msg/PoseWithCovarianceStamped", "correct the topic in the mapping",
    ),
    "no message at all": (
        lambda _: [(KEY, b"\0\1\0\0nonsense")], "", "wrong", "expected a sensor_msgs/msg/LaserScan",
        "correct the topic in the mapping",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", list(SCANS))
def test_scans(own_router: Router, case: str) -> None:
    messages, more, state, seen, advice = SCANS[case]
    with publishing(own_router, messages):
        result = findings(own_router, more)
    assert (result[SCAN].state, seen in result[SCAN].seen, advice in result[SCAN].advice) == (state, True, True), result


def test_scans_within_a_higher_limit_are_all_right(own_router: Router) -> None:
    with publishing(own_router, SCANS["too many beams"][0]):
        assert findings(own_router, most_beams=5521)[SCAN].seen.startswith("5521 beams, stamped 0.")


@pytest.mark.parametrize(
    ("at", "state", "seen"),
    [
        (lambda _: Stamp.of(time.time()), "ok", "received, stamped 0."),
        (lambda _: Stamp(), "warning", "received, stamped 0: scans are placed by the newest pose"),
        (lambda _: NOW, "warning", "received, and the stamp does not change: scans are placed by"),
    ],
)
def test_odometry(own_router: Router, at: Callable[[int], Stamp], state: str, seen: str) -> None:
    def messages(step: int) -> list[tuple[str, bytes]]:
        content = Odometry(at(step), "odom", "base", Pose.planar(step / 1000, 0.0, 0.0))
        return [("tb3_1/odom", encode_odometry(content)), (KEY, encode_laser_scan(scan(step)))]

    with publishing(own_router, messages):
        result = findings(own_router, place=ODOMETRY)
    assert result[SCAN].state == "ok"
    assert result["tb3_1 /tb3_1/odom"].state == state
    assert result["tb3_1 /tb3_1/odom"].seen.startswith(seen)


@contextmanager
def latched_pose(router: Router) -> Iterator[None]:
    """AMCL of a parked robot, which has published once."""
    with joined(ZenohAddress.parse(router.endpoint)) as robot:
        amcl: Any = zenoh.ext.declare_advanced_publisher(
            robot,
            "tb3_1/amcl_pose",
            cache=zenoh.ext.CacheConfig(max_samples=1),
            publisher_detection=True,
            sample_miss_detection=zenoh.ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=None),
        )
        amcl.put(encode_pose(PoseWithCovariance(Stamp.of(time.time() - 3600.0), "map", Pose.planar(0.3, 0.2, 0.0))))
        yield
        amcl.undeclare()


def test_a_latched_pose_is_fetched(own_router: Router) -> None:
    with latched_pose(own_router):
        result = findings(own_router, place=AMCL, seconds=2.0)
    assert result["tb3_1 /tb3_1/amcl_pose"].state == "ok"
    assert result["tb3_1 /tb3_1/amcl_pose"].seen.startswith("received; AMCL publishes when the robot has moved")
    assert result[SCAN].state == "wrong"


@contextmanager
def announced(router: Router, topic: str) -> Iterator[None]:
    """A node of rmw_zenoh that says that it publishes a topic of the robot, and is silent."""
    with joined(ZenohAddress.parse(router.endpoint)) as robot:
        token: Any = robot.liveliness().declare_token(
            f"@ros2_lv/0/zid/1/2/MP/%/%/driver/%tb3_1%{topic}/sensor_msgs::msg::dds_::LaserScan_/RIHS01_x/::"
        )
        yield
        token.undeclare()


def test_topics_on_which_nothing_comes(own_router: Router) -> None:
    assert findings(own_router, seconds=0.3)[SCAN].seen == "no message within 0.3 s"
    with announced(own_router, "scan"):
        assert "although a node announces that it publishes it" in findings(own_router, seconds=0.3)[SCAN].seen
        other = findings(own_router, 'namespace = "other"', seconds=0.3)["tb3_1 /other/scan"]
        assert "published are /tb3_1/scan" in other.seen
    with announced(own_router, "amcl_pose"):
        pose = findings(own_router, place=AMCL, seconds=0.3)["tb3_1 /tb3_1/amcl_pose"]
        assert "give AMCL its initial pose" in pose.advice
