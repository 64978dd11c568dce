"""The sessions that a robot joins: which one a message belongs to, and which looks it had before the message came.

A robot joins its session with its first message, and another one with the first message after a claim. A process that
works on messages late may find, by then, another session than they belong to, and looks in it that are from after them.
So the session and its looks are read when the robot is mapped, and when a claim is noticed.
"""

from collections.abc import Callable

from voa_ros.stops import SameStop
from voa_service.usecases.sessions import Sessions
from voa_service.zenoh.ledger import LATE_S, LookLedger

FOLLOW_SECONDS = 1.0
"""Polling interval for changes of the mapping file, and of the session of a robot, in seconds."""
_MOST = 2
"""Ledgers that wait: of the session when the robot was mapped, and of the one that it was moved to before it joined."""


class Joining:
    """The sessions of a robot; not for several threads at once.

    Args:
        sessions: the use cases.
        robot: name of the robot in the mapping.
        same_stop: compares two looks; None: looks are identified by their digests, and none are read before.
        clock: monotonic time, seconds.
    """

    def __init__(self, sessions: Sessions, robot: str, same_stop: SameStop | None, clock: Callable[[], float]) -> None:
        self._sessions = sessions
        self._robot = robot
        self._same_stop = same_stop
        self._clock = clock
        self._session: str | None = None
        """Session that the robot joined last, or belonged to when it was mapped; None: not known, or none."""
        self._moved: tuple[str, float] | None = None
        """Session that the robot was moved to, and when this process noticed; None: it has joined its session."""
        self._prepared: dict[str, LookLedger] = {}

    def begin(self, session: str) -> None:
        """Note the session of a robot of which no message was received yet; raises Failure if it cannot be read."""
        self._session = session
        self._prepare(session)

    def session_at(self, received_s: float, session: str) -> str:
        """Return the session that a message belongs to, where the robot was moved to `session` meanwhile.

        A process that is late works on messages from before the move after it. They are of the session before, as for
        the processes that were in time: otherwise their looks would count in both sessions, and out of order.

        Args:
            received_s: time at which the message was received, by the clock.
            session: the robot's session by now.

        Raises:
            Failure: the session cannot be read.
        """
        if self._session is None or session == self._session:
            return session
        if self._moved is None or self._moved[0] != session:
            self._moved = session, self._clock()
            self._prepare(session)
        return session if received_s >= self._moved[1] - FOLLOW_SECONDS else self._session

    def join(self, session: str, received_s: float) -> LookLedger:
        """Let the robot join a session; returns the looks that it has.

        Args:
            session: id of the session.
            received_s: time at which the message was received with which the robot joins, by the clock.

        Raises:
            Failure: the session does not exist, or cannot be read; nothing is changed.
        """
        ledger = self._prepared.get(session)
        if ledger is None or self._clock() - received_s <= LATE_S:
            ledger = LookLedger(self._sessions, session, self._robot, self._same_stop, self._clock)
        self._prepared.pop(session, None)
        if self._moved is not None and self._moved[0] == session:
            self._moved = None
        self._session = session
        return ledger

    def leave(self) -> None:
        """Note that the robot belongs to no session."""
        self._session = self._moved = None
        self._prepared.clear()

    def _prepare(self, session: str) -> None:
        if self._same_stop is None:
            return
        self._prepared[session] = LookLedger(self._sessions, session, self._robot, self._same_stop, self._clock)
        while len(self._prepared) > _MOST:
            del self._prepared[next(iter(self._prepared))]
