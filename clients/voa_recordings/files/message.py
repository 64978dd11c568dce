"""The message of a recording, and the error of a recording that cannot be read."""

from dataclasses import dataclass, field

from voa_client import VoaClientError


class UnreadableRecording(VoaClientError):
    """A recording that is none, or that has nothing in it that can be used."""


@dataclass(frozen=True)
class RecordedMessage:
    """One message of a recording."""

    topic: str
    type_name: str
    """"sensor_msgs/msg/LaserScan"; "" where the recording does not say."""
    encoding: str
    """"cdr", "json", "ros1"."""
    log_ns: int
    """When it was recorded, nanoseconds since 1970."""
    data: bytes
    schema: tuple[str, str] = field(repr=False, default=("", ""))
    """Encoding and text of the type's definition."""
    key: str = ""
    """The Zenoh key on which `voa record` received it; "" where there is none."""
