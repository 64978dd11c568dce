"""How the clocks of a robot's messages compare: by their stamps and the times at which they arrive."""

from collections import deque

RECENT_S = 2.0
"""Messages that arrived within so long tell how far a clock is behind."""


class ClockOffset:
    """Difference between the clock that messages arrive by and the one that stamps them.

    A message arrives some time after its stamp, sometimes late; the least of the latest differences is that of the
    clocks, and of the shortest way. A clock that is set back, or stands, is known by the stamps at once.
    """

    def __init__(self) -> None:
        self._recent: deque[tuple[float, float]] = deque()
        self._newest_s = 0.0

    @property
    def seconds(self) -> float | None:
        """Arrival less stamp, the least of late; None: there was no message."""
        return min((offset for _, offset in self._recent), default=None)

    def receive(self, at_s: float, received_s: float) -> None:
        """Take the two times of a message.

        Args:
            at_s: its stamp, by the robot's clock.
            received_s: when it arrived, by any steady clock.
        """
        if self._recent and at_s <= self._newest_s:
            self._recent.clear()
        while self._recent and self._recent[0][0] < received_s - RECENT_S:
            self._recent.popleft()
        self._recent.append((received_s, received_s - at_s))
        self._newest_s = at_s
