"""Scans that arrive twice: two bridges, or a bridge and rmw_zenoh, bring each revolution of a robot once each."""

import hashlib
from collections import deque

from voa_ros.messages import LaserScan, Stamp

REMEMBERED = 16
"""Revolutions among which a scan is looked for."""


def payload_digest(payload: bytes) -> bytes:
    """Name of a message: 16 bytes that two different payloads do not share."""
    return hashlib.blake2b(payload, digest_size=16).digest()


class Repeats:
    """Tells a revolution that was received before from a new one.

    A revolution counts as received before only if its whole payload, stamp included, equals one of the last 16. A stamp
    that is frozen or set back makes no scan a repetition: the ranges of two revolutions differ by their noise. A stamp
    of 0 says that the driver has no clock; such scans are never taken for repetitions, so that a simulated lidar
    without noise is used too.
    """

    def __init__(self) -> None:
        self._digests: deque[bytes] = deque(maxlen=REMEMBERED)
        self.in_a_row = 0
        """Repetitions since the last new revolution."""

    def is_repeated(self, scan: LaserScan, digest: bytes) -> bool:
        """Whether the payload with this digest was received before; it is remembered if not."""
        if scan.stamp != Stamp() and digest in self._digests:
            self.in_a_row += 1
            return True
        self.in_a_row = 0
        self._digests.append(digest)
        return False
