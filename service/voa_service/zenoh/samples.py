"""Messages of mapped robots as they come from Zenoh."""

from dataclasses import dataclass

from voa_ros.topics import MessageType


@dataclass(frozen=True)
class Sample:
    """A message on one of a robot's topics, as it came."""

    type: MessageType
    key: str
    payload: bytes
    attachment: bytes | None
    received_s: float
