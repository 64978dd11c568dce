"""Keys of ROS 2 topics on Zenoh, and the attachment that rmw_zenoh sends with each sample.

The key of topic `/tb3_1/scan` depends on the publisher:

| publisher                   | key                                                                        |
|-----------------------------|----------------------------------------------------------------------------|
| zenoh-bridge-ros2dds        | `tb3_1/scan`                                                               |
| rmw_zenoh                   | `<domain>/tb3_1/scan/sensor_msgs::msg::dds_::LaserScan_/RIHS01_<64 digits>` |
| rmw_zenoh on humble         | as rmw_zenoh, with `TypeHashNotSupported` instead of the hash              |

In this package a topic is written as in the first form: chunks separated by slashes, without a leading slash.
"""

import re
import struct
from dataclasses import dataclass

_CHUNK = re.compile(r"[A-Za-z0-9_]+")
_DDS_TYPE = re.compile(r"([A-Za-z0-9_]+)::msg::dds_::([A-Za-z0-9_]+)_")
_TYPE = re.compile(r"([A-Za-z0-9_]+)/(?:msg/)?([A-Za-z0-9_]+)")
_DOMAIN = re.compile(r"[0-9]+")
_ATTACHMENT = struct.Struct("<qqB16s")
_GID_BYTES = 16


class InvalidTopic(ValueError):
    """Error for text that is neither a topic nor the key of one; its text says what was expected."""


class InvalidRmwAttachment(ValueError):
    """Error for bytes that are not rmw_zenoh's attachment, or values that it cannot hold."""


@dataclass(frozen=True)
class MessageType:
    """Type of ROS 2 messages.

    Attributes:
        name: name such as `sensor_msgs/msg/LaserScan`.
        rihs: hash of the type (REP-2011), which rmw_zenoh puts into keys.
    """

    name: str
    rihs: str

    @property
    def dds_name(self) -> str:
        """Name in DDS, such as `sensor_msgs::msg::dds_::LaserScan_`."""
        package, _, last = self.name.partition("/msg/")
        return f"{package}::msg::dds_::{last}_"


LASER_SCAN = MessageType(
    "sensor_msgs/msg/LaserScan", "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"
)
ODOMETRY = MessageType(
    "nav_msgs/msg/Odometry", "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"
)
POSE_WITH_COVARIANCE_STAMPED = MessageType(
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "RIHS01_26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e",
)
BOOL = MessageType("std_msgs/msg/Bool", "RIHS01_feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9")


def type_name(text: str) -> str | None:
    """Convert any form of the name of a message type to `sensor_msgs/msg/LaserScan`; None: it names no type."""
    match = _TYPE.fullmatch(text) or _DDS_TYPE.fullmatch(text)
    return None if match is None else f"{match[1]}/msg/{match[2]}"


@dataclass(frozen=True)
class TopicKey:
    """Parsed key of a topic.

    Attributes:
        topic: name of the topic, without a leading slash.
        type_name: type such as `sensor_msgs/msg/LaserScan`; None: the key does not state it.
        domain: ROS_DOMAIN_ID; None: the key does not state it.
    """

    topic: str
    type_name: str | None = None
    domain: int | None = None


def check_topic(topic: str) -> str:
    """Return the topic; raises InvalidTopic unless it is chunks of `[A-Za-z0-9_]` separated by slashes."""
    if not all(_CHUNK.fullmatch(chunk) for chunk in topic.split("/")):
        raise InvalidTopic(
            f"expected a topic like 'tb3_1/scan': chunks of letters, digits and '_', separated by '/', got {topic!r}"
        )
    return topic


def resolve(namespace: str, topic: str) -> str:
    """Resolve a topic with a namespace as ROS does: a topic that begins with `/` is absolute.

    Args:
        namespace: any number of chunks, with or without a leading slash; "" or "/": no namespace.
        topic: relative or absolute topic.

    Raises:
        InvalidTopic: the result has characters that a topic cannot have.
    """
    above = namespace.removeprefix("/")
    if topic.startswith("/"):
        return check_topic(topic[1:])
    return check_topic(f"{above}/{topic}" if above else topic)


