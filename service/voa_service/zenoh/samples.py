"""Messages on the ROS 2 topics of mapped robots, as Zenoh delivers them."""

from dataclasses import dataclass

from voa_ros.topics import MessageType


@dataclass(frozen=True)
class Sample:
    """A message on a topic of a mapped robot.

    Attributes:
        type: of the message.
        key: key expression that it was published on.
        payload: the message as CDR.
        attachment: bytes beside the payload, if there are any.
        received_s: monotonic time of this process, in seconds.
    """

    type: MessageType
    key: str
    payload: bytes
    attachment: bytes | None
    received_s: float
