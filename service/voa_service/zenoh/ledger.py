"""The looks of a robot that a session has accepted, so that each stop of the robot counts once among all replicas.

Every replica receives all messages of the robots and gathers looks at the same stops, but not always from the same
revolutions: a replica may have started during a stop, have begun again after a refused look, or have received a pose
later. A look is therefore identified by its stop: it is compared with the looks that the session has accepted of this
robot since the stop began and that this process has not matched yet; looks from one place are of one stop. Where there
are no stops (modes `every` and `on_request`), a look is identified by its digest.

A process may work on messages long after it received them, when others have counted looks at this stop and at later
ones. The version of the session from before a stop is then one that was read before the stop's messages came.
"""

import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from voa_msgs.sessions import ScanRequest
from voa_ros.looks import GatheredLook, robot_of
from voa_ros.messages import Stamp
from voa_ros.scans import stamp_json
from voa_ros.stops import SameStop
from voa_service.usecases.sessions import Sessions

_NEWEST = 50
"""Number of newest versions of a session that are searched for looks of a robot when the robot joins the session."""
_MOST_ENTRIES = 1_000
"""Number of versions since a stop began that are searched for a look at that stop."""
_REMEMBERED = 1_024
"""Number of recognised looks that are remembered; fewer are ever under way."""
LATE_S = 0.1
"""Time from which a message is worked on late after it was received, seconds: looks at later stops may exist then."""


class _Reading(NamedTuple):
    """Version of a session, and the time by which it had been read, seconds by the process's clock."""

    read_s: float
    version: int


