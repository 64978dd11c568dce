"""Where ROS 2's topics are on Zenoh, and what travels beside a sample.

Topic `/tb3_1/scan` has three forms, by who puts it:

| who                         | key                                                                        |
|-----------------------------|----------------------------------------------------------------------------|
| zenoh-bridge-ros2dds        | `tb3_1/scan`                                                               |
| rmw_zenoh                   | `<domain>/tb3_1/scan/sensor_msgs::msg::dds_::LaserScan_/RIHS01_<64 digits>` |
| rmw_zenoh on humble         | the same, ending in `TypeHashNotSupported`                                 |

In this package a topic is written as in the first form: chunks with slashes between, none in front.
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
    """No topic, or no key of one; says what was expected."""


class InvalidRmwAttachment(ValueError):
    """Bytes that are not rmw_zenoh's attachment."""


@dataclass(frozen=True)
class MessageType:
    """A ROS 2 message type.

    Attributes:
        name: as in `sensor_msgs/msg/LaserScan`.
        rihs: its hash (REP-2011), which rmw_zenoh puts into keys.
    """

    name: str
    rihs: str

    @property
    def dds_name(self) -> str:
        """As in `sensor_msgs::msg::dds_::LaserScan_`."""
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


def type_name(told: str) -> str | None:
    """Write the name of a message type as in `sensor_msgs/msg/LaserScan`, however it is told; None: it names none."""
    found = _TYPE.fullmatch(told) or _DDS_TYPE.fullmatch(told)
    return None if found is None else f"{found[1]}/msg/{found[2]}"


@dataclass(frozen=True)
class TopicKey:
    """What a key says: the topic, and its type (`sensor_msgs/msg/LaserScan`) and domain where rmw_zenoh put it."""

    topic: str
    type_name: str | None = None
    domain: int | None = None


def check_topic(topic: str) -> str:
    """The topic itself; raises InvalidTopic unless it is chunks of `[A-Za-z0-9_]` with slashes between."""
    if not all(_CHUNK.fullmatch(chunk) for chunk in topic.split("/")):
        raise InvalidTopic(
            f"expected a topic like 'tb3_1/scan': chunks of letters, digits and '_' with '/' between, got {topic!r}"
        )
    return topic


def resolve(namespace: str, topic: str) -> str:
    """A topic below a namespace, as ROS resolves it: one that begins with `/` is absolute.

    Args:
        namespace: any number of chunks, with or without a leading slash; "" or "/" for none.
        topic: relative or absolute.

    Raises:
        InvalidTopic: it has other characters than a topic can have.
    """
    above = namespace.removeprefix("/")
    if topic.startswith("/"):
        return check_topic(topic[1:])
    return check_topic(f"{above}/{topic}" if above else topic)


def expressions(topic: str, domain: int = 0) -> tuple[str, ...]:
    """Build the key expressions that meet a resolved topic in all its forms.

    Whatever is published on it is met, so that a message of another type can be refused by name. `met` tells which.

    Args:
        topic: chunks with slashes between.
        domain: ROS_DOMAIN_ID of the nodes that publish by rmw_zenoh; a bridge's keys have none.

    Raises:
        InvalidTopic: it is no topic.
    """
    check_topic(topic)
    return topic, f"{domain}/{topic}/*/*"


def match_key(topic: str, key: str, domain: int = 0) -> TopicKey | None:
    """Read the key of a sample on a topic; None: it is of another topic, such as one below it, or another domain."""
    try:
        told = parse_key(key)
    except InvalidTopic:
        return None
    return told if told.topic == topic and told.domain in (None, domain) else None


def rmw_key(topic: str, type_: MessageType, domain: int = 0) -> str:
    """Where rmw_zenoh puts, and listens to, a topic."""
    return f"{domain}/{check_topic(topic)}/{type_.dds_name}/{type_.rihs}"


def parse_key(key: str) -> TopicKey:
    """The topic of a key in any of the forms; raises InvalidTopic where it has none of them."""
    chunks = key.split("/")
    of_rmw = _DDS_TYPE.fullmatch(chunks[-2]) if len(chunks) >= 4 else None
    if of_rmw is None:
        return TopicKey(check_topic(key))
    if not _DOMAIN.fullmatch(chunks[0]):
        raise InvalidTopic(f"expected '<domain>/<topic>/<type>/<hash>', got {key!r}")
    return TopicKey(check_topic("/".join(chunks[1:-2])), f"{of_rmw[1]}/msg/{of_rmw[2]}", int(chunks[0]))


@dataclass(frozen=True)
class RmwAttachment:
    """What rmw_zenoh sends beside each sample. A ROS node aborts on any other form: publish to it with this one.

    Attributes:
        sequence: counts the publisher's samples.
        source_ns: when it was published, in nanoseconds.
        gid: the publisher, 16 bytes.
    """

    sequence: int
    source_ns: int
    gid: bytes

    def __post_init__(self) -> None:
        if len(self.gid) != _GID_BYTES:
            raise InvalidRmwAttachment(f"gid: expected {_GID_BYTES} bytes, got {len(self.gid)}")

    @property
    def name(self) -> str:
        """One name for the sample, the same wherever it is heard."""
        return f"{self.gid.hex()}-{self.sequence}-{self.source_ns}"

    def encode(self) -> bytes:
        """33 bytes; raises InvalidRmwAttachment where a number does not fit."""
        try:
            return _ATTACHMENT.pack(self.sequence, self.source_ns, _GID_BYTES, self.gid)
        except struct.error as error:
            raise InvalidRmwAttachment(f"expected 64-bit numbers, got {self.sequence}, {self.source_ns}") from error

    @classmethod
    def decode(cls, data: bytes) -> "RmwAttachment":
        """Read one; raises InvalidRmwAttachment, also for the longer ones of releases before 0.2.4."""
        if len(data) != _ATTACHMENT.size:
            raise InvalidRmwAttachment(f"expected rmw_zenoh's attachment of {_ATTACHMENT.size} bytes, got {len(data)}")
        sequence, source_ns, gid_bytes, gid = _ATTACHMENT.unpack(data)
        if gid_bytes != _GID_BYTES:
            raise InvalidRmwAttachment(f"gid: expected {_GID_BYTES} bytes, told {gid_bytes}")
        return cls(sequence, source_ns, gid)
