"""The role of the arm: wait until it is worth grasping, grasp, tell what came of it."""

from collections.abc import AsyncGenerator, Generator, Sequence
from contextlib import aclosing, closing
from dataclasses import dataclass
from typing import Literal

from voa_client._async_client import AsyncClient
from voa_client._client import Client
from voa_client._errors import NotFoundError
from voa_msgs.rankings import GraspNow, RankedGrasp, RankedGrasps, VoaRequest
from voa_msgs.sessions import OutcomeRequest, Session, UpdatedSession

SCORE = 0.9
WAIT_S = 300.0


@dataclass(frozen=True)
class Waited:
    """Why a wait is over, and the session as it was then.

    Attributes:
        session: the newest that was seen.
        reason: the best grasp is good enough (`score`); no look is worth its cost any more (`no_look_pays`); the
            time is over (`timeout`); the session has ended (`deleted`).
    """

    session: Session
    reason: Literal["score", "no_look_pays", "timeout", "deleted"]


class ArmClient:
    """The arm's side of one session.

    Args:
        client: of the service; it stays the caller's.
        session_id: which session.
    """

    def __init__(self, client: Client, session_id: str) -> None:
        self._client = client
        self._session = session_id

    def best_grasp(self, reachable: Sequence[str] | None = None) -> RankedGrasp | None:
        """The grasp to try now, of those that are reachable (None: all); None if every one scores 0."""
        return _best(self._client.rank_grasps(self._session, _named(reachable)))

    def wait_until(
        self, score: float = SCORE, reachable: Sequence[str] | None = None, timeout_s: float = WAIT_S
    ) -> Waited:
        """Wait until a reachable grasp is expected to succeed with `score`, or no further look would pay.

        Each version of the session is judged as it comes; `timeout_s` bounds the wait, not the last judgement.
        """
        seen = self._client.get_session(self._session)
        try:
            with closing(self._client.follow(self._session, timeout_s)) as sessions:
                for session in sessions:
                    seen = session
                    best = self.best_grasp(reachable)
                    if best is not None and best.expected_score >= score:
                        return Waited(session, "score")
                    ranking = self._client.rank_looks(self._session, VoaRequest(grasps=_named(reachable)))
                    if isinstance(ranking.recommendation, GraspNow):
                        return Waited(session, "no_look_pays")
            return Waited(self._client.get_session(self._session), "timeout")
        except NotFoundError as error:
            if not error.is_of_the_service:
                raise
            return Waited(seen, "deleted")

    def report(self, grasp: str, success: bool, *, key: str | None = None) -> UpdatedSession:
        """Tell what came of an attempt that left the object where it was; with a `key` it can be told again."""
        return self._client.report_outcome(self._session, OutcomeRequest(grasp=grasp, success=success), key=key)

    def follow(self, for_s: float | None = None) -> Generator[Session, None, None]:
        """The session as it stands, then every newer version; as `Client.follow`."""
        return self._client.follow(self._session, for_s)


class AsyncArmClient:
    """The same for asyncio."""

    def __init__(self, client: AsyncClient, session_id: str) -> None:
        self._client = client
        self._session = session_id

    async def best_grasp(self, reachable: Sequence[str] | None = None) -> RankedGrasp | None:
        """As in `ArmClient`."""
        return _best(await self._client.rank_grasps(self._session, _named(reachable)))

    async def wait_until(
        self, score: float = SCORE, reachable: Sequence[str] | None = None, timeout_s: float = WAIT_S
    ) -> Waited:
        """As in `ArmClient`."""
        seen = await self._client.get_session(self._session)
        try:
            async with aclosing(self._client.follow(self._session, timeout_s)) as sessions:
                async for session in sessions:
                    seen = session
                    best = await self.best_grasp(reachable)
                    if best is not None and best.expected_score >= score:
                        return Waited(session, "score")
                    ranking = await self._client.rank_looks(self._session, VoaRequest(grasps=_named(reachable)))
                    if isinstance(ranking.recommendation, GraspNow):
                        return Waited(session, "no_look_pays")
            return Waited(await self._client.get_session(self._session), "timeout")
        except NotFoundError as error:
            if not error.is_of_the_service:
                raise
            return Waited(seen, "deleted")

    async def report(self, grasp: str, success: bool, *, key: str | None = None) -> UpdatedSession:
        """As in `ArmClient`."""
        request = OutcomeRequest(grasp=grasp, success=success)
        return await self._client.report_outcome(self._session, request, key=key)

    def follow(self, for_s: float | None = None) -> AsyncGenerator[Session, None]:
        """As in `ArmClient`."""
        return self._client.follow(self._session, for_s)


def _named(reachable: Sequence[str] | None) -> list[str] | None:
    return None if reachable is None else list(reachable)


def _best(ranked: RankedGrasps) -> RankedGrasp | None:
    best = ranked.grasps[0] if ranked.grasps else None
    return best if best is not None and best.expected_score > 0.0 else None