class LookLedger:
    """The looks of a robot in a session, as this process knows them; not for several threads at once."""

    def __init__(
        self,
        sessions: Sessions,
        session: str,
        robot: str,
        same_stop: SameStop | None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Begin with the looks that the session has.

        Args:
            sessions: the use cases.
            session: id of the session.
            robot: name of the robot in the mapping.
            same_stop: compares two looks; None: looks are identified by their digests.
            clock: monotonic time, seconds.

        Raises:
            Failure: the session does not exist, or cannot be read.
        """
        self.session = session
        self._sessions = sessions
        self._robot = robot
        self._same_stop = same_stop
        self._clock = clock
        self._versions: deque[int] = deque(maxlen=_REMEMBERED)
        """Versions of the session that this process made by its looks, or recognised as looks at its stops."""
        self._numbers: set[int] = set()
        """Numbers of the recognised looks above `_all_until`."""
        self._digests: deque[str] = deque(maxlen=_REMEMBERED)
        """Digests of the looks that this process has given out."""
        reading, number = self._read()
        self._readings = deque([reading])
        """Readings of the session, in order; the first is the newest from before the current stop, if there is one."""
        self.version = max(-1, reading.version - _NEWEST)
        """Version of the session from before the current stop; looks of later versions may be of this stop."""
        self._seen = 0
        self.newest = self._newest_by_others(reading.version, number)
        """Newest look of the robot when this ledger began; None: the session has none among its newest versions."""
        self._all_until = self._seen
        """Looks up to this number are recognised, or too old to be looks at a coming stop."""
        self._before = self._looks_before()
        """Digests of the newest of these looks, of which another process may have been first to receive one."""

    def begin_stop(self, began_s: float, received_s: float) -> ScanRequest | None:
        """Note the version of the session from before a stop.

        Args:
            began_s: time at which the first message of the stop was received, seconds by the clock.
            received_s: time at which its newest message was received.

        Returns:
            The robot's newest look, if another process has applied it since the previous stop; else None. Also None
            where the message is worked on late: that look may be of a later stop.

        Raises:
            Failure: the session does not exist, or cannot be read.
        """
        reading, number = self._read()
        self._readings.append(reading)
        while len(self._readings) > 1 and self._readings[1].read_s <= began_s:
            self._readings.popleft()
        if reading.read_s - received_s <= LATE_S:
            return self._newest_by_others(reading.version, number)
        self.version = self._readings[0].version
        return None

    def _read(self) -> tuple[_Reading, int]:
        """Read the version of the session, and the number of looks of this robot that it has accepted."""
        version = self._sessions.state(self.session).version
        newest = self._sessions.robot_looks(self.session, self._robot, 1)
        return _Reading(self._clock(), version), newest[0].number if newest else 0

    def _newest_by_others(self, version: int, number: int) -> ScanRequest | None:
        """Begin a stop at a version with a number of looks; returns the newest look that another process applied."""
        before, unknown = self.version, None
        if number > self._seen and self._others_since(number - self._seen):
            fresh = [look for made, look in self._looks_after(before) if made not in self._versions]
            unknown = fresh[-1] if fresh else None
        self.version, self._seen = version, number
        return unknown

    def _looks_before(self) -> list[str]:
        """Return the digests of the newest looks that the session had when this ledger began.

        Empty where some are equal, as those of a lidar without a clock and without noise: they name no look then.
        """
        if self._same_stop is not None or self._seen == 0:
            return []
        newest = self._sessions.robot_looks(self.session, self._robot, _NEWEST)
        digests = [look.digest for look in newest if look.number <= self._seen]
        return digests if len(set(digests)) == len(digests) else []

    def _others_since(self, count: int) -> bool:
        """Return True if another process applied one of the robot's `count` newest looks."""
        newest = self._sessions.robot_looks(self.session, self._robot, min(count, _NEWEST))
        return any(look.digest not in self._digests for look in newest)

    def take(self, taken: GatheredLook) -> None:
        """Note that this process gives out a look."""
        self._digests.append(taken.digest)

    def doubt(self, taken: GatheredLook) -> None:
        """Note that a look of this process may or may not be in the session, because its response was lost."""
        if taken.digest in self._digests:
            self._digests.remove(taken.digest)

    def next_number(self, taken: GatheredLook, since: int) -> int | None:
        """Return the number under which a look is to be applied.

        Args:
            taken: the look.
            since: version of the session when the look's stop began.

        Returns:
            The number of looks that the session has of the robot, plus one; None where it already has this look.

        Raises:
            Failure: the session cannot be read.
        """
        newest = self._sessions.robot_looks(self.session, self._robot, 1)
        count = newest[0].number if newest else 0  # read first, so that a look written after this takes the number
        if self._same_stop is None:
            recognised = self._by_digest(taken, count)
        else:
            recognised = self._by_stop(taken, since, self._same_stop)
        return None if recognised else count + 1

    def accepted(self, number: int, version: int) -> None:
        """Note that the session has accepted a look of this process, under a number, as a version."""
        self._recognise(number)
        self._versions.append(version)

    def _by_digest(self, taken: GatheredLook, count: int) -> bool:
        """Return True for a look in the session with this digest that was not recognised before; recognises it."""
        if taken.digest in self._before and _has_time(taken):
            self._before.remove(taken.digest)
            return True
        self._all_until = max(self._all_until, count - _REMEMBERED)
        if count == self._all_until:
            return False
        for look in self._sessions.robot_looks(self.session, self._robot, count - self._all_until):
            if look.digest == taken.digest and look.number > self._all_until and look.number not in self._numbers:
                self._recognise(look.number)
                return True
        return False

    def _recognise(self, number: int) -> None:
        self._numbers.add(number)
        while self._all_until + 1 in self._numbers:
            self._all_until += 1
        self._numbers = {each for each in self._numbers if each > self._all_until}

    def _by_stop(self, taken: GatheredLook, since: int, same_stop: SameStop) -> bool:
        """Return True for a look in the session at this stop that was not recognised before; recognises the oldest."""
        for version, look in self._looks_after(since):
            if version not in self._versions and same_stop(taken.request, look):
                self._versions.append(version)
                return True
        return False

    def _looks_after(self, version: int) -> list[tuple[int, ScanRequest]]:
        """List the looks of this robot after a version of the session, oldest first, each with the version it made."""
        entries = self._sessions.entries_after(self.session, version, _MOST_ENTRIES)
        scans = [(e.state.version, ScanRequest.model_validate_json(e.request)) for e in entries if e.kind == "scan"]
        return [(made, look) for made, look in scans if robot_of(look) == self._robot]


def _has_time(look: GatheredLook) -> bool:
    """True if the driver of the lidar states times; where it does not, looks with equal digests may differ."""
    stamp = look.request.scan.stamp
    return not (isinstance(stamp, dict) and stamp.get("to") == stamp_json(Stamp()))
