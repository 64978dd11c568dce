"""Our bytes against those of `rosbags`, an implementation of its own; and bytes that are none."""

import struct
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from tests.voa_ros.ros_messages import ODOMETRY, POSES_WITH_COVARIANCE, odometry, scan, scans
from voa_ros.cdr import (
    InvalidCdr,
    decode_bool,
    decode_laser_scan,
    decode_odometry,
    decode_pose,
    encode_laser_scan,
    encode_odometry,
    encode_pose,
)
from voa_ros.messages import LaserScan, Odometry, Pose, PoseWithCovariance, Stamp

Message = LaserScan | Odometry | PoseWithCovariance
SCAN, ODOM, POSE = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseWithCovarianceStamped"
STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES: dict[str, Any] = dict(STORE.types)
DECODE: dict[str, Callable[[bytes], Message]] = {SCAN: decode_laser_scan, ODOM: decode_odometry, POSE: decode_pose}
ENCODE: dict[str, Callable[..., bytes]] = {SCAN: encode_laser_scan, ODOM: encode_odometry, POSE: encode_pose}
EXAMPLES: dict[str, Message] = {
    SCAN: scan(*[0.125 * beam for beam in range(24)], float("inf"), 0.5),
    ODOM: odometry(1.0, -2.0, 0.5),
    POSE: PoseWithCovariance(Stamp(3, 4), "map", Pose.planar(1.0, 2.0, 3.0), tuple(0.5 * i for i in range(36))),
}
BYTES = {name: ENCODE[name](message) for name, message in EXAMPLES.items()}


def _of(name: str, *fields: Any) -> Any:
    return TYPES[name](*fields)


def _header(message: Message) -> Any:
    stamp = _of("builtin_interfaces/msg/Time", message.stamp.sec, message.stamp.nanosec)
    return _of("std_msgs/msg/Header", stamp, message.frame_id)


def _vector(values: tuple[float, ...]) -> Any:
    return _of("geometry_msgs/msg/Vector3", *values)


def _pose(message: Odometry | PoseWithCovariance) -> Any:
    pose = _of(
        "geometry_msgs/msg/Pose",
        _of("geometry_msgs/msg/Point", *message.pose.position),
        _of("geometry_msgs/msg/Quaternion", *message.pose.quaternion_xyzw),
    )
    return _of("geometry_msgs/msg/PoseWithCovariance", pose, np.array(message.covariance))


def theirs(message: Message) -> Any:
    """Convert a message to an object of rosbags."""
    match message:
        case LaserScan():
            return _of(
                SCAN,
                _header(message),
                message.angle_min,
                message.angle_max,
                message.angle_increment,
                message.time_increment,
                message.scan_time,
                message.range_min,
                message.range_max,
                np.array(message.ranges, np.float32),
                np.array(message.intensities, np.float32),
            )
        case Odometry():
            twist = _of("geometry_msgs/msg/Twist", _vector(message.twist.linear), _vector(message.twist.angular))
            both = _of("geometry_msgs/msg/TwistWithCovariance", twist, np.array(message.twist_covariance))
            return _of(ODOM, _header(message), message.child_frame_id, _pose(message), both)
        case PoseWithCovariance():
            return _of(POSE, _header(message), _pose(message))


ANY = st.one_of(
    st.tuples(st.just(SCAN), scans()),
    st.tuples(st.just(ODOM), ODOMETRY),
    st.tuples(st.just(POSE), POSES_WITH_COVARIANCE),
)


@given(ANY, st.booleans())
def test_our_bytes_are_those_of_rosbags(named: tuple[str, Message], little_endian: bool) -> None:
    name, message = named
    expected = bytes(STORE.serialize_cdr(theirs(message), name, little_endian=little_endian))
    assert ENCODE[name](message, little_endian=little_endian) == expected


@given(ANY, st.booleans(), st.integers(0, 7))
def test_we_read_what_rosbags_wrote_whatever_the_padding(
    named: tuple[str, Message], little_endian: bool, padding: int
) -> None:
    name, message = named
    data = bytes(STORE.serialize_cdr(theirs(message), name, little_endian=little_endian)) + bytes(padding)
    assert repr(DECODE[name](data)) == repr(message)  # as text: NaN is not equal to itself


