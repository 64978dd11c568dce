"""Compare the clocks of a robot's messages by their stamps and their times of arrival."""

from collections import deque

RECENT_S = 2.0
"""Messages of the last so many seconds determine the offset of a clock."""


class ClockOffset:
    """Offset between the clock of the receiver and the clock that stamps the messages.

    A message arrives some time after its stamp, and sometimes late. The smallest difference of the latest messages is
    the offset of the clocks plus the shortest delay. When stamps do not grow, the clock was set back or does not run,
    and the measurement starts again.
    """

    def __init__(self) -> None:
        self._recent: deque[tuple[float, float]] = deque()
        self._newest_s = 0.0

    @property
    def seconds(self) -> float | None:
        """Smallest difference of arrival and stamp of the latest messages, seconds; None: no message was received."""
        return min((offset for _, offset in self._recent), default=None)

    def receive(self, at_s: float, received_s: float) -> None:
        """Add a message.

        Args:
            at_s: stamp of the message, seconds by the robot's clock.
            received_s: time of arrival, seconds by any steady clock.
        """
        if self._recent and at_s <= self._newest_s:
            self._recent.clear()
        while self._recent and self._recent[0][0] < received_s - RECENT_S:
            self._recent.popleft()
        self._recent.append((received_s, received_s - at_s))
        self._newest_s = at_s