def expressions(topic: str, domain: int = 0) -> tuple[str, ...]:
    """Build the key expressions that match a resolved topic in all its forms.

    They match messages of every type, so that a message of another type can be refused with a reason. `match_key` reads
    the keys of samples.

    Args:
        topic: chunks separated by slashes.
        domain: ROS_DOMAIN_ID of the nodes that publish by rmw_zenoh; the keys of a bridge have none.

    Raises:
        InvalidTopic: the text is not a topic.
    """
    check_topic(topic)
    return topic, f"{domain}/{topic}/*/*"


def match_key(topic: str, key: str, domain: int = 0) -> TopicKey | None:
    """Parse the key of a sample; None: the key has another topic, such as one below `topic`, or another domain."""
    try:
        parsed = parse_key(key)
    except InvalidTopic:
        return None
    return parsed if parsed.topic == topic and parsed.domain in (None, domain) else None


def rmw_key(topic: str, type_: MessageType, domain: int = 0) -> str:
    """Build the key on which rmw_zenoh publishes and subscribes to a topic, for programs that publish without ROS.

    Args:
        topic: its name without the leading slash.
        type_: of its messages.
        domain: `ROS_DOMAIN_ID` of the robot.

    Raises:
        InvalidTopic: `topic` is not the name of a ROS 2 topic.
    """
    return f"{domain}/{check_topic(topic)}/{type_.dds_name}/{type_.rihs}"


def parse_key(key: str) -> TopicKey:
    """Parse a key in any of the three forms; raises InvalidTopic where it has none of them."""
    chunks = key.split("/")
    of_rmw = _DDS_TYPE.fullmatch(chunks[-2]) if len(chunks) >= 4 else None
    if of_rmw is None:
        return TopicKey(check_topic(key))
    if not _DOMAIN.fullmatch(chunks[0]):
        raise InvalidTopic(f"expected '<domain>/<topic>/<type>/<hash>', got {key!r}")
    return TopicKey(check_topic("/".join(chunks[1:-2])), f"{of_rmw[1]}/msg/{of_rmw[2]}", int(chunks[0]))


@dataclass(frozen=True)
class RmwAttachment:
    """Attachment of the samples of rmw_zenoh; a ROS node aborts when it receives a sample with any other attachment.

    Attributes:
        sequence: number of the sample of its publisher.
        source_ns: time of publication, nanoseconds.
        gid: identifier of the publisher, 16 bytes.
    """

    sequence: int
    source_ns: int
    gid: bytes

    def __post_init__(self) -> None:
        if len(self.gid) != _GID_BYTES:
            raise InvalidRmwAttachment(f"gid: expected {_GID_BYTES} bytes, got {len(self.gid)}")

    @property
    def name(self) -> str:
        """Name of the sample, equal for all that receive it."""
        return f"{self.gid.hex()}-{self.sequence}-{self.source_ns}"

    def encode(self) -> bytes:
        """Encode the attachment, 33 bytes; raises InvalidRmwAttachment where a number is out of range."""
        try:
            return _ATTACHMENT.pack(self.sequence, self.source_ns, _GID_BYTES, self.gid)
        except struct.error as error:
            raise InvalidRmwAttachment(f"expected 64-bit numbers, got {self.sequence}, {self.source_ns}") from error

    @classmethod
    def decode(cls, data: bytes) -> "RmwAttachment":
        """Decode an attachment; raises InvalidRmwAttachment, also for the longer form of releases before 0.2.4."""
        if len(data) != _ATTACHMENT.size:
            raise InvalidRmwAttachment(f"expected rmw_zenoh's attachment of {_ATTACHMENT.size} bytes, got {len(data)}")
        sequence, source_ns, gid_bytes, gid = _ATTACHMENT.unpack(data)
        if gid_bytes != _GID_BYTES:
            raise InvalidRmwAttachment(f"gid: expected {_GID_BYTES} bytes, got a length of {gid_bytes}")
        return cls(sequence, source_ns, gid)
