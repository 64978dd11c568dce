"""Following a session: each version once and in order, from news that may be late, repeated, lost or forged.

Only the service is trusted. A sample on the session's Zenoh key, where any program may publish, is a hint: a reason to
request the session's current version from the service. The versions between two requests are taken from hints if the
service's history, which has no beliefs, has entries with the same time. To forge such a version, a program would have
to know its time of commit before the service publishes it.

After a hint that the service does not confirm, the follower pauses, so that a flood of hints causes at most
`1 / PAUSE_S` requests per second.
"""

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from voa_client import _calls as calls
from voa_client._attempts import Patience, worth_another
from voa_client._call import Call, M
from voa_client._errors import NotFoundError, TimedOutError, UnexpectedResponseError, VoaClientError
from voa_client._mailbox import MOST_VERSIONS, Batch
from voa_client._responses import Response, read
from voa_client._transport import Deleted, Lost, State
from voa_client._versions import Version, confirmed, received, stored
from voa_msgs.sessions import HistoryPage, Session

PAUSE_S = 0.1
"""Pause after a hint that the service does not confirm, seconds."""
GRACE_S = 0.25
"""Longest wait for hints of versions that the service has, and that have not arrived yet, seconds."""
_SHORTEST_S = 0.001


@dataclass(frozen=True)
class Wait:
    """Step: wait for news, at most `seconds` (None: without limit); hints of versions up to `seen` are ignored."""

    seconds: float | None
    seen: int | None


@dataclass(frozen=True)
class Pause:
    """Step: do nothing for a number of seconds."""

    seconds: float


@dataclass(frozen=True)
class Send:
    """Step: make one attempt of a call, within a number of seconds."""

    call: Call[Any]
    seconds: float


Step = Wait | Pause | Send | Session
"""Next step of a follower; a `Session` is given to the caller."""
Result = Batch | Response | VoaClientError | None
"""Result of a step: of a `Wait` a batch, of a `Send` a response or the error, else None."""
Steps = Generator[Step, Result, Lost | None]


def next_step(steps: Steps, result: Result) -> Step | Lost | None:
    """Return the step after one with `result`; after the last, the value that `Following.steps` returns."""
    try:
        return steps.send(result)
    except StopIteration as end:
        lost: Lost | None = end.value
        return lost