@given(ANY)
def test_rosbags_reads_what_we_wrote(named: tuple[str, Message]) -> None:
    name, message = named
    again = STORE.deserialize_cdr(ENCODE[name](message), name)
    assert repr(again) == repr(theirs(message))


@pytest.mark.parametrize("name", DECODE)
def test_a_message_cut_anywhere_is_refused(name: str) -> None:
    for length in range(len(BYTES[name])):
        with pytest.raises(InvalidCdr, match="expected"):
            DECODE[name](BYTES[name][:length])


@pytest.mark.parametrize("expected", list(DECODE))
@pytest.mark.parametrize("sent", list(DECODE))
def test_a_message_of_another_type_is_refused(sent: str, expected: str) -> None:
    if sent == expected:
        assert DECODE[expected](BYTES[sent]) == EXAMPLES[expected]
        return
    with pytest.raises(InvalidCdr, match=f"expected a {expected}, found a {sent}"):
        DECODE[expected](BYTES[sent])


@given(st.sampled_from(list(DECODE)), ANY)
def test_any_message_of_another_type_is_refused(expected: str, named: tuple[str, Message]) -> None:
    name, message = named
    if name == expected:
        assert type(DECODE[expected](ENCODE[name](message))) is type(message)
    else:
        with pytest.raises(InvalidCdr):
            DECODE[expected](ENCODE[name](message))


@pytest.mark.parametrize("name", DECODE)
@given(data=st.one_of(st.binary(max_size=400), st.binary(max_size=400).map(lambda tail: b"\x00\x01\x00\x00" + tail)))
def test_random_bytes_raise_nothing_else(name: str, data: bytes) -> None:
    try:
        message = DECODE[name](data)
    except InvalidCdr:
        return
    assert ENCODE[name](message)


@pytest.mark.parametrize("name", DECODE)
@given(data=st.data())
def test_flipped_bytes_raise_nothing_else(name: str, data: st.DataObject) -> None:
    changed = bytearray(BYTES[name])
    for _ in range(data.draw(st.integers(1, 8))):
        changed[data.draw(st.integers(0, len(changed) - 1))] = data.draw(st.integers(0, 255))
    try:
        message = DECODE[name](bytes(changed))
    except InvalidCdr:
        return
    assert type(message) is type(EXAMPLES[name])


def _scan_with(frame: bytes, length: int, tail: bytes) -> bytes:
    head = b"\x00\x01\x00\x00" + struct.pack("<iII", 1, 2, length) + frame
    return head + bytes(-len(frame) % 4) + tail


FIELDS = struct.pack("<7f", 0.0, 6.25, 0.0175, 0.0, 0.2, 0.125, 3.5)


@pytest.mark.parametrize("lie", [3, 4, 1_000, 2**31, 2**32 - 1])
def test_a_length_that_lies_takes_no_memory(lie: int) -> None:
    two = struct.pack("<2f", 1.0, 2.0)
    wrong = [
        _scan_with(b"laser\0", max(lie, 1_000), FIELDS),
        _scan_with(b"laser\0", 6, FIELDS + struct.pack("<I", lie) + two),
        _scan_with(b"laser\0", 6, FIELDS + struct.pack("<I", 2) + two + struct.pack("<I", lie)),
    ]
    tracemalloc.start()
    try:
        for data in wrong:
            with pytest.raises(InvalidCdr, match="expected"):
                decode_laser_scan(data)
        assert tracemalloc.get_traced_memory()[1] < 200_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"", "header of 4 bytes"),
        (b"\x00\x02\x00\x00" + bytes(40), "plain CDR"),
        (b"\x00\x03\x00\x00" + bytes(40), "plain CDR"),
        (b"\x00\x07\x00\x00" + bytes(40), "plain CDR"),
        (_scan_with(b"laser!", 6, FIELDS), "ends with a NUL"),
        (_scan_with(b"la\0er\0", 6, FIELDS), "without a NUL inside"),
        (_scan_with(b"\xff\xfe\xfd\0", 4, FIELDS), "UTF-8"),
        (BYTES[SCAN] + bytes(8), "to end after"),
        (_scan_with(b"laser\0", 6, FIELDS + bytes(8)), "at least one beam"),
    ],
)
def test_a_refusal_says_what_was_expected(data: bytes, expected: str) -> None:
    with pytest.raises(InvalidCdr, match=expected):
        decode_laser_scan(data)


