"""Keys on which a topic is published for a bridge or for rmw_zenoh, its attachments, and its announcement.

ROS tools list the topics that have publishers. A bridge learns of publishers on Zenoh from liveliness tokens of other
bridges, and a node of rmw_zenoh from those of other nodes; the service declares such tokens for its topics.
"""

import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from voa_ros.robots import RobotMapping
from voa_ros.topics import MessageType, RmwAttachment, rmw_key

_GID_BYTES = 16
_BRIDGE_QOS = ":1:0:0,10"
"""Quality of service in a bridge's token: without a key, reliable, volatile, the last ten messages."""
_RMW_QOS = "::,10:,:,:,,"
"""Quality of service in a token of rmw_zenoh: its defaults, the last ten messages."""
_NODE = "voa"
"""Name of the node to which tools of rmw_zenoh attribute the topics."""


@dataclass(frozen=True)
class Address:
    """Key of a sample, and its attachment; None: it has none."""

    key: str
    attachment: bytes | None = None


class Addresses:
    """Keys of the samples of one robot's outputs; each topic counts as a publisher of its own.

    Args:
        mapping: names the middleware and the domain.
        now_ns: clock, nanoseconds since 1970.
    """

    def __init__(self, mapping: RobotMapping, now_ns: Callable[[], int] = time.time_ns) -> None:
        self._mapping = mapping
        self._now_ns = now_ns
        self._publishers: dict[str, bytes] = {}
        self._sent: dict[str, int] = {}

    def next(self, topic: str, type_: MessageType) -> Address:
        """Return the address of the next sample of a topic."""
        if self._mapping.outputs.middleware == "bridge":
            return Address(topic)
        gid = self._publishers.setdefault(topic, secrets.token_bytes(_GID_BYTES))
        self._sent[topic] = self._sent.get(topic, 0) + 1
        attachment = RmwAttachment(self._sent[topic], self._now_ns(), gid)
        return Address(rmw_key(topic, type_, self._mapping.domain), attachment.encode())


def announcements(mapping: RobotMapping, zid: str, types: Mapping[str, MessageType]) -> list[str]:
    """Build the keys of the liveliness tokens by which ROS tools learn of topics.

    Args:
        mapping: names the middleware and the domain.
        zid: identifier of the Zenoh session that publishes.
        types: type of each topic that is published.
    """
    if mapping.outputs.middleware == "bridge":
        return [
            f"@/{zid}/@ros2_lv/MP/{_joined(topic, '§')}/{_joined(type_.name, '§')}/{_BRIDGE_QOS}:typehash={type_.rihs};"
            for topic, type_ in types.items()
        ]
    node = f"@ros2_lv/{mapping.domain}/{zid}/0"
    named = f"%/%/{_NODE}"
    return [
        f"{node}/0/NN/{named}",
        *(
            f"{node}/{number}/MP/{named}/%{_joined(topic, '%')}/{type_.dds_name}/{type_.rihs}/{_RMW_QOS}"
            for number, (topic, type_) in enumerate(types.items(), 1)
        ),
    ]


def _joined(path: str, sign: str) -> str:
    """Replace the slashes of a path, so that it is a single chunk of a key."""
    return path.replace("/", sign)
