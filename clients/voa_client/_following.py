"""A session's versions in order, each once, out of news that may be late, double, lost, cut off or forged.

The service alone is believed. What anybody may put on a bus is a hint: a reason to ask the service, which then says
how the session stands. The versions between two questions are taken from hints, if the service's history has them with
the same time; the history itself has no beliefs. Whoever wants to forge such a version has to know when it was
committed before the service has published it.

A hint that the service does not bear out costs a pause: a flood of them comes to `1 / PAUSE_S` questions a second.
"""

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from voa_client import _calls as calls
from voa_client._answers import Reply, read
from voa_client._attempts import Patience, worth_another
from voa_client._calls import Call, M
from voa_client._errors import NotFoundError, TimedOutError, UnexpectedAnswerError, VoaClientError
from voa_client._mailbox import MOST_VERSIONS, Batch
from voa_client._transport import Deleted, Lost, State
from voa_client._versions import Version, confirmed, received, stored
from voa_msgs.sessions import HistoryPage, Session

PAUSE_S = 0.1
"""After a hint that the service does not bear out."""
GRACE_S = 0.25
"""For hints of versions that the service has, and that are still on their way."""
_SHORTEST_S = 0.001


@dataclass(frozen=True)
class Wait:
    """Wait for news, at most so many seconds (None: for ever); hints of versions up to `seen` are of no use."""

    seconds: float | None
    seen: int | None


@dataclass(frozen=True)
class Pause:
    """Do nothing for so many seconds."""

    seconds: float


@dataclass(frozen=True)
class Ask:
    """Make one attempt of a call, in so many seconds."""

    call: Call[Any]
    seconds: float


Step = Wait | Pause | Ask | Session
"""Next step of a follower; a `Session` is for the caller."""
Result = Batch | Reply | VoaClientError | None
"""Result of a step: of a `Wait` a batch, of an `Ask` a reply or why there is none."""
Steps = Generator[Step, Result, Lost | None]


def taken(steps: Steps, result: Result) -> Step | Lost | None:
    """The step after one that came to `result`; at the end what `Following.steps` returns."""
    try:
        return steps.send(result)
    except StopIteration as end:
        lost: Lost | None = end.value
        return lost


