"""CDR of ROS 2: encode and decode the messages of `voa_ros.messages` (XCDR1, either byte order) with `struct` alone.

A payload is four bytes of header (`00 01` little endian or `00 00` big endian, then two of options), then the fields
in order, each aligned to its own size counted from the end of the header. Text is its length with the NUL, the bytes
and the NUL; a sequence is its length and its items. Payloads come from a network: every length is compared with the
number of remaining bytes before any value is read.
"""

import struct
from collections.abc import Callable
from typing import TypeVar

from voa_ros.messages import Covariance, LaserScan, Odometry, Pose, PoseWithCovariance, Stamp, Twist
from voa_ros.topics import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE_STAMPED

MOST_BEAMS = 4_096
"""Most beams of a LaserScan, unless the caller states another limit."""
_HEADER = 4
_MOST_TRAILING = 7
_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}

M = TypeVar("M")


class InvalidCdr(ValueError):
    """Error for bytes that are not the expected message, or a message that CDR cannot hold; its text says why."""


class _Reader:
    """Reader of the fields of a message in order; raises InvalidCdr where the bytes are too few or inconsistent."""

    def __init__(self, data: bytes, most_items: int) -> None:
        if len(data) < _HEADER:
            raise InvalidCdr(f"expected a CDR header of {_HEADER} bytes, got {len(data)} bytes")
        order = _ORDERS.get(bytes(data[:2]))
        if order is None:
            raise InvalidCdr(f"expected plain CDR (00 00 or 00 01), got a header of {bytes(data[:2]).hex(' ')}")
        self._data = data
        self._order = order
        self._at = _HEADER
        self._most_items = most_items

    def numbers(self, kind: str, count: int, what: str) -> tuple[float, ...]:
        """Read `count` aligned numbers of a `struct` kind; `what` names them in errors."""
        size = struct.calcsize(f"={kind}")
        start = self._at + (_HEADER - self._at) % size if count else self._at
        self._take(start, size * count, what)
        return struct.unpack_from(f"{self._order}{count}{kind}", self._data, start)

    def _take(self, start: int, size: int, what: str) -> None:
        left = len(self._data) - start
        if size > left:
            raise InvalidCdr(f"{what}: expected {size} bytes, got {max(left, 0)}")
        self._at = start + size

    def integer(self, kind: str, what: str) -> int:
        return int(self.numbers(kind, 1, what)[0])

    def text(self, what: str) -> str:
        length = self.integer("I", what)
        start = self._at
        self._take(start, length, what)
        raw = bytes(self._data[start : self._at])
        if length and raw[-1] != 0:
            raise InvalidCdr(f"{what}: expected text that ends with a NUL")
        if 0 in raw[:-1]:
            raise InvalidCdr(f"{what}: expected text without a NUL inside")
        try:
            return raw[:-1].decode()
        except UnicodeDecodeError as error:
            raise InvalidCdr(f"{what}: expected UTF-8, got {raw[:32]!r}") from error

    def floats(self, what: str) -> tuple[float, ...]:
        count = self.integer("I", what)
        if count > self._most_items:
            raise InvalidCdr(
                f"{what}: expected at most {self._most_items} values, got {count}: a lidar with more beams needs "
                f"VOA_LIMITS__BEAMS={count} in the environment of the program that reads it"
            )
        return self.numbers("f", count, what)

    def stamp(self) -> Stamp:
        return Stamp(self.integer("i", "header.stamp.sec"), self.integer("I", "header.stamp.nanosec"))

    def pose(self) -> tuple[Pose, Covariance]:
        x, y, z = self.numbers("d", 3, "pose.position")
        qx, qy, qz, qw = self.numbers("d", 4, "pose.orientation")
        return Pose((x, y, z), (qx, qy, qz, qw)), self.numbers("d", 36, "pose.covariance")

    def twist(self) -> tuple[Twist, Covariance]:
        x, y, z = self.numbers("d", 3, "twist.linear")
        a, b, c = self.numbers("d", 3, "twist.angular")
        return Twist((x, y, z), (a, b, c)), self.numbers("d", 36, "twist.covariance")

    def end(self) -> None:
        """Check that nothing but padding follows; more bytes belong to another type of message."""
        left = len(self._data) - self._at
        if left > _MOST_TRAILING:
            raise InvalidCdr(f"expected the message to end after {self._at} bytes, got {left} bytes more")


def _decode(name: str, data: bytes, most_items: int, read: Callable[[_Reader], M]) -> M:
    try:
        return _whole(data, most_items, read)
    except ValueError as error:
        other = _other_type(name, data)
        why = f": {error}" if other is None else f", found a {other}"
        raise InvalidCdr(f"expected a {name}{why}") from error


def _whole(data: bytes, most_items: int, read: Callable[[_Reader], M]) -> M:
    reader = _Reader(data, most_items)
    message = read(reader)
    reader.end()
    return message


def _other_type(expected: str, data: bytes) -> str | None:
    """Return the name of the other known message type that the bytes are; None: they are none."""
    for name, read in _READ.items():
        if name == expected:
            continue
        try:
            _whole(data, MOST_BEAMS, read)
        except ValueError:
            continue
        return name
    return None


def _read_scan(reader: _Reader) -> LaserScan:
    stamp, frame_id = reader.stamp(), reader.text("header.frame_id")
    low, high, step, dt, turn, near, far = reader.numbers("f", 7, "angles, times and limits")
    ranges, intensities = reader.floats("ranges"), reader.floats("intensities")
    return LaserScan(stamp, frame_id, low, high, step, dt, turn, near, far, ranges, intensities)


