"""Filing of samples into a recording: topics, types, times, and counts of what others cannot read."""

import json
from collections import Counter
from io import BytesIO
from typing import Any

import pytest
from mcap.reader import make_reader

from tests.voa_recordings.files.bags import START_NS, laser_scan
from tests.voa_recordings.recorder.samples import NEXT, RMW, received
from voa_msgs.keys import Keys
from voa_recordings.files.json_text import STRING
from voa_recordings.files.ros_types import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE, RosTypes
from voa_recordings.files.writer import RecordingWriter
from voa_recordings.recorder.filing import Filing
from voa_recordings.recorder.inbox import FetchedDocument, ReceivedSample
from voa_ros.cdr import encode_laser_scan, encode_odometry, encode_pose
from voa_ros.messages import Odometry, Pose, PoseWithCovariance, Stamp
from voa_ros.topics import RmwAttachment

KEYS = Keys()
TYPES = RosTypes()
STAMP = Stamp(START_NS // 1_000_000_000, 5)
POSE = Pose.planar(1.0, 2.0, 0.5)
SCAN = encode_laser_scan(laser_scan([0.5] * 4, START_NS))
ODOM = encode_odometry(Odometry(STAMP, "odom", "base", POSE))
AMCL = encode_pose(PoseWithCovariance(STAMP, "map", POSE))


def filed(
    *items: ReceivedSample | FetchedDocument,
) -> tuple[list[tuple[str, str | None, Any]], list[str | None], Filing]:
    """Topic, type and message of each; the sessions that moved."""
    file = BytesIO()
    writer = RecordingWriter(file, TYPES)
    filing = Filing(writer, KEYS)
    moved = [filing.file(item) for item in items]
    writer.finish()
    file.seek(0)
    result = [(c.topic, s.name if s else None, m) for s, c, m in make_reader(file).iter_messages()]
    return result, moved, filing


@pytest.mark.parametrize(
    ("key", "payload", "topic", "type_name"),
    [
        ("tb3_1/scan", SCAN, "/tb3_1/scan", LASER_SCAN),
        ("tb3_1/odom", ODOM, "/tb3_1/odom", ODOMETRY),
        ("amcl_pose", AMCL, "/amcl_pose", POSE_WITH_COVARIANCE),
        (RMW, SCAN, "/tb3_1/scan", LASER_SCAN),
        ("0/tf/tf2_msgs::msg::dds_::TFMessage_/TypeHashNotSupported", b"\0\1\0\0", "/tf", "tf2_msgs/msg/TFMessage"),
        ("0/x/lab::msg::dds_::Own_/RIHS01_x", b"\0\1\0\0", "/x", "lab/msg/Own"),
        ("what/ever", b"\0\1\0\0", "/what/ever", None),
        ("a-b/c", SCAN, "/a-b/c", LASER_SCAN),
    ],
)
def test_a_ros_sample_gets_its_topic_and_type(key: str, payload: bytes, topic: str, type_name: str | None) -> None:
    result, moved, filing = filed(received(key, payload))
    assert [(name, kind, message.data) for name, kind, message in result] == [(topic, type_name, payload)]
    assert moved == [None]
    assert filing.unknown == ({"/what/ever": 1} if key == "what/ever" else {})


def test_the_type_that_a_bridge_announces_is_kept() -> None:
    file = BytesIO()
    writer = RecordingWriter(file, TYPES)
    filing = Filing(writer, KEYS, {"rb/imu": "sensor_msgs/msg/Imu", "rb/own": "lab/msg/Own"}.get)
    for key in ("rb/imu", "rb/own", "rb/else"):
        filing.file(received(key, b"\0\1\0\0"))
    writer.finish()
    file.seek(0)
    result = {c.topic: s and (s.name, s.encoding, bool(s.data)) for s, c, _ in make_reader(file).iter_messages()}
    assert result == {
        "/rb/imu": ("sensor_msgs/msg/Imu", "ros2msg", True),
        "/rb/own": ("lab/msg/Own", "", False),
        "/rb/else": None,
    }
    assert filing.unknown == {"/rb/else": 1}


def test_a_scan_is_one_however_many_beams_it_has_and_a_topic_keeps_its_type() -> None:
    large = encode_laser_scan(laser_scan([0.5] * 5_521, START_NS, angle_increment=0.001))
    broken = bytes(SCAN[:-30])
    result, _, filing = filed(received("rb/scan", large), received("rb/scan", broken), received("rb/scan", SCAN))
    assert [kind for _, kind, _ in result] == [LASER_SCAN] * 3
    assert filing.beams == {"/rb/scan": 5_521}


def test_a_type_that_becomes_known_is_recorded_from_then_on() -> None:
    result, _, filing = filed(received("rb/scan", b"\0\1\0\0"), received("rb/scan", SCAN))
    assert [kind for _, kind, _ in result] == [None, LASER_SCAN]
    assert filing.unknown == {"/rb/scan": 1}


def test_a_definition_with_another_hash_is_not_passed_off_as_the_sender_s() -> None:
    type_name, right = "sensor_msgs/msg/Imu", TYPES.store.hash_rihs01("sensor_msgs/msg/Imu")
    for content, is_defined in ((right, True), ("TypeHashNotSupported", True), (f"RIHS01_{'0' * 64}", False)):
        assert (TYPES.definition(type_name, content) is not None) == is_defined


def test_when_it_was_sent_says_who_knows_best() -> None:
    attachment = RmwAttachment(2**32 + 3, START_NS + 7, bytes(16)).encode()
    result, _, _ = filed(
        received(RMW, SCAN, attachment=attachment, sent_ns=START_NS + 9),
        received(RMW, SCAN, attachment=attachment),
        received(RMW, SCAN),
        received("what/ever", b"x"),
    )
    assert sorted((m.publish_time, m.sequence) for _, _, m in result) == [
        (START_NS, 0),
        (START_NS + 7, 3),
        (START_NS + 9, 3),
        (NEXT, 0),
    ]


def test_what_is_below_the_root_gets_the_session_s_topics() -> None:
    result, moved, _ = filed(
        received(KEYS.belief("s1"), b"{}"),
        received(KEYS.belief("s1"), deleted=True),
        received(KEYS.scan("s1", "r1"), b"{}", attachment=b'{"key": "secret", "sensor": "Q1"}'),
        received(KEYS.scan("s1", "r1"), b"{}", attachment=b'{"key": "secret"}'),
        received(KEYS.scan("s1", "r1"), SCAN, attachment=b"no JSON"),
        received(KEYS.refused("s1", "r1"), b"{}"),
        received(f"{KEYS.root}/other/s1", b"{}"),
        FetchedDocument("s1", "history", b"{}", NEXT, NEXT),
    )
    assert Counter((topic, kind) for topic, kind, _ in result) == {
        ("/voa/s1/belief", STRING): 1,
        ("/voa/s1/deleted", STRING): 1,
        ("/voa/s1/scan", STRING): 2,
        ("/voa/s1/laser_scan", LASER_SCAN): 1,
        ("/voa/s1/scan_attachment", STRING): 1,
        ("/voa/s1/refused", STRING): 1,
        ("/voa/s1/history", STRING): 1,
    }
    assert len({topic for topic, _, _ in result}) == 7, "ROS 2's tools expect one type on a topic"
    (beside,) = [message.data for topic, _, message in result if topic.endswith("attachment")]
    text: Any = TYPES.store.deserialize_cdr(beside, STRING)
    assert json.loads(text.data) == {"sensor": "Q1"}
    assert moved == ["s1"] + [None] * 7


@pytest.mark.parametrize("attachment", [b"[" * 100_000, b"9" * 5_000, b"\xff", b"{", b'"key"'])
def test_an_attachment_that_is_none_of_the_service_s_ends_no_recording(attachment: bytes) -> None:
    kept, _, _ = filed(received(KEYS.scan("s", "r"), b"{}", attachment=attachment))
    assert len(kept) == 1
