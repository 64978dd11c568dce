"""Messages of recordings, and the error for a recording that cannot be read."""

from dataclasses import dataclass, field

from voa_client import VoaClientError


class UnreadableRecording(VoaClientError):
    """A file or folder is no recording, or has no message that can be used; the message says why."""


@dataclass(frozen=True)
class RecordedMessage:
    """A message of a recording, with its topic and type."""

    topic: str
    type_name: str
    """"sensor_msgs/msg/LaserScan"; "" where the recording does not say."""
    encoding: str
    """"cdr", "json", "ros1"."""
    log_ns: int
    """Time at which it was recorded, nanoseconds since 1970."""
    data: bytes
    schema: tuple[str, str] = field(repr=False, default=("", ""))
    """Encoding and text of the definition of the message's type."""
    key: str = ""
    """The Zenoh key on which `voa record` received it; "" where there is none."""