def _read_odometry(reader: _Reader) -> Odometry:
    stamp, frame_id, child_frame_id = reader.stamp(), reader.text("header.frame_id"), reader.text("child_frame_id")
    return Odometry(stamp, frame_id, child_frame_id, *reader.pose(), *reader.twist())


def _read_pose(reader: _Reader) -> PoseWithCovariance:
    return PoseWithCovariance(reader.stamp(), reader.text("header.frame_id"), *reader.pose())


_READ: dict[str, Callable[[_Reader], object]] = {
    LASER_SCAN.name: _read_scan,
    ODOMETRY.name: _read_odometry,
    POSE_WITH_COVARIANCE_STAMPED.name: _read_pose,
}


def decode_laser_scan(data: bytes, most_beams: int = MOST_BEAMS) -> LaserScan:
    """Decode a `sensor_msgs/msg/LaserScan`; raises InvalidCdr for other bytes or more than `most_beams` beams."""
    return _decode(LASER_SCAN.name, data, most_beams, _read_scan)


def decode_odometry(data: bytes) -> Odometry:
    """Decode a `nav_msgs/msg/Odometry`; raises InvalidCdr for other bytes."""
    return _decode(ODOMETRY.name, data, 0, _read_odometry)


def decode_pose(data: bytes) -> PoseWithCovariance:
    """Decode a `geometry_msgs/msg/PoseWithCovarianceStamped`; raises InvalidCdr for other bytes."""
    return _decode(POSE_WITH_COVARIANCE_STAMPED.name, data, 0, _read_pose)


def decode_bool(data: bytes) -> bool:
    """Decode a `std_msgs/msg/Bool`; raises InvalidCdr for other bytes."""
    if bytes(data[:2]) not in _ORDERS or not _HEADER < len(data) <= _HEADER + 1 + _MOST_TRAILING:
        raise InvalidCdr(f"expected a std_msgs/msg/Bool of {_HEADER + 1} bytes, got {len(data)} bytes")
    if data[_HEADER] not in (0, 1):
        raise InvalidCdr(f"expected a std_msgs/msg/Bool, 0 or 1, got {data[_HEADER]}")
    return data[_HEADER] == 1


class _Writer:
    def __init__(self, *, little_endian: bool) -> None:
        self._order = "<" if little_endian else ">"
        self._data = bytearray(b"\x00\x01\x00\x00" if little_endian else b"\x00\x00\x00\x00")

    def numbers(self, kind: str, *values: float) -> None:
        if not values:
            return
        self._data.extend(bytes((_HEADER - len(self._data)) % struct.calcsize(f"={kind}")))
        try:
            self._data.extend(struct.pack(f"{self._order}{len(values)}{kind}", *values))
        except (struct.error, OverflowError) as error:
            raise InvalidCdr(f"expected numbers within the range of their type, got {values[:8]}: {error}") from error

    def text(self, text: str) -> None:
        if "\0" in text:
            raise InvalidCdr(f"expected text without NUL, got {text!r}")
        try:
            raw = text.encode() + b"\0"
        except UnicodeEncodeError as error:
            raise InvalidCdr(f"expected Unicode text, got {text!r}") from error
        self.numbers("I", len(raw))
        self._data.extend(raw)

    def floats(self, values: tuple[float, ...]) -> None:
        self.numbers("I", len(values))
        self.numbers("f", *values)

    def header(self, stamp: Stamp, frame_id: str) -> None:
        self.numbers("i", stamp.sec)
        self.numbers("I", stamp.nanosec)
        self.text(frame_id)

    def covariance(self, values: Covariance) -> None:
        if len(values) != 36:
            raise InvalidCdr(f"expected a covariance of 36 numbers, got {len(values)}")
        self.numbers("d", *values)

    def pose(self, pose: Pose, covariance: Covariance) -> None:
        self.numbers("d", *pose.position, *pose.quaternion_xyzw)
        self.covariance(covariance)

    def bytes(self) -> bytes:
        return bytes(self._data)


def encode_laser_scan(scan: LaserScan, *, little_endian: bool = True) -> bytes:
    """Encode a `sensor_msgs/msg/LaserScan`; its numbers become float32. Raises InvalidCdr where one is out of range."""
    writer = _Writer(little_endian=little_endian)
    writer.header(scan.stamp, scan.frame_id)
    writer.numbers("f", scan.angle_min, scan.angle_max, scan.angle_increment, scan.time_increment, scan.scan_time)
    writer.numbers("f", scan.range_min, scan.range_max)
    writer.floats(scan.ranges)
    writer.floats(scan.intensities)
    return writer.bytes()


def encode_odometry(odometry: Odometry, *, little_endian: bool = True) -> bytes:
    """Encode a `nav_msgs/msg/Odometry`; raises InvalidCdr where a number is out of range."""
    writer = _Writer(little_endian=little_endian)
    writer.header(odometry.stamp, odometry.frame_id)
    writer.text(odometry.child_frame_id)
    writer.pose(odometry.pose, odometry.covariance)
    writer.numbers("d", *odometry.twist.linear, *odometry.twist.angular)
    writer.covariance(odometry.twist_covariance)
    return writer.bytes()


def encode_pose(pose: PoseWithCovariance, *, little_endian: bool = True) -> bytes:
    """Encode a `geometry_msgs/msg/PoseWithCovarianceStamped`, for programs that publish AMCL's poses without ROS.

    Raises:
        InvalidCdr: a number is out of range.
    """
    writer = _Writer(little_endian=little_endian)
    writer.header(pose.stamp, pose.frame_id)
    writer.pose(pose.pose, pose.covariance)
    return writer.bytes()
