import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from voa_ros.topics import (
    BOOL,
    LASER_SCAN,
    ODOMETRY,
    POSE_WITH_COVARIANCE_STAMPED,
    InvalidRmwAttachment,
    InvalidTopic,
    MessageType,
    RmwAttachment,
    TopicKey,
    expressions,
    match_key,
    parse_key,
    resolve,
    rmw_key,
    type_name,
)

TYPES = [BOOL, LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE_STAMPED]
DDS_SCAN = "sensor_msgs::msg::dds_::LaserScan_"
CHUNKS = st.from_regex(r"[A-Za-z0-9_]{1,8}", fullmatch=True)
TOPICS = st.lists(CHUNKS, min_size=1, max_size=4).map("/".join)


def meets(expression: str, key: str) -> bool:
    """Zenoh's rule for `*`: one chunk, any."""
    return re.fullmatch(re.escape(expression).replace(r"\*", "[^/]+"), key) is not None


@pytest.mark.parametrize("type_", TYPES)
def test_the_hashes_are_those_that_rosbags_computes(type_: MessageType) -> None:
    assert get_typestore(Stores.ROS2_JAZZY).hash_rihs01(type_.name) == type_.rihs


@given(TOPICS, st.sampled_from(TYPES), st.integers(0, 232))
def test_the_expressions_of_a_topic_match_all_its_forms(topic: str, type_: MessageType, domain: int) -> None:
    bridge, rmw = expressions(topic, domain)
    humble = f"{domain}/{topic}/{type_.dds_name}/TypeHashNotSupported"
    assert bridge == topic
    assert parse_key(topic) == match_key(topic, topic) == TopicKey(topic)
    for key in (rmw_key(topic, type_, domain), humble):
        assert meets(rmw, key)
        assert parse_key(key) == match_key(topic, key, domain) == TopicKey(topic, type_.name, domain)


@given(TOPICS, st.sampled_from(TYPES), st.integers(0, 232), st.integers(0, 232))
def test_only_the_domain_that_is_mapped_is_met(topic: str, type_: MessageType, mapped: int, other: int) -> None:
    key = rmw_key(topic, type_, other)
    assert (match_key(topic, key, mapped) is not None) == (mapped == other)
    assert meets(expressions(topic, mapped)[1], key) == (mapped == other)
    assert match_key(topic, topic, mapped) == TopicKey(topic)  # a bridge's key has no domain


def test_the_domain_is_0_unless_it_is_said() -> None:
    assert match_key("scan", rmw_key("scan", LASER_SCAN)) == TopicKey("scan", LASER_SCAN.name, 0)
    assert match_key("scan", rmw_key("scan", LASER_SCAN, 5)) is None


def test_a_key_of_rmw_zenoh_as_it_was_seen() -> None:
    seen = f"0/tb3_1/scan/{DDS_SCAN}/RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"
    assert rmw_key("tb3_1/scan", LASER_SCAN) == seen
    assert expressions("tb3_1/scan") == ("tb3_1/scan", "0/tb3_1/scan/*/*")


def test_another_type_on_a_topic_is_met_and_another_topic_below_it_is_not() -> None:
    parsed = match_key("scan", "0/scan/sensor_msgs::msg::dds_::PointCloud2_/RIHS01_ab")
    assert parsed == TopicKey("scan", "sensor_msgs/msg/PointCloud2", 0)
    for key in ("tb3_1/scan/front/filtered", "0/front/scan/sensor_msgs::msg::dds_::LaserScan_/x", "a/scan/b c/d"):
        assert match_key("scan", key) is None


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("sensor_msgs/msg/LaserScan", "sensor_msgs/msg/LaserScan"),
        ("sensor_msgs/LaserScan", "sensor_msgs/msg/LaserScan"),
        (DDS_SCAN, "sensor_msgs/msg/LaserScan"),
        ("", None),
        ("charset=utf-8", None),
    ],
)
def test_a_type_has_one_name_in_every_form(text: str, name: str | None) -> None:
    assert type_name(text) == name


@pytest.mark.parametrize(
    ("namespace", "topic", "resolved"),
    [
        ("tb3_1", "scan", "tb3_1/scan"),
        ("/lab/tb3_1", "front/scan", "lab/tb3_1/front/scan"),
        ("", "scan", "scan"),
        ("/", "scan", "scan"),
        ("tb3_1", "/scan", "scan"),
    ],
)
def test_a_topic_is_resolved_as_ros_does(namespace: str, topic: str, resolved: str) -> None:
    assert resolve(namespace, topic) == resolved


@pytest.mark.parametrize("topic", ["", "/", "a//b", "a/", "tb3-1/scan", "a.b", "*", "a/**", "sc an", "@ros2_lv/0", "ä"])
def test_other_characters_are_refused(topic: str) -> None:
    for wrong in (lambda: resolve("", f"/{topic}"), lambda: parse_key(topic), lambda: expressions(topic)):
        with pytest.raises(InvalidTopic, match="expected a topic"):
            wrong()


@pytest.mark.parametrize("key", [f"x/scan/{DDS_SCAN}/RIHS01_0", f"0/sc an/{DDS_SCAN}/RIHS01_0", f"0/{DDS_SCAN}/a"])
def test_a_key_that_is_nearly_rmw_zenohs_is_refused(key: str) -> None:
    with pytest.raises(InvalidTopic, match="expected"):
        parse_key(key)


NUMBERS = st.integers(-(2**63), 2**63 - 1)
ATTACHMENTS = st.builds(RmwAttachment, NUMBERS, NUMBERS, st.binary(min_size=16, max_size=16))


@given(ATTACHMENTS)
def test_an_attachment_comes_back(attachment: RmwAttachment) -> None:
    assert len(attachment.encode()) == 33
    assert RmwAttachment.decode(attachment.encode()) == attachment


@given(ATTACHMENTS, ATTACHMENTS)
def test_two_samples_have_two_names(one: RmwAttachment, other: RmwAttachment) -> None:
    assert (one.name == other.name) == (one == other)
    assert len(one.name) <= 255


def test_an_attachment_byte_by_byte() -> None:
    attachment = RmwAttachment(1, 2, bytes(range(16)))
    assert attachment.encode() == b"\x01" + bytes(7) + b"\x02" + bytes(7) + b"\x10" + bytes(range(16))


@pytest.mark.parametrize("data", [b"", bytes(32), bytes(33), bytes(34), bytes(77)])
def test_other_attachments_are_refused(data: bytes) -> None:
    with pytest.raises(InvalidRmwAttachment, match="expected"):
        RmwAttachment.decode(data)


def test_an_attachment_that_does_not_fit_is_refused() -> None:
    with pytest.raises(InvalidRmwAttachment, match="64-bit"):
        RmwAttachment(2**63, 0, bytes(16)).encode()
    with pytest.raises(InvalidRmwAttachment, match="16 bytes"):
        RmwAttachment(0, 0, bytes(15))
