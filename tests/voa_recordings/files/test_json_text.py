"""JSON as text of ROS 2: read back unchanged, by rosbags as by us, and from older recordings."""

import json
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from tests.voa_recordings.files.bags import START_NS
from voa_recordings.files.json_text import STRING, as_string, json_of
from voa_recordings.files.message import RecordedMessage
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes

TYPES = RosTypes()
BODIES = [b"", b"{}", b'{"a": "\xc3\xa4"}', b'["odd"]\n', b"\xff{"]


def text_of(data: bytes) -> str:
    message: Any = TYPES.store.deserialize_cdr(data, STRING)
    return str(message.data)


def recorded(data: bytes, type_name: str = STRING, encoding: str = "cdr") -> RecordedMessage:
    return RecordedMessage("/voa/s1/belief", type_name, encoding, START_NS, data)


@pytest.mark.parametrize("body", BODIES[:-1])
def test_json_is_read_as_it_was_given(body: bytes) -> None:
    assert text_of(as_string(body)).encode() == body
    assert json_of(recorded(as_string(body))) == body


def test_text_that_rosbags_wrote_is_read() -> None:
    text = TYPES.store.types[STRING](data='{"a": 1}')
    for little_endian in (True, False):
        data = bytes(TYPES.store.serialize_cdr(text, STRING, little_endian=little_endian))
        assert json_of(recorded(data)) == b'{"a": 1}'


def test_bytes_that_are_no_text_are_escaped_so_that_readers_do_not_stop_at_them() -> None:
    assert text_of(as_string(BODIES[-1])) == "\\xff{"


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\0\1\0\0\0\0\0\0", b"\0\1\0\0\xff\xff\xff\x7f{}\0"])
def test_text_that_is_cut_off_is_none(data: bytes) -> None:
    assert json_of(recorded(data)) is None
    assert json_of(recorded(as_string(b"{}"), type_name="lab/msg/Own")) is None


def test_json_of_an_older_recording_is_read(tmp_path: Path) -> None:
    path = tmp_path / "old.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("Session", "jsonschema", json.dumps({"type": "object"}).encode())
        channel = writer.register_channel("/voa/s1/belief", "json", schema)
        writer.add_message(channel, START_NS, b'{"version": 1}', START_NS)
        writer.finish()
    (message,) = Recording(path, TYPES).messages()
    assert json_of(message) == b'{"version": 1}'
