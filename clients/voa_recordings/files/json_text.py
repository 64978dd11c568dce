"""JSON in recordings: the text of a `std_msgs/msg/String`, which every reader of rosbag2 files can read.

Channels of JSON with a JSON schema, which recordings had earlier, keep such readers from opening a file at all: rosbags
raises KeyError for the schema's encoding, and mcap-ros2-support finds no decoder. They are still read here.
"""

import struct

from voa_recordings.files.message import RecordedMessage

STRING = "std_msgs/msg/String"
_LITTLE_ENDIAN = b"\0\1\0\0"
_HEADER, _LENGTH = 4, 4


def as_string(body: bytes) -> bytes:
    """Encode JSON as a `std_msgs/msg/String` in CDR; bytes that are not UTF-8, so not JSON, are written as escapes."""
    try:
        body.decode()
    except UnicodeDecodeError:
        body = body.decode(errors="backslashreplace").encode()
    return _LITTLE_ENDIAN + struct.pack("<I", len(body) + 1) + body + b"\0"


def json_of(message: RecordedMessage) -> bytes | None:
    """Return the JSON of a message, of a `std_msgs/msg/String` its text; None: it is of another type, or cut off."""
    if message.encoding == "json":
        return message.data
    if message.encoding != "cdr" or message.type_name != STRING:
        return None
    data = message.data
    start = _HEADER + _LENGTH
    if len(data) <= start:
        return None
    (length,) = struct.unpack_from("<I" if data[1:2] == b"\1" else ">I", data, _HEADER)
    return data[start : start + length - 1] if 0 < length <= len(data) - start else None
