"""Which looks of a robot a session has, and which of them are known to this process: each stop counts once.

Every replica receives what the robots send and gathers looks of the same stops, but not always of the same
revolutions: one of them was started during a stop, or has had a look refused and begun again, or has received a pose
a little later. So a look is known by its stop. What the session has accepted of this robot since the stop began, and
what this process has not recognised yet, is compared with it: the same place is the same stop. Where there are no stops
(modes `every` and `on_request`), a look is known by its digest.
"""

from collections import deque

from voa_msgs.sessions import ScanRequest
from voa_ros.looks import GatheredLook, robot_of
from voa_service.usecases.sessions import Sessions
from voa_service.zenoh.stops import SameStop

_NEWEST = 50
"""Versions of a session among which the newest look of a robot is searched when its session is entered."""
_MOST_ENTRIES = 1_000
"""Versions of a session since a stop began among which a look of it is searched."""
_REMEMBERED = 1_024
"""Looks that are remembered as recognised; more are never under way."""


class LookLedger:
    """The looks of one robot in one session, as one process knows them. Not for several threads at once."""

    def __init__(self, sessions: Sessions, session: str, robot: str, same_stop: SameStop | None) -> None:
        """Begin with what the session has.

        Args:
            sessions: the use cases.
            session: id.
            robot: name in the mapping.
            same_stop: None: looks are known by their digests.

        Raises:
            Failure: the session is not there, or cannot be read.
        """
        self.session = session
        self._sessions = sessions
        self._robot = robot
        self._same_stop = same_stop
        self._versions: deque[int] = deque(maxlen=_REMEMBERED)
        """Versions made by looks that were taken, or recognised, here."""
        self._numbers: set[int] = set()
        """Numbers of the same looks, as far as they are larger than `_all_until`."""
        self._digests: deque[str] = deque(maxlen=_REMEMBERED)
        """Of the looks that were taken here."""
        self.version = max(-1, sessions.state(session).version - _NEWEST)
        """Version of the session when the present stop began; the looks after it may be of this stop."""
        self._seen = 0
        self.newest = self.begin_stop()
        """The robot's newest look when this began; None: there was none lately."""
        self._all_until = self._seen
        """Looks with numbers up to this one are recognised, or have nothing to do with what comes."""

    def begin_stop(self) -> ScanRequest | None:
        """Note what the session has as a stop begins.

        Returns:
            The newest look of this robot where others took it since the stop before; None: it is known here.

        Raises:
            Failure: the session is not there, or cannot be read.
        """
        before, version = self.version, self._sessions.state(self.session).version
        newest = self._sessions.robot_looks(self.session, self._robot, 1)
        number = newest[0].number if newest else 0
        found = None
        if number > self._seen and self._others_since(number - self._seen):
            fresh = [look for made, look in self._looks_after(before) if made not in self._versions]
            found = fresh[-1] if fresh else None
        self.version, self._seen = version, number
        return found

    def _others_since(self, count: int) -> bool:
        """Whether others took one of the newest looks, so many."""
        newest = self._sessions.robot_looks(self.session, self._robot, min(count, _NEWEST))
        return any(look.digest not in self._digests for look in newest)

    def take(self, taken: GatheredLook) -> None:
        """Note that a look was taken here."""
        self._digests.append(taken.digest)

    def doubt(self, taken: GatheredLook) -> None:
        """Note that it is not known whether the session has a look that was taken here: its answer was lost."""
        if taken.digest in self._digests:
            self._digests.remove(taken.digest)

    def next_number(self, taken: GatheredLook, since: int) -> int | None:
        """Find the number under which a look is to be applied.

        Args:
            taken: the look.
            since: version of the session when its stop began.

        Returns:
            One more than the looks that the session has of the robot; None: it has this one.

        Raises:
            Failure: the session cannot be read.
        """
        newest = self._sessions.robot_looks(self.session, self._robot, 1)
        count = newest[0].number if newest else 0  # read first: a look that comes later takes the number
        if self._same_stop is None:
            recognised = self._by_digest(taken, count)
        else:
            recognised = self._by_stop(taken, since, self._same_stop)
        return None if recognised else count + 1

    def accepted(self, number: int, version: int) -> None:
        """Note that the session has accepted a look that was taken here."""
        self._recognise(number)
        self._versions.append(version)

    def _by_digest(self, taken: GatheredLook, count: int) -> bool:
        """Recognise a look of this digest that was not recognised before."""
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
        """Recognise the oldest look of this stop that was not recognised before."""
        for version, look in self._looks_after(since):
            if version not in self._versions and same_stop(taken.request, look):
                self._versions.append(version)
                return True
        return False

    def _looks_after(self, version: int) -> list[tuple[int, ScanRequest]]:
        """Looks of this robot after a version of the session, oldest first, each with the version that it made."""
        entries = self._sessions.entries_after(self.session, version, _MOST_ENTRIES)
        scans = [(e.state.version, ScanRequest.model_validate_json(e.request)) for e in entries if e.kind == "scan"]
        return [(made, look) for made, look in scans if robot_of(look) == self._robot]
