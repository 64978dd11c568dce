"""MCAP files: ROS 2 messages as they came (CDR), and the service's messages as JSON, each with its schema.

The profile is "ros2" and a ROS topic is a channel of its name, so that Foxglove and ROS 2's own tools read it.
"""

import json
from collections import Counter
from importlib.metadata import version
from typing import IO, NamedTuple

from mcap.writer import CompressionType, Writer
from pydantic import BaseModel

from voa_recordings.files.ros_types import RosTypes

LIBRARY = "voa"
_CHUNK = 1 << 20


class RecordingWriter:
    """Writes messages to an open file.

    A chunk ends with each `flush`: what was flushed is readable although the file ends there.

    Attributes:
        counts: messages per topic.
    """

    def __init__(self, file: IO[bytes], types: RosTypes) -> None:
        self.counts: Counter[str] = Counter()
        self._file = file
        self._types = types
        self._channels: dict[tuple[str, str, str, _Schema], int] = {}
        self._schemas: dict[tuple[str, str], int] = {}
        self._mcap = Writer(file, chunk_size=_CHUNK, compression=CompressionType.ZSTD)
        self._mcap.start(profile="ros2", library=f"{LIBRARY} {version('voa')}")
        self._mcap.flush()

    @property
    def size(self) -> int:
        """Bytes in the file so far."""
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
        """A ROS 2 message, unchanged.

        Args:
            topic: "/tb3_1/scan".
            type_name: "sensor_msgs/msg/LaserScan"; None: not known, and then the channel has no schema. A type that no
                release of ROS 2 defines, or not with this hash, has a schema with a name and nothing else.
            data: CDR with its four bytes of header.
            log_ns: when it came, nanoseconds since 1970.
            publish_ns: when it was sent.
            key: where it was heard.
            sequence: the sender's number of it, if it has one.
            type_hash: of the sender's definition ("RIHS01_..."), if it says so.
        """
        named = None if type_name is None else _RosType(type_name, type_hash)
        channel = self._channel(topic, "cdr", key, named)
        self._add(topic, channel, data, log_ns, publish_ns, sequence)

    def add_json(
        self, topic: str, model: type[BaseModel] | None, data: bytes, *, log_ns: int, publish_ns: int, key: str
    ) -> None:
        """A message of the service, unchanged; `model` describes it, None: nothing does."""
        channel = self._channel(topic, "json", key, model)
        self._add(topic, channel, data, log_ns, publish_ns, 0)

    def flush(self) -> None:
        """End the chunk and hand it to the operating system."""
        self._mcap.flush()

    def finish(self) -> None:
        """Write the index; nothing can be added afterwards. The file stays open."""
        self._mcap.finish()
        self._file.flush()

    def _add(self, topic: str, channel: int, data: bytes, log_ns: int, publish_ns: int, sequence: int) -> None:
        self.counts[topic] += 1
        self._mcap.add_message(channel, log_time=log_ns, publish_time=publish_ns, data=data, sequence=sequence)

    def _channel(self, topic: str, encoding: str, key: str, schema: "_Schema") -> int:
        known = (topic, encoding, key, schema)
        if known not in self._channels:
            named = self._schema(schema)
            self._channels[known] = self._mcap.register_channel(topic, encoding, named, {"key": key})
        return self._channels[known]

    def _schema(self, schema: "_Schema") -> int:
        """Its number; 0: none."""
        if schema is None:
            return 0
        if isinstance(schema, _RosType):
            text = self._types.definition(schema.name, schema.type_hash)
            name, encoding, data = (schema.name, "ros2msg", text) if text is not None else (schema.name, "", "")
        else:
            name, encoding, data = schema.__name__, "jsonschema", json.dumps(schema.model_json_schema())
        if (name, encoding) not in self._schemas:
            self._schemas[name, encoding] = self._mcap.register_schema(name, encoding, data.encode())
        return self._schemas[name, encoding]


class _RosType(NamedTuple):
    name: str
    type_hash: str | None


_Schema = _RosType | type[BaseModel] | None
