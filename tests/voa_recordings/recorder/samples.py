"""Samples as the recorder receives them."""

from typing import Any

from tests.voa_recordings.files.bags import START_NS
from voa_recordings.recorder.inbox import ReceivedSample

NEXT = START_NS + 1_000_000_000
RMW = "0/tb3_1/scan/sensor_msgs::msg::dds_::LaserScan_/RIHS01_x"


def received(key: str, payload: bytes = b"", **changes: Any) -> ReceivedSample:
    content: dict[str, Any] = {
        "attachment": b"", "encoding": "zenoh/bytes", "deleted": False, "log_ns": NEXT, "sent_ns": None,
    }  # fmt: skip
    return ReceivedSample(key, payload, **(content | changes))
