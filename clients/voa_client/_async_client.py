"""The client for asyncio: one coroutine per call of the service, over any transport."""

import asyncio
import random
import time
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from voa_client import _calls as calls
from voa_client._addresses import async_transport_to
from voa_client._async_contents import AsyncContents
from voa_client._attempts import ATTEMPT_S, RETRIES, TIMEOUT_S, Attempts, Patience, Retries, new_key
from voa_client._call import Call, M
from voa_client._errors import VoaClientError
from voa_client._following import Following, Pause, Result, Send, Step, Wait, next_step
from voa_client._mailbox import AsyncMailbox
from voa_client._responses import read
from voa_client._transport import AsyncTransport
from voa_msgs.callers import Caller
from voa_msgs.looks import AnnouncedLook, LookAnnouncement
from voa_msgs.problems import Health
from voa_msgs.rankings import RankedGrasps, Ranking, RankingRequest, VoaRequest
from voa_msgs.robots import ClaimRequest, RobotReport, Robots, RobotScan
from voa_msgs.sessions import (
    BeliefRequest,
    HistoryEntry,
    OutcomeRequest,
    ScanRequest,
    Session,
    SessionRequest,
    SessionSummary,
    UpdatedEstimate,
    UpdatedSession,
    UpdateRequest,
)


