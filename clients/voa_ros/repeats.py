"""Recognise scans that arrive twice, because two bridges, or a bridge and rmw_zenoh, forward each of them."""

import hashlib
from collections import deque

from voa_ros.messages import LaserScan, Stamp

REMEMBERED = 16
"""Number of latest revolutions with which a scan is compared."""


def payload_digest(payload: bytes) -> bytes:
    """Digest of a payload, 16 bytes (BLAKE2b)."""
    return hashlib.blake2b(payload, digest_size=16).digest()


class Repeats:
    """Memory of the latest revolutions that recognises repetitions.

    A revolution counts as a repetition only if its whole payload, stamp included, equals one of the last 16. A frozen
    stamp alone makes no repetition, because the noise of two revolutions differs. A stamp of 0 means that the driver
    has no clock; such scans never count as repetitions, so that a simulated lidar without noise can be used too.
    """

    def __init__(self) -> None:
        self._digests: deque[bytes] = deque(maxlen=REMEMBERED)
        self.in_a_row = 0
        """Number of repetitions since the last new revolution."""

    def is_repeated(self, scan: LaserScan, digest: bytes) -> bool:
        """Return True if a payload with this digest was received before; otherwise remember it."""
        if scan.stamp != Stamp() and digest in self._digests:
            self.in_a_row += 1
            return True
        self.in_a_row = 0
        self._digests.append(digest)
        return False
