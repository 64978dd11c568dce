"""Recordings as files: what is written is read, by us and by others; what is damaged is read as far as it goes."""

from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin

from tests.voa_recordings.files.bags import START_NS, STEP_NS, Written, bag, read, scans
from voa_msgs.problems import Problem
from voa_recordings.files.json_text import STRING
from voa_recordings.files.message import UnreadableRecording
from voa_recordings.files.reading import is_recording
from voa_recordings.files.ros_types import LASER_SCAN, RosTypes
from voa_recordings.files.writer import RecordingWriter

TYPES = RosTypes()
STORAGES = [StoragePlugin.SQLITE3, StoragePlugin.MCAP]


def recorded(path: Path, messages: list[Written], flush_every: int = 5) -> Path:
    """A file of our own writer."""
    with path.open("wb") as file:
        writer = RecordingWriter(file, TYPES)
        for index, (topic, type_name, at, payload) in enumerate(messages):
            writer.add_ros(topic, type_name, payload, log_ns=at + 7, publish_ns=at, key=topic[1:], sequence=index)
            if index % flush_every == flush_every - 1:
                writer.flush()
        writer.finish()
    return path


def test_a_recording_is_what_was_given_and_others_read_it(tmp_path: Path) -> None:
    given = scans(12)
    path = recorded(tmp_path / "own.mcap", given)
    recording, result = read(path)
    assert result == [(topic, type_name, at + 7, payload) for topic, type_name, at, payload in given]
    assert (recording.damage, recording.recovered, recording.topics) == (None, 12, {"/scan": LASER_SCAN})
    assert {message.key for message in recording.messages()} == {"scan"}, "its domain is that of the recorded keys"
    with AnyReader([path]) as theirs:
        assert [bytes(payload) for _, _, payload in theirs.messages()] == [payload for *_, payload in given]
        assert "ranges" in vars(theirs.deserialize(next(theirs.messages())[2], LASER_SCAN))
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert [channel.metadata for channel in summary.channels.values()] == [{"key": "scan"}]


def test_json_is_text_of_ros_and_the_profile_is_ros2() -> None:
    file = BytesIO()
    writer = RecordingWriter(file, TYPES)
    body = Problem(type="urn:voa:problem:x", title="x", status=422, detail="ä").model_dump_json().encode()
    for topic in ("/voa/s1/refused", "/voa/s2/refused"):
        writer.add_json(topic, body, log_ns=START_NS, publish_ns=START_NS, key="k")
    writer.add_ros("/unknown", "lab_msgs/msg/Own", b"\0\1\0\0", log_ns=START_NS, publish_ns=START_NS, key="unknown")
    writer.finish()
    file.seek(0)
    reader = make_reader(file)
    assert reader.get_header().profile == "ros2"
    result = [(schema, channel, message.data) for schema, channel, message in reader.iter_messages()]
    assert [schema and (schema.name, schema.encoding) for schema, _, _ in result] == [(STRING, "ros2msg")] * 2 + [
        ("lab_msgs/msg/Own", "")
    ]
    assert {channel.message_encoding for _, channel, _ in result} == {"cdr"}
    texts: list[Any] = [TYPES.store.deserialize_cdr(data, STRING) for *_, data in result[:2]]
    assert [text.data.encode() for text in texts] == [body, body]
    assert dict(writer.counts) == {"/voa/s1/refused": 1, "/voa/s2/refused": 1, "/unknown": 1}


def test_stock_readers_read_a_recording_with_json_and_ros(tmp_path: Path) -> None:
    path, (scan,) = tmp_path / "own.mcap", scans(1)
    with path.open("wb") as file:
        writer = RecordingWriter(file, TYPES)
        writer.add_ros("/scan", LASER_SCAN, scan[-1], log_ns=START_NS, publish_ns=START_NS, key="scan")
        writer.add_json("/voa/s1/deleted", b"{}", log_ns=START_NS + 1, publish_ns=START_NS, key="k")
        writer.finish()
    with AnyReader([path]) as theirs:
        read_by_them: list[Any] = [theirs.deserialize(data, of.msgtype) for of, _, data in theirs.messages()]
    assert [len(read_by_them[0].ranges), read_by_them[1].data] == [360, "{}"]
    with path.open("rb") as file:
        by_mcap = list(make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages())
    assert [len(by_mcap[0].decoded_message.ranges), by_mcap[1].decoded_message.data] == [360, "{}"]


@pytest.mark.parametrize("storage", STORAGES)
def test_a_rosbag2_folder_is_read(tmp_path: Path, storage: StoragePlugin) -> None:
    given = scans(9)
    recording, result = read(bag(tmp_path / "bag", given, storage))
    assert result == given
    assert (recording.damage, recording.topics) == (None, {"/scan": LASER_SCAN})


@pytest.mark.parametrize("storage", STORAGES)
def test_a_rosbag2_folder_whose_recorder_was_killed_has_no_metadata_and_is_read(
    tmp_path: Path, storage: StoragePlugin
) -> None:
    given = scans(9)
    folder = bag(tmp_path / "bag", given, storage)
    (folder / "metadata.yaml").unlink()
    recording, result = read(folder)
    assert result == given
    assert recording.damage is not None
    assert "metadata.yaml" in recording.damage


def test_files_of_a_folder_are_read_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    given = scans(3)
    for number, message in zip((10, 2, 1), reversed(given), strict=True):
        recorded(tmp_path / f"bag_{number}.mcap", [message])
    _, result = read(tmp_path)
    assert [at for _, _, at, _ in result] == sorted(at for _, _, at, _ in result)
    assert len(result) == 3