class AsyncClient(AsyncContents):
    """Client of one service; use as an asynchronous context manager.

    A call is tried again until `timeout_s` is over if the service cannot be reached or is overloaded. All attempts of
    one write share an idempotency key, so that it takes effect once; another process can repeat it by the same `key`.

    Methods raise `VoaClientError`: `UnreachableError` without a response in time, `ProblemError` after a refusal.

    Args:
        to: an address (`http://`, `https://`, `zenoh://`, `zenoh+tls://`, or an endpoint like `tcp/127.0.0.1:7447`;
            such as `zenoh://user:password@lab:7447/voa/v1/lab7`), or a transport.
        timeout_s: longest duration of a call with all its attempts, seconds.
        attempt_s: longest duration of an attempt, seconds; rankings, predictions, uploads and scenarios may use all of
            `timeout_s` for one.
        retries: waits between attempts.
        key: API key of the caller; without it and `key_file`, that of the environment: `VOA_KEY`, `VOA_KEY_FILE`.
        key_file: file with the API key, which is read again when it changes.
        clock: returns seconds that never go back.
        sleep: waits for a number of seconds.
        chance: returns random numbers, uniform in [0, 1).
        keys: returns new idempotency keys.
    """

    def __init__(
        self,
        to: str | AsyncTransport,
        timeout_s: float = TIMEOUT_S,
        attempt_s: float = ATTEMPT_S,
        retries: Retries = RETRIES,
        *,
        key: str | None = None,
        key_file: Path | str | None = None,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        chance: Callable[[], float] = random.random,
        keys: Callable[[], str] = new_key,
    ) -> None:
        self._patience = Patience(timeout_s, attempt_s, retries, clock, chance, keys)
        self._sleep = sleep
        self._transport = async_transport_to(to, key, key_file)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Release the transport; leaving a `with` does it."""
        await self._transport.close()

    async def health(self) -> Health:
        """Return the state of the service, after one attempt."""
        call = calls.health()
        return read(call, await self._transport.send(call, None, self._patience.attempt_s))

    async def ready(self) -> Health:
        """Wait until the service is ready to answer, and return its state."""
        return await self._do(calls.health())

    async def caller(self) -> Caller:
        """Return who the service takes this client for by its key, and the calls that it may make."""
        return await self._do(calls.caller())

    async def create_session(self, request: SessionRequest, *, key: str | None = None) -> Session:
        """Open a session; the scans of the mapped robots in `request.robots` go to it from now on.

        Raises:
            InvalidRequestError: there is no such scenario or mapped robot, or the prior is not valid.
            ConflictError: the mapping of a robot names a session, or another scenario.
        """
        return await self._do(calls.create_session(request), key)

    async def get_session(self, session_id: str) -> Session:
        """Return the current version of a session."""
        return await self._do(calls.get_session(session_id))

    def list_sessions(self) -> AsyncIterator[SessionSummary]:
        """Yield every session, oldest first; they are fetched a page at a time."""
        return self._items(calls.list_sessions)

    async def delete_session(self, session_id: str, *, key: str | None = None, if_match: int | None = None) -> None:
        """Delete a session with its history; with `if_match` only if it has that version (over HTTP only)."""
        await self._do(calls.delete_session(session_id, if_match), key)

    def history(self, session_id: str, *, beliefs: bool = False, after: int = -1) -> AsyncIterator[HistoryEntry]:
        """Yield each version above `after` with the request that made it, and with its belief if `beliefs` is true."""
        first = None if after < 0 else str(after)
        return self._items(lambda page: calls.history(session_id, page or first, beliefs=beliefs))

    async def put_belief(
        self, session_id: str, request: BeliefRequest, *, key: str | None = None, if_match: int | None = None
    ) -> Session:
        """Replace a session's belief, or reset it to the prior; `if_match`, over HTTP: only if it has that version."""
        return await self._do(calls.put_belief(session_id, request, if_match), key)

    async def report_outcome(
        self, session_id: str, request: OutcomeRequest, *, key: str | None = None, if_match: int | None = None
    ) -> UpdatedSession:
        """Update a session's belief by a grasp's outcome; with `if_match`, over HTTP, only if it has that version."""
        return await self._do(calls.report_outcome(session_id, request, if_match), key)

    async def apply_scan(
        self, session_id: str, request: ScanRequest, *, key: str | None = None, if_match: int | None = None
    ) -> UpdatedSession:
        """Update a session's belief by a raw scan.

        Args:
            session_id: of the session.
            request: the scan, and the place where it was taken.
            key: idempotency key; None: a new key.
            if_match: version that the session must have, else `StaleVersionError` is raised; over HTTP only.
        """
        return await self._do(calls.apply_scan(session_id, request, if_match), key)

    async def announce_look(
        self, session_id: str, request: LookAnnouncement, *, key: str | None = None
    ) -> AnnouncedLook:
        """Announce a look that is under way, so that the session's rankings value other looks by what they add to it.

        A scan from its place, `cancel_look`, or 120 s end the announcement. The session's version stays unchanged.
        """
        return await self._do(calls.announce_look(session_id, request), key)

    async def cancel_look(self, session_id: str, look_id: str) -> None:
        """End the announcement of a look, after one attempt; raises NotFoundError if it has ended already."""
        call = calls.cancel_look(session_id, look_id)
        read(call, await self._transport.send(call, None, self._patience.attempt_s))

    async def rank_looks(self, session_id: str, request: VoaRequest | None = None) -> Ranking:
        """Rank looks by Value of Assistance, and recommend a look or a grasp."""
        return await self._do(calls.rank_looks(session_id, request or VoaRequest()))

    async def rank_grasps(self, session_id: str, reachable: list[str] | None = None) -> RankedGrasps:
        """Rank grasps by their expected score, the best first."""
        return await self._do(calls.rank_grasps(session_id, reachable))

    async def update_once(self, request: UpdateRequest) -> UpdatedEstimate:
        """Update the belief in the request by a scan; the service stores nothing."""
        return await self._do(calls.update_once(request))

    async def rank_once(self, request: RankingRequest) -> Ranking:
        """Rank looks for the belief in the request; the service stores nothing."""
        return await self._do(calls.rank_once(request))

    async def robots(self) -> Robots:
        """Return a report of each robot that the service received scans of, or that is mapped."""
        return await self._do(calls.robots())

    async def robot_scan(self, robot: str) -> RobotScan:
        """Return the newest scan of a robot, accepted or not, with its place; raises NotFoundError before the first."""
        return await self._do(calls.robot_scan(robot))

    async def request_look(self, robot: str) -> RobotReport:
        """Request a look of a robot whose mapping says `on_request`: its next scans make one."""
        return await self._do(calls.request_look(robot))

    async def claim_robot(self, robot: str, session_id: str | None) -> RobotReport:
        """Assign a mapped robot to a session, which receives its looks from now on; over HTTP only.

        With None, the robot belongs to no session until the next claim.

        Raises:
            NotFoundError: no such robot is mapped.
            InvalidRequestError: there is no such session.
            ConflictError: the mapping names a session, or another scenario than the session's.
            UsageError: the client does not speak HTTP.
        """
        return await self._do(calls.claim_robot(robot, ClaimRequest(session=session_id)))

    async def follow(self, session_id: str, for_s: float | None = None) -> AsyncGenerator[Session, None]:
        """Yield the current version of a session, then each newer version: in order, none twice.

        The iterator ends when the session is deleted, or after `for_s` seconds. Once a version was received, it waits
        for a service or router that goes away, however long that takes. A caller that reads slowly, or was cut off, may
        miss versions, but never the newest. Every version is confirmed by the service: messages that other programs
        publish on the session's key are neither returned nor end the iterator.

        Raises:
            NotFoundError: there is no such session at the beginning.
            UnreachableError: no version was received within `timeout_s` or `for_s`.
        """
        following = Following(session_id, self._patience, for_s)
        while not following.is_over:
            box = AsyncMailbox(following.seen)
            steps = following.steps(self._transport.poll_s)
            async with self._transport.watch(session_id, following.seen, box.put):
                result: Result = None
                while isinstance(step := next_step(steps, result), Step):
                    if isinstance(step, Session):
                        yield step
                    result = await self._result(step, box)
            if step is not None:
                await self._sleep(following.lost(step))
        following.end()

    async def _result(self, step: Step, box: AsyncMailbox) -> Result:
        """Take a step of a follower, and return its result."""
        match step:
            case Wait():
                return await box.take(step.seconds, step.seen)
            case Pause():
                await self._sleep(step.seconds)
            case Send():
                try:
                    return await self._transport.send(step.call, None, step.seconds)
                except VoaClientError as error:
                    return error
        return None

    async def _do(self, call: Call[M], key: str | None = None) -> M:
        key = self._patience.key(call, key)
        attempts = Attempts(self._patience, heavy=call.heavy)
        while True:
            try:
                return read(call, await self._transport.send(call, key, attempts.seconds))
            except VoaClientError as error:
                await self._sleep(attempts.pause(error))

    async def _items(self, page_after: Callable[[str | None], Call[Any]]) -> AsyncIterator[Any]:
        """Yield the items of every page of a list."""
        after: str | None = None
        while True:
            page = await self._do(page_after(after))
            for item in page.items:
                yield item
            after = page.next
            if after is None:
                return