def test_more_beams_than_allowed_are_refused() -> None:
    assert len(decode_laser_scan(BYTES[SCAN], most_beams=26).ranges) == 26
    with pytest.raises(InvalidCdr, match="ranges: expected at most 25 values, got 26"):
        decode_laser_scan(BYTES[SCAN], most_beams=25)


@pytest.mark.parametrize(
    "change",
    [
        {"angle_min": float("nan")},
        {"angle_min": float("inf")},
        {"angle_min": 1e30},
        {"angle_increment": 0.0},
        {"angle_increment": 1e-40},
        {"angle_increment": float("nan")},
        {"angle_increment": 7.0},
        {"range_min": float("nan")},
        {"range_max": float("nan")},
        {"range_min": -1.0},
        {"range_min": 4.0},
        {"range_min": float("inf"), "range_max": float("inf")},
        {"ranges": ()},
    ],
)
def test_a_scan_that_no_driver_would_mean_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(change))}.*: expected"):
        replace(scan(1.0), **change)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (SCAN, replace(scan(1.0), frame_id="a\0b")),
        (SCAN, replace(scan(1.0), frame_id="\ud800")),
        (SCAN, scan(1e39)),
        (SCAN, replace(scan(1.0), stamp=Stamp(2**31, 0))),
        (POSE, PoseWithCovariance(Stamp(), "map", Pose.planar(0.0, 0.0, 0.0), (0.0,) * 35)),
    ],
)
def test_what_has_no_bytes_is_refused(name: str, message: Message) -> None:
    with pytest.raises(InvalidCdr, match="expected"):
        ENCODE[name](message)


@given(st.floats(-3.14, 3.14))
def test_a_planar_pose_has_its_yaw(yaw_rad: float) -> None:
    assert Pose.planar(1.0, 2.0, yaw_rad).yaw_rad == pytest.approx(yaw_rad, abs=1e-12)


@pytest.mark.parametrize("quaternion", [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 1.0), (float("nan"), 0.0, 0.0, 1.0)])
def test_an_orientation_is_a_unit_quaternion(quaternion: tuple[float, float, float, float]) -> None:
    with pytest.raises(ValueError, match="orientation: expected"):
        Pose((0.0, 0.0, 0.0), quaternion)


@pytest.mark.parametrize("x", [float("nan"), float("inf"), 1e6])
def test_a_position_is_in_metres(x: float) -> None:
    with pytest.raises(ValueError, match="position: expected"):
        Pose.planar(x, 0.0, 0.0)


@given(st.integers(-(2**31), 2**31 - 1), st.integers(0, 999_999))
def test_a_stamp_in_seconds_is_good_to_a_microsecond(sec: int, microsec: int) -> None:
    assert Stamp.of(Stamp(sec, microsec * 1_000).seconds).seconds == pytest.approx(sec + microsec / 1e6, abs=1e-6)
    with pytest.raises(ValueError, match="nanosec: expected"):
        Stamp(sec, 1_000_000_000)


@pytest.mark.parametrize("value", [True, False])
@pytest.mark.parametrize("little_endian", [True, False])
def test_a_bool_of_rosbags_is_read(value: bool, little_endian: bool) -> None:
    message = TYPES["std_msgs/msg/Bool"](data=value)
    data = bytes(STORE.serialize_cdr(message, "std_msgs/msg/Bool", little_endian=little_endian))
    assert decode_bool(data) is value
    assert decode_bool(data + b"\0\0\0") is value, "padding"


@pytest.mark.parametrize(
    "data", [b"", b"\0\1\0\0", b"\0\1\0\0\2", b"\0\2\0\0\1", BYTES[POSE], b"\0\1\0\0\1" + bytes(8)]
)
def test_other_bytes_are_no_bool(data: bytes) -> None:
    with pytest.raises(InvalidCdr, match="expected a std_msgs/msg/Bool"):
        decode_bool(data)
