"""Recordings as ROS 2 makes them, by rosbags' own writer, and as crashes and people leave them."""

import shutil
import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import LASER_SCAN, ODOMETRY, RosTypes
from voa_ros.cdr import encode_laser_scan, encode_odometry
from voa_ros.messages import LaserScan, Odometry, Pose, Stamp

STORE = get_typestore(Stores.ROS2_JAZZY)
START_NS = 1_760_000_000_000_000_000
STEP_NS = 200_000_000

Written = tuple[str, str, int, bytes]
"""Topic, type, time, payload."""


def laser_scan(ranges: Sequence[float], at_ns: int = START_NS, **changes: float) -> LaserScan:
    """A revolution."""
    figures = {
        "angle_min": 0.0, "angle_max": 6.265732, "angle_increment": 0.017453292, "time_increment": 0.0,
        "scan_time": 0.0, "range_min": 0.12, "range_max": 3.5,
    } | changes  # fmt: skip
    stamp = Stamp(at_ns // 1_000_000_000, at_ns % 1_000_000_000)
    return LaserScan(stamp=stamp, frame_id="base_scan", ranges=tuple(ranges), intensities=(), **figures)


def scans(count: int, topic: str = "/scan") -> list[Written]:
    """Revolutions that differ, one each 0.2 s."""
    made = []
    for index in range(count):
        at = START_NS + index * STEP_NS
        made.append((topic, LASER_SCAN, at, encode_laser_scan(laser_scan([0.5 + index / 100] * 360, at))))
    return made


def bag(folder: Path, messages: Sequence[Written], storage: StoragePlugin) -> Path:
    """A rosbag2 folder."""
    with Writer(folder, version=9, storage_plugin=storage) as writer:
        connections = {
            topic: writer.add_connection(topic, type_name, typestore=STORE)
            for topic, type_name in {message[0]: message[1] for message in messages}.items()
        }
        for topic, _, at, payload in messages:
            writer.write(connections[topic], at, payload)
    return folder


def topics_after_one_another(count: int) -> list[Written]:
    """All revolutions, then all odometry of the same times."""
    made = scans(count)
    for index in range(count):
        at = START_NS + index * STEP_NS
        pose = Pose.planar(index / 10, 0.0, 0.0)
        stamp = Stamp(at // 1_000_000_000, at % 1_000_000_000)
        made.append(("/odom", ODOMETRY, at, encode_odometry(Odometry(stamp, "odom", "base", pose))))
    return made


def mcap(path: Path, messages: Sequence[Written], chunk_bytes: int | None = 10_000) -> Path:
    """An MCAP file in the order of `messages`; None: without chunks."""
    with path.open("wb") as file:
        writer = McapWriter(file, chunk_size=chunk_bytes or 1, use_chunking=chunk_bytes is not None)
        writer.start(profile="ros2")
        channels = {}
        for topic, type_name in {message[0]: message[1] for message in messages}.items():
            definition = STORE.generate_msgdef(type_name, ros_version=2)[0]
            schema = writer.register_schema(type_name, "ros2msg", definition.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        for topic, _, at, payload in messages:
            writer.add_message(channels[topic], at, payload, at)
        writer.finish()
    return path


def db3(path: Path, messages: Sequence[Written], *, log: bool = False, definitions: bool = True) -> Path:
    """A bare database in the order of `messages`.

    Args:
        path: of the database.
        messages: what is in it.
        log: as a killed recorder leaves it: the second half of the messages is in the write-ahead log only.
        definitions: with the table that newer releases of rosbag2 write.
    """
    with TemporaryDirectory() as folder:
        making = Path(folder) / path.name
        with closing(sqlite3.connect(making, isolation_level=None)) as database:
            database.execute("PRAGMA journal_mode=WAL" if log else "PRAGMA journal_mode=DELETE")
            database.execute("PRAGMA wal_autocheckpoint=0")
            database.executescript(DB3_TABLES)
            types = {message[0]: message[1] for message in messages}
            numbers = {topic: number for number, topic in enumerate(types, 1)}
            for topic, number in numbers.items():
                database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (number, topic, types[topic]))
            if definitions:
                database.execute("CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, "
                                 "encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL, "
                                 "type_description_hash TEXT NOT NULL)")  # fmt: skip
                for type_name in sorted(set(types.values())):
                    text = STORE.generate_msgdef(type_name, ros_version=2)[0]
                    database.execute("INSERT INTO message_definitions VALUES (NULL, ?, 'ros2msg', ?, '')",
                                     (type_name, text))  # fmt: skip
            rows = [(numbers[topic], at, payload) for topic, _, at, payload in messages]
            half = len(rows) // 2 if log else len(rows)
            database.executemany("INSERT INTO messages VALUES (NULL, ?, ?, ?)", rows[:half])
            database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            database.executemany("INSERT INTO messages VALUES (NULL, ?, ?, ?)", rows[half:])
            for file in (making, making.with_name(f"{making.name}-wal")):  # before closing carries the log over
                if file.exists():
                    shutil.copyfile(file, path.with_name(file.name))
    return path


DB3_TABLES = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                    serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
                      data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""


def read(path: Path) -> tuple[Recording, list[Written]]:
    """A recording, and all its messages."""
    recording = Recording(path, RosTypes())
    result = [(message.topic, message.type_name, message.log_ns, message.data) for message in recording.messages()]
    return recording, result


def by_time(messages: Sequence[Written]) -> list[Written]:
    """The order that every recording is read in."""
    return sorted(messages, key=lambda message: message[2])
