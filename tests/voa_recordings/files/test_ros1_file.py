"""ROS 1 bags: what a look needs is read as ROS 2's bytes."""

from pathlib import Path

import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from tests.voa_recordings.files.bags import STORE, by_time, read, topics_after_one_another
from voa_recordings.files.message import UnreadableRecording
from voa_recordings.files.reading import Recording, is_recording
from voa_recordings.files.ros_types import RosTypes

ROS1 = get_typestore(Stores.ROS1_NOETIC)
GIVEN = topics_after_one_another(10)


def ros1_bag(path: Path) -> Path:
    """The messages of `GIVEN`, and a string, which no look needs."""
    with Writer(path) as writer:
        connections = {
            topic: writer.add_connection(topic, type_name, typestore=ROS1)
            for topic, type_name in {message[0]: message[1] for message in GIVEN}.items()
        }
        for topic, type_name, at, payload in GIVEN:
            writer.write(connections[topic], at, STORE.cdr_to_ros1(payload, type_name))
        words = writer.add_connection("/words", "std_msgs/msg/String", typestore=ROS1)
        writer.write(words, GIVEN[-1][2] + 1, b"\1\0\0\0a")
    return path


@pytest.mark.parametrize("name", ["x.bag", "x.whatever"])
def test_a_ros_1_bag_is_read_as_ros_2_s_bytes(tmp_path: Path, name: str) -> None:
    path = ros1_bag(tmp_path / "x.bag").rename(tmp_path / name)
    assert is_recording(path)
    recording, result = read(path)
    assert result[:-1] == by_time(GIVEN)
    assert recording.damage is None
    assert [message.encoding for message in Recording(path, RosTypes()).messages()] == ["cdr"] * 20 + ["ros1"]


@pytest.mark.parametrize("length", [20, 5_000, -200])
def test_a_ros_1_bag_without_its_index_names_the_commands_that_help(tmp_path: Path, length: int) -> None:
    path = ros1_bag(tmp_path / "x.bag")
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(UnreadableRecording, match=r"is a ROS 1 bag.*`rosbag reindex .*rosbags-convert --src"):
        read(path)


def test_what_is_damaged_inside_is_read_up_to_there(tmp_path: Path) -> None:
    path = ros1_bag(tmp_path / "x.bag")
    whole = bytearray(path.read_bytes())
    _, type_name, _, payload = GIVEN[4]
    place = whole.find(bytes(STORE.cdr_to_ros1(payload, type_name)))
    whole[place - 40 : place] = b"\xff" * 40
    path.write_bytes(whole)
    recording, result = read(path)
    assert result == by_time(GIVEN)[: len(result)]
    assert 0 < len(result) < 20
    assert recording.damage is not None
    assert "is damaged" in recording.damage