class Following:
    """Knowledge of a follower, and the step that it takes next; without I/O.

    Args:
        session_id: which session.
        patience: how long to wait for what.
        for_s: when to end; None: with the session.
    """

    def __init__(self, session_id: str, patience: Patience, for_s: float | None) -> None:
        self.seen: int | None = None
        self.ended = False
        self._id = session_id
        self._patience = patience
        self._began = patience.clock()
        self._for_s = for_s
        self._failures = 0
        self._error: VoaClientError = TimedOutError("no news of the session came in time")
        self._pause_until = self._began

    @property
    def left_s(self) -> float | None:
        """Seconds until the end; None: there is none."""
        return None if self._for_s is None else max(0.0, self._began + self._for_s - self._patience.clock())

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to come."""
        return self.ended or self.left_s == 0.0

    def within(self, seconds: float | None) -> float | None:
        """So long, but not beyond the end; None: for ever."""
        left = self.left_s
        if seconds is None or left is None:
            return left if seconds is None else seconds
        return min(seconds, left)

    def steps(self, ask_s: float | None) -> Steps:
        """Follow along one watch; returns why it must be begun anew, or None if all is over.

        Args:
            ask_s: as the transport's; None: the watch says by itself how the session stands.
        """
        lost = None if ask_s is None else (yield from self._look({}, hinted=False))
        while lost is None and not self.is_over:
            pause = self._pause_until - self._patience.clock()
            if pause > 0.0:
                yield Pause(self.within(pause) or 0.0)
            batch = yield from self._wait(ask_s)
            for news in batch.news:
                lost = yield from self._take(news)
                if lost is not None or self.is_over:
                    return lost
            silent = batch.is_empty and ask_s is not None
            if (batch.hinted or silent) and not self.is_over:
                lost = yield from self._look(batch.bodies, hinted=batch.hinted)
        return lost

    def lost(self, news: Lost) -> float:
        """Seconds to wait before a new watch.

        A service that went away is waited for as long as it takes, and so is one in whose place something else
        answers; one that was never there, as long as a call.

        Raises:
            VoaClientError: there is no use in waiting, or nothing was ever received within the time of a call.
        """
        error = news.error
        gone = isinstance(error, NotFoundError) and error.is_of_the_service
        if gone and self.seen is not None:
            self.ended = True
            return 0.0
        late = self._patience.clock() - self._began >= self._patience.timeout_s
        spoilt = self.seen is not None and isinstance(error, UnexpectedAnswerError | NotFoundError)
        if (late and self.seen is None) or not (spoilt or worth_another(error)):
            raise error
        self._error = error
        self._failures += 1
        wait = self._patience.retries.wait_s(self._failures, self._patience.chance())
        return self.within(wait) or 0.0

    def end(self) -> None:
        """The time is over; raises UnreachableError if nothing was ever received."""
        if self.seen is None and not self.ended:
            raise self._error

    def _take(self, news: State | Deleted | Lost) -> Steps:
        """Take what came over the service's own connection; where that is odd, the service is asked."""
        if isinstance(news, Lost):
            return news
        at: Version | None = None
        if isinstance(news, State):
            try:
                at = received(self._id, news.body)
            except UnexpectedAnswerError as error:
                return Lost(error)
            if self.seen is not None and at.number <= self.seen:
                return None
        if at is None or self.seen is None or at.number > self.seen + 1:
            now = yield from self._now()
            if isinstance(now, Lost):
                return now
            if at is None or at.number > now.number:
                return Lost(UnexpectedAnswerError(f"the events of session {self._id} contradict the service"))
        yield self._new(at)
        return None

    def _look(self, bodies: Mapping[int, Sequence[bytes]], *, hinted: bool) -> Steps:
        """Ask how the session stands, and hand out what is new, with what lies between as far as it is known."""
        now = yield from self._now()
        if isinstance(now, Lost):
            return now
        if self.seen is not None:
            if now.number <= self.seen:
                self._pause_until = self._patience.clock() + (PAUSE_S if hinted else 0.0)
                return None
            if hinted:
                between = range(self.seen + 1, now.number)
                found = yield from self._await_hints(between, bodies)
                yield from self._confirm(found, now.session)
        yield self._new(now)
        return None

    def _await_hints(
        self, between: range, bodies: Mapping[int, Sequence[bytes]]
    ) -> Generator[Step, Result, Mapping[int, Sequence[bytes]]]:
        """Samples that claim to be one of some versions: those at hand, and those that come within the grace."""
        found = {version: bodies[version] for version in between if version in bodies}
        until, left = self._patience.clock() + GRACE_S, GRACE_S
        while left > 0.0 and len(found) < len(between) <= MOST_VERSIONS and not self.is_over:
            batch = yield from self._wait(left)
            more = {version: each for version, each in batch.bodies.items() if version in between}
            found |= {version: [*found.get(version, ()), *each] for version, each in more.items()}
            # A batch takes its part of the grace, however quickly it came and whatever the clock says.
            left = 0.0 if batch.is_empty else min(left - _SHORTEST_S, until - self._patience.clock())
        return found

    def _confirm(self, found: Mapping[int, Sequence[bytes]], now: Session) -> Generator[Step, Result, None]:
        """Hand out the versions that the service's history has; a page that has none of them is the last one."""
        left = sorted(found)
        while left:
            page = yield from self._ask(calls.history(self._id, str(left[0] - 1)))
            entries = page.items if isinstance(page, HistoryPage) else []
            before = self.seen
            for entry in entries:
                session = confirmed(entry, found[entry.version], now) if entry.version in left else None
                if session is not None:
                    yield self._new(stored(self._id, session))
            reached = entries[-1].version if entries and self.seen != before else left[-1]
            left = [version for version in left if version > reached]

    def _now(self) -> Generator[Step, Result, Version | Lost]:
        """Ask how the session stands."""
        answer = yield from self._ask(calls.get_session(self._id))
        if not isinstance(answer, Session):
            return Lost(answer)
        try:
            now = stored(self._id, answer)
        except UnexpectedAnswerError as error:
            return Lost(error)
        self._failures = 0
        return now

    def _ask(self, call: Call[M]) -> Generator[Step, Result, M | VoaClientError]:
        result = yield Ask(call, self.within(self._patience.attempt_s) or _SHORTEST_S)
        assert isinstance(result, Reply | VoaClientError)  # noqa: S101 - as whoever takes the steps promises
        if isinstance(result, VoaClientError):
            return result
        try:
            return read(call, result)
        except VoaClientError as error:
            return error

    def _wait(self, seconds: float | None) -> Generator[Step, Result, Batch]:
        result = yield Wait(self.within(seconds), self.seen)
        assert isinstance(result, Batch)  # noqa: S101 - as whoever takes the steps promises
        return result

    def _new(self, at: Version) -> Session:
        """The session of a version, which is seen from now on."""
        self.seen = at.number
        self._failures = 0
        return at.session
