"""`voa record` beside publishers that keep their newest message, such as AMCL."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import zenoh
import zenoh.ext

from tests.support.routers import Router, router
from tests.support.waiting import wait_for
from tests.voa_recordings.recorders import messages, recording
from voa_client import ZenohAddress
from voa_client.zenoh_session import joined
from voa_msgs.keys import Keys
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes
from voa_ros.cdr import encode_pose
from voa_ros.messages import Pose, PoseWithCovariance, Stamp
from voa_ros.topics import POSE_WITH_COVARIANCE_STAMPED, rmw_key

BEFORE, NEWEST, LATER = (
    encode_pose(PoseWithCovariance(Stamp(second), "map", Pose.planar(0.3, second / 10, 0.0))) for second in (1, 2, 3)
)
KEYS = {"bridge": "rb/amcl_pose", "rmw_zenoh": rmw_key("rb/amcl_pose", POSE_WITH_COVARIANCE_STAMPED)}


@pytest.fixture(scope="module")
def own_router() -> Iterator[Router]:
    with router() as own:
        yield own


@contextmanager
def latched(session: zenoh.Session, key: str, *, numbered: bool) -> Iterator[Any]:
    """A publisher that keeps its newest message; named by a number, or by its time alone."""
    numbers = zenoh.ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=None) if numbered else None
    publisher: Any = zenoh.ext.declare_advanced_publisher(
        session,
        key,
        cache=zenoh.ext.CacheConfig(max_samples=1),
        publisher_detection=True,
        sample_miss_detection=numbers,
    )
    try:
        yield publisher
    finally:
        publisher.undeclare()


OVERLAPPING = ["/rb/**", "/rb/amcl_pose", "/*/amcl_pose"]


@pytest.mark.parametrize(
    ("puts", "topics", "numbered"),
    [
        ("bridge", ["/rb/amcl_pose"], True),
        ("bridge", ["/rb/**"], False),
        ("bridge", OVERLAPPING, True),
        ("rmw_zenoh", ["/rb/amcl_pose"], False),
        ("rmw_zenoh", OVERLAPPING, True),
    ],
)
def test_a_latched_pose_from_before_is_recorded_once(
    own_router: Router, tmp_path: Path, puts: str, topics: list[str], numbered: bool
) -> None:
    path = tmp_path / "latched.mcap"
    options = [word for topic in topics for word in ("--topic", topic)]
    more = {"timestamping/enabled": True}
    with (
        joined(ZenohAddress.parse(own_router.endpoint), more=more) as robot,
        latched(robot, KEYS[puts], numbered=numbered) as amcl,
    ):
        amcl.put(BEFORE)
        amcl.put(NEWEST)
        with recording(path, "--url", own_router.endpoint, *options) as recorder:
            wait_for(lambda: poses(path) == [NEWEST], "the latched pose is recorded")
            amcl.put(LATER)
            wait_for(lambda: LATER in poses(path), "the later pose is recorded")
            recorder.stop(signal.SIGINT)
    assert poses(path) == [NEWEST, LATER]
    assert [topic for topic, _, _ in messages(path)] == ["/rb/amcl_pose"] * 2


def poses(path: Path) -> list[bytes]:
    return [message.data for message in Recording(path, RosTypes()).messages() if message.topic == "/rb/amcl_pose"]


def test_what_is_kept_on_the_keys_of_the_service_is_not_fetched(own_router: Router, tmp_path: Path) -> None:
    path = tmp_path / "own.mcap"
    with (
        joined(ZenohAddress.parse(own_router.endpoint)) as robot,
        latched(robot, Keys().scan("s1", "r1"), numbered=True) as kept,
        latched(robot, KEYS["bridge"], numbered=True) as amcl,
    ):
        kept.put(b"{}")
        amcl.put(NEWEST)
        with recording(path, "--url", own_router.endpoint, "--topic", "/rb/amcl_pose", "--topic", "**") as recorder:
            wait_for(lambda: poses(path) == [NEWEST], "the latched pose is recorded")
            recorder.stop(signal.SIGINT)
    assert [topic for topic, _, _ in messages(path)] == ["/rb/amcl_pose"]