class Following:
    """State of a follower of a session, and its next step; without I/O.

    Args:
        session_id: of the session.
        patience: time limits and retries.
        for_s: seconds after which to end; None: when the session is deleted.
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
        """Seconds until the end; None: without limit."""
        return None if self._for_s is None else max(0.0, self._began + self._for_s - self._patience.clock())

    @property
    def is_over(self) -> bool:
        """True if the session was deleted, or the time is over."""
        return self.ended or self.left_s == 0.0

    def within(self, seconds: float | None) -> float | None:
        """Shorten a duration in seconds so that it does not exceed the end; None: without limit."""
        left = self.left_s
        if seconds is None or left is None:
            return left if seconds is None else seconds
        return min(seconds, left)

    def steps(self, poll_s: float | None) -> Steps:
        """Give the steps for one watch of a transport; return why the watch must be restarted, or None at the end.

        Args:
            poll_s: polling interval of the transport, seconds; None: its watch reports the current version by itself.
        """
        lost = None if poll_s is None else (yield from self._poll({}, hinted=False))
        while lost is None and not self.is_over:
            pause = self._pause_until - self._patience.clock()
            if pause > 0.0:
                yield Pause(self.within(pause) or 0.0)
            batch = yield from self._wait(poll_s)
            for news in batch.news:
                lost = yield from self._take(news)
                if lost is not None or self.is_over:
                    return lost
            silent = batch.is_empty and poll_s is not None
            if (batch.hinted or silent) and not self.is_over:
                lost = yield from self._poll(batch.bodies, hinted=batch.hinted)
        return lost

    def lost(self, news: Lost) -> float:
        """Return the seconds to wait before a new watch.

        Once a version was received, the follower waits for the service without limit, even if another program answers
        in its place; before that, as long as for a call.

        Raises:
            VoaClientError: waiting is of no use, or no version was received within the time of a call.
        """
        error = news.error
        gone = isinstance(error, NotFoundError) and error.is_of_the_service
        if gone and self.seen is not None:
            self.ended = True
            return 0.0
        late = self._patience.clock() - self._began >= self._patience.timeout_s
        spoilt = self.seen is not None and isinstance(error, UnexpectedResponseError | NotFoundError)
        if (late and self.seen is None) or not (spoilt or worth_another(error)):
            raise error
        self._error = error
        self._failures += 1
        wait = self._patience.retries.wait_s(self._failures, self._patience.chance())
        return self.within(wait) or 0.0

    def end(self) -> None:
        """End the following; raises UnreachableError if no version was ever received."""
        if self.seen is None and not self.ended:
            raise self._error

    def _take(self, news: State | Deleted | Lost) -> Steps:
        """Take news from the service's own connection; where versions are missing, request the current one."""
        if isinstance(news, Lost):
            return news
        at: Version | None = None
        if isinstance(news, State):
            try:
                at = received(self._id, news.body)
            except UnexpectedResponseError as error:
                return Lost(error)
            if self.seen is not None and at.number <= self.seen:
                return None
        if at is None or self.seen is None or at.number > self.seen + 1:
            now = yield from self._now()
            if isinstance(now, Lost):
                return now
            if at is None or at.number > now.number:
                return Lost(
                    UnexpectedResponseError(f"the service does not have the newest event of session {self._id}")
                )
        yield self._new(at)
        return None

    def _poll(self, bodies: Mapping[int, Sequence[bytes]], *, hinted: bool) -> Steps:
        """Request the current version; give it to the caller if it is new, after the known versions before it."""
        now = yield from self._now()
        if isinstance(now, Lost):
            return now
        if self.seen is not None:
            if now.number <= self.seen:
                self._pause_until = self._patience.clock() + (PAUSE_S if hinted else 0.0)
                return None
            if hinted:
                between = range(self.seen + 1, now.number)
                hinted_bodies = yield from self._await_hints(between, bodies)
                yield from self._confirm(hinted_bodies, now.session)
        yield self._new(now)
        return None

    def _await_hints(
        self, between: range, bodies: Mapping[int, Sequence[bytes]]
    ) -> Generator[Step, Result, Mapping[int, Sequence[bytes]]]:
        """Collect samples that claim to be one of the versions in `between`, waiting up to `GRACE_S` for them."""
        hinted_bodies = {version: bodies[version] for version in between if version in bodies}
        until, left = self._patience.clock() + GRACE_S, GRACE_S
        while left > 0.0 and len(hinted_bodies) < len(between) <= MOST_VERSIONS and not self.is_over:
            batch = yield from self._wait(left)
            more = {version: each for version, each in batch.bodies.items() if version in between}
            hinted_bodies |= {version: [*hinted_bodies.get(version, ()), *each] for version, each in more.items()}
            # Every batch shortens the wait, so that a flood of samples cannot prolong it.
            left = 0.0 if batch.is_empty else min(left - _SHORTEST_S, until - self._patience.clock())
        return hinted_bodies

    def _confirm(self, hinted_bodies: Mapping[int, Sequence[bytes]], now: Session) -> Generator[Step, Result, None]:
        """Give the caller the versions that the service's history confirms; ends at a page without any of them."""
        left = sorted(hinted_bodies)
        while left:
            page = yield from self._send(calls.history(self._id, str(left[0] - 1)))
            entries = page.items if isinstance(page, HistoryPage) else []
            before = self.seen
            for entry in entries:
                session = confirmed(entry, hinted_bodies[entry.version], now) if entry.version in left else None
                if session is not None:
                    yield self._new(stored(self._id, session))
            reached = entries[-1].version if entries and self.seen != before else left[-1]
            left = [version for version in left if version > reached]

    def _now(self) -> Generator[Step, Result, Version | Lost]:
        """Request the current version of the session."""
        state = yield from self._send(calls.get_session(self._id))
        if not isinstance(state, Session):
            return Lost(state)
        try:
            now = stored(self._id, state)
        except UnexpectedResponseError as error:
            return Lost(error)
        self._failures = 0
        return now

    def _send(self, call: Call[M]) -> Generator[Step, Result, M | VoaClientError]:
        result = yield Send(call, self.within(self._patience.attempt_s) or _SHORTEST_S)
        if isinstance(result, VoaClientError):
            return result
        if not isinstance(result, Response):
            raise TypeError(f"expected the response to a request, or its error, got {type(result).__name__}")
        try:
            return read(call, result)
        except VoaClientError as error:
            return error

    def _wait(self, seconds: float | None) -> Generator[Step, Result, Batch]:
        result = yield Wait(self.within(seconds), self.seen)
        if not isinstance(result, Batch):
            raise TypeError(f"expected the news that arrived while waiting, got {type(result).__name__}")
        return result

    def _new(self, at: Version) -> Session:
        """Mark a version as seen, and return its session."""
        self.seen = at.number
        self._failures = 0
        return at.session