def test_a_file_cut_anywhere_gives_what_stands_before_the_cut(tmp_path: Path) -> None:
    given = scans(8)
    path = recorded(tmp_path / "own.mcap", given, flush_every=2)
    whole = path.read_bytes()
    before = 0
    cut = tmp_path / "cut.mcap"
    for length in range(8, len(whole), 7):
        cut.write_bytes(whole[:length])
        recording, result = read(cut)
        assert recording.damage == "ends in the middle"
        assert [payload for *_, payload in result] == [payload for *_, payload in given[: len(result)]]
        assert len(result) >= before
        before = len(result)
    assert before == len(given)


@pytest.mark.parametrize("compression", list(CompressionType))
def test_of_every_compression_whole_chunks_before_the_cut_are_read(
    tmp_path: Path, compression: CompressionType
) -> None:
    given = scans(20)
    file = BytesIO()
    writer = Writer(file, chunk_size=10_000, compression=compression, enable_data_crcs=True)
    writer.start(profile="ros2")
    definition = TYPES.definition(LASER_SCAN)
    assert definition is not None
    channel = writer.register_channel(
        "/scan", "cdr", writer.register_schema(LASER_SCAN, "ros2msg", definition.encode())
    )
    for _, _, at, payload in given:
        writer.add_message(channel, at, payload, at)
    writer.finish()
    whole = file.getvalue()
    path = tmp_path / "theirs.mcap"
    path.write_bytes(whole)
    assert read(path)[1] == given
    counts = set()
    for length in range(8, len(whole), max(1, len(whole) // 60)):
        path.write_bytes(whole[:length] + bytes(100))  # what a file system may leave after a power cut
        recording, result = read(path)
        assert recording.damage is not None
        assert result == given[: len(result)]
        counts.add(len(result))
    assert len(counts) > 3


def test_a_flipped_byte_never_passes_for_a_scan(tmp_path: Path) -> None:
    given = scans(8)
    whole = bytearray(recorded(tmp_path / "own.mcap", given, flush_every=2).read_bytes())
    path = tmp_path / "flipped.mcap"
    payloads = {payload for *_, payload in given}
    for place in range(8, len(whole), 23):
        whole[place] ^= 0xFF
        path.write_bytes(whole)
        whole[place] ^= 0xFF
        assert {payload for *_, payload in read(path)[1]} <= payloads


def test_a_layout_that_a_recording_defines_otherwise_is_brought_into_the_standard_one(tmp_path: Path) -> None:
    file = BytesIO()
    writer = Writer(file)
    writer.start(profile="ros2")
    definition = TYPES.definition(LASER_SCAN)
    assert definition is not None
    head, _, rest = definition.partition("=" * 80)
    swapped = head.replace("float32 angle_min\nfloat32 angle_max\n", "float32 angle_max\nfloat32 angle_min\n")
    assert swapped != head
    own = f"{swapped}{'=' * 80}{rest}"
    schema = writer.register_schema(LASER_SCAN, "ros2msg", own.encode())
    channel = writer.register_channel("/scan", "cdr", schema)
    theirs = TYPES.defined(LASER_SCAN, "ros2msg", own)
    [(_, _, at, payload)] = scans(1)
    swapped_payload = theirs.serialize_cdr(TYPES.store.deserialize_cdr(payload, LASER_SCAN), LASER_SCAN)
    assert bytes(swapped_payload) != payload
    writer.add_message(channel, at, bytes(swapped_payload), at)
    writer.finish()
    path = tmp_path / "own.mcap"
    path.write_bytes(file.getvalue())
    assert read(path)[1] == [("/scan", LASER_SCAN, at, payload)]


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("x.mcap", b"this is something else", "is of an unknown kind; expected an MCAP file"),
        ("x.db3", b"this is something else", "is of an unknown kind; expected an MCAP file"),
        ("x.db3", b"", "is empty; expected"),
        ("metadata.yaml", b"rosbag2_bagfile_information: 3", "has no recording in it"),
    ],
)
def test_what_is_no_recording_is_said_so(tmp_path: Path, name: str, content: bytes, says: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(UnreadableRecording, match=says):
        read(tmp_path if name == "metadata.yaml" else path)


def test_what_is_a_recording(tmp_path: Path) -> None:
    assert is_recording(bag(tmp_path / "bag", scans(1), StoragePlugin.MCAP))
    assert is_recording(tmp_path / "gone.mcap")
    assert is_recording(recorded(tmp_path / "without-ending", scans(1)))
    (tmp_path / "session.json").write_text("{}")
    assert not is_recording(tmp_path / "session.json")
    assert not is_recording(tmp_path / "nothing")
    (tmp_path / "empty").mkdir()
    assert not is_recording(tmp_path / "empty")


def test_what_is_not_there_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(UnreadableRecording, match="there is no such file"):
        read(tmp_path / "gone.mcap")


def test_times_are_those_of_the_recording(tmp_path: Path) -> None:
    given = scans(3)
    with recorded(tmp_path / "own.mcap", given).open("rb") as file:
        times = [(m.log_time, m.publish_time, m.sequence) for _, _, m in make_reader(file).iter_messages()]
    assert times == [(START_NS + i * STEP_NS + 7, START_NS + i * STEP_NS, i) for i in range(3)]
