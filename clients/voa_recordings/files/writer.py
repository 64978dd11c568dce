"""Writer of recordings: MCAP files with ROS 2 messages as received (CDR) and the service's messages as JSON.

The profile is "ros2", each ROS topic is a channel of the same name, and every channel has ROS 2's encoding, JSON
included (`json_text`), so that Foxglove, rosbags and ROS 2's tools read the whole file.
"""

from collections import Counter
from importlib.metadata import version
from typing import IO, NamedTuple

from mcap.writer import CompressionType, Writer

from voa_recordings.files.json_text import STRING, as_string
from voa_recordings.files.ros_types import RosTypes

LIBRARY = "voa"
_CHUNK = 1 << 20


class RecordingWriter:
    """Writer of messages to an open MCAP file.

    Each `flush` ends a chunk, so that everything up to it can be read even if the file ends there.

    Attributes:
        counts: number of messages per topic.
    """

    def __init__(self, file: IO[bytes], types: RosTypes) -> None:
        self.counts: Counter[str] = Counter()
        self._file = file
        self._types = types
        self._channels: dict[tuple[str, str, _RosType | None], int] = {}
        self._schemas: dict[tuple[str, str], int] = {}
        self._mcap = Writer(file, chunk_size=_CHUNK, compression=CompressionType.ZSTD)
        self._mcap.start(profile="ros2", library=f"{LIBRARY} {version('voa')}")
        self._mcap.flush()

    @property
    def size(self) -> int:
        """Length of the file so far, bytes."""
        return self._file.tell()

    def add_ros(
        self,
        topic: str,
        type_name: str | None,
        data: bytes,
        *,
        log_ns: int,
        publish_ns: int,
        key: str,
        sequence: int = 0,
        type_hash: str | None = None,
    ) -> None:
        """Append a ROS 2 message, unchanged.

        Args:
            topic: "/tb3_1/scan".
            type_name: "sensor_msgs/msg/LaserScan"; None: not known, and then the channel has no schema. The schema of a
                type that no release of ROS 2 defines, or none with this hash, has a name only.
            data: CDR with its four bytes of header.
            log_ns: time of receipt, nanoseconds since 1970.
            publish_ns: time of sending, nanoseconds since 1970.
            key: the Zenoh key on which it was received; "": none.
            sequence: the sender's sequence number, if it has one.
            type_hash: of the sender's definition ("RIHS01_..."), if known.
        """
        named = None if type_name is None else _RosType(type_name, type_hash)
        channel = self._channel(topic, key, named)
        self._add(topic, channel, data, log_ns, publish_ns, sequence)

    def add_json(self, topic: str, data: bytes, *, log_ns: int, publish_ns: int, key: str) -> None:
        """Append a message of the service, as the text of a `std_msgs/msg/String`."""
        self.add_ros(topic, STRING, as_string(data), log_ns=log_ns, publish_ns=publish_ns, key=key)

    def flush(self) -> None:
        """End the chunk and hand it to the operating system."""
        self._mcap.flush()

    def finish(self) -> None:
        """Write the index, after which no message can be added; the file stays open."""
        self._mcap.finish()
        self._file.flush()

    def _add(self, topic: str, channel: int, data: bytes, log_ns: int, publish_ns: int, sequence: int) -> None:
        self.counts[topic] += 1
        self._mcap.add_message(channel, log_time=log_ns, publish_time=publish_ns, data=data, sequence=sequence)

    def _channel(self, topic: str, key: str, named: "_RosType | None") -> int:
        known = (topic, key, named)
        if known not in self._channels:
            metadata = {"key": key} if key else {}
            self._channels[known] = self._mcap.register_channel(topic, "cdr", self._schema(named), metadata)
        return self._channels[known]

    def _schema(self, named: "_RosType | None") -> int:
        """Return the number of a schema in the file; 0: no schema."""
        if named is None:
            return 0
        text = self._types.definition(named.name, named.type_hash)
        encoding, data = ("ros2msg", text) if text is not None else ("", "")
        if (named.name, encoding) not in self._schemas:
            self._schemas[named.name, encoding] = self._mcap.register_schema(named.name, encoding, data.encode())
        return self._schemas[named.name, encoding]


class _RosType(NamedTuple):
    name: str
    type_hash: str | None
