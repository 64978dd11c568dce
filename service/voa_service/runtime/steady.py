"""Clock that does not follow a wall clock which is set forward."""

import time
from collections.abc import Callable
from datetime import datetime, timedelta


def _seconds_since_boot() -> float:
    """Seconds of a clock that is never set; where the system offers it, one that also runs while the machine sleeps."""
    boot = getattr(time, "CLOCK_BOOTTIME", None)
    return time.monotonic() if boot is None else time.clock_gettime(boot)


class SteadyClock:
    """Clock by which nothing becomes old because a clock was set: the wall clock, or an earlier time.

    A machine without a battery for its clock starts in the past or the future, and is set right by the network some
    minutes after. This clock follows the wall clock when it is set back. When it is set forward, this one goes on from
    where it was, until the process ends.

    Args:
        now: wall clock.
        seconds: clock that is never set, seconds.
    """

    def __init__(self, now: Callable[[], datetime], seconds: Callable[[], float] = _seconds_since_boot) -> None:
        self._now, self._seconds = now, seconds
        self._began_at, self._began_s = now(), seconds()

    def now(self) -> datetime:
        """Return the time, never later than that of the wall clock."""
        return min(self._now(), self._began_at + timedelta(seconds=self._seconds() - self._began_s))

    def behind_s(self) -> float:
        """Return by how much this clock is behind the wall clock, seconds, at least 0."""
        return (self._now() - self.now()).total_seconds()
