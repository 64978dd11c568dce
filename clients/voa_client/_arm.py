"""Clients for the program on the arm: wait until grasping pays, choose the grasp, report its outcome."""

from collections.abc import AsyncGenerator, Generator, Sequence
from contextlib import aclosing, closing
from dataclasses import dataclass
from typing import Literal

from pydantic import ValidationError

from voa_client._async_client import AsyncClient
from voa_client._client import Client
from voa_client._errors import NotFoundError, UsageError
from voa_msgs.grasp_geometry import GraspGeometry, grasp_geometry
from voa_msgs.rankings import Look, RankedGrasp, RankedGrasps, VoaRequest
from voa_msgs.scenarios import Grasp
from voa_msgs.sessions import OutcomeRequest, Session, UpdatedSession

SCORE = 0.9
WAIT_S = 300.0
MOST_ABSENT = 0.5


@dataclass(frozen=True)
class Waited:
    """End of a wait: the newest version of the session, and the reason why the wait ended.

    Attributes:
        session: its newest version that was received.
        reason: `score`: the best grasp is good enough; `no_look_pays`: no further look is worth its cost;
            `probably_absent`: no further look is worth its cost, and the object probably lies at none of the poses, so
            that a grasp would probably close on nothing; `timeout`: the time is over; `deleted`: the session was
            deleted.
    """

    session: Session
    reason: Literal["score", "no_look_pays", "probably_absent", "timeout", "deleted"]


class ArmClient:
    """Client of the arm in one session.

    Args:
        client: of the service; the caller closes it.
        session_id: of the session.
    """

    def __init__(self, client: Client, session_id: str) -> None:
        self._client = client
        self._session = session_id
        self._grasps: dict[str, Grasp] | None = None

    def best_grasp(self, reachable: Sequence[str] | None = None) -> RankedGrasp | None:
        """Return the reachable grasp that is most likely to succeed; None if none can succeed.

        Args:
            reachable: names of grasps; None: all.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        return _best(self._client.rank_grasps(self._session, _named(reachable)))

    def geometry(self, grasp: str) -> GraspGeometry | None:
        """Return where the hand has to be for a grasp, as the scenario states it; None if it states none.

        It is read from the grasp's `data` (`voa_msgs.grasp_geometry`); the scenario is fetched once.

        Args:
            grasp: name of the grasp.

        Raises:
            UsageError: the scenario has no such grasp, or its `data` is not a valid geometry.
            VoaClientError: the service cannot be reached, or refuses.
        """
        if self._grasps is None:
            scenario = self._client.get_session(self._session).scenario
            self._grasps = {known.name: known for known in self._client.get_scenario(scenario).grasps}
        return _geometry(self._grasps, grasp)

    def wait_until(
        self,
        score: float = SCORE,
        reachable: Sequence[str] | None = None,
        timeout_s: float = WAIT_S,
        *,
        most_absent: float = MOST_ABSENT,
    ) -> Waited:
        """Wait until a reachable grasp has an expected score of at least `score`, or no further look is worth its cost.

        Looks that other robots have announced are waited for, if they are worth their cost. Expected scores hold where
        the object lies at one of the poses: while the session's `absent` is above `most_absent`, none is good enough.

        Args:
            score: probability of success that is good enough.
            reachable: names of grasps; None: all.
            timeout_s: longest wait, seconds; a ranking that has begun is completed after it.
            most_absent: largest probability that the object lies at none of the poses at which to grasp; 1: grasp in
                any case. It matters only where the scenario states `absent`.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        seen = self._client.get_session(self._session)
        try:
            with closing(self._client.follow(self._session, timeout_s)) as sessions:
                for session in sessions:
                    seen = session
                    best = self.best_grasp(reachable)
                    absent = (session.absent or 0.0) > most_absent
                    if best is not None and best.expected_score >= score and not absent:
                        return Waited(session, "score")
                    if not self._look_pays(session, reachable):
                        return Waited(session, "probably_absent" if absent else "no_look_pays")
            return Waited(self._client.get_session(self._session), "timeout")
        except NotFoundError as error:
            if not error.is_of_the_service:
                raise
            return Waited(seen, "deleted")

    def _look_pays(self, session: Session, reachable: Sequence[str] | None) -> bool:
        """True if a look is worth its cost, also one that is under way, or if a newer version than `session` exists."""
        request = VoaRequest(grasps=_named(reachable))
        ranking = self._client.rank_looks(self._session, request)
        if isinstance(ranking.recommendation, Look):
            return True
        # Looks under way count as taken in the ranking: without them it says if they are worth waiting for.
        newest = self._client.get_session(self._session)
        if newest.version == session.version and newest.under_way:
            alone = request.model_copy(update={"pending": []})
            ranking = self._client.rank_looks(self._session, alone)
        return newest.version != session.version or isinstance(ranking.recommendation, Look)

    def report(self, grasp: str, success: bool, *, object_moved: float = 0.0, key: str | None = None) -> UpdatedSession:
        """Report the outcome of a grasp attempt, and return the updated session.

        Args:
            grasp: name of the grasp that was tried.
            success: True if it succeeded.
            object_moved: probability that the attempt moved the object, 0 to 1; where it is above 0, the prior is mixed
                into the belief with this share, and earlier looks no longer count.
            key: idempotency key: a report that is repeated with it takes effect once; None: a new key.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        return self._client.report_outcome(
            self._session, OutcomeRequest(grasp=grasp, success=success, object_moved=object_moved), key=key
        )

    def follow(self, for_s: float | None = None) -> Generator[Session, None, None]:
        """Yield the current version of the session, then each newer one; see `Client.follow`.

        Args:
            for_s: seconds after which to end; None: when the session is deleted.
        """
        return self._client.follow(self._session, for_s)


class AsyncArmClient:
    """Client of the arm in one session, for asyncio.

    Args:
        client: of the service; the caller closes it.
        session_id: of the session.
    """

    def __init__(self, client: AsyncClient, session_id: str) -> None:
        self._client = client
        self._session = session_id
        self._grasps: dict[str, Grasp] | None = None

    async def best_grasp(self, reachable: Sequence[str] | None = None) -> RankedGrasp | None:
        """Return the reachable grasp that is most likely to succeed; None if none can succeed.

        Args:
            reachable: names of grasps; None: all.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        return _best(await self._client.rank_grasps(self._session, _named(reachable)))

    async def geometry(self, grasp: str) -> GraspGeometry | None:
        """Return where the hand has to be for a grasp, as the scenario states it; None if it states none.

        It is read from the grasp's `data` (`voa_msgs.grasp_geometry`); the scenario is fetched once.

        Args:
            grasp: name of the grasp.

        Raises:
            UsageError: the scenario has no such grasp, or its `data` is not a valid geometry.
            VoaClientError: the service cannot be reached, or refuses.
        """
        if self._grasps is None:
            scenario = (await self._client.get_session(self._session)).scenario
            self._grasps = {known.name: known for known in (await self._client.get_scenario(scenario)).grasps}
        return _geometry(self._grasps, grasp)

    async def wait_until(
        self,
        score: float = SCORE,
        reachable: Sequence[str] | None = None,
        timeout_s: float = WAIT_S,
        *,
        most_absent: float = MOST_ABSENT,
    ) -> Waited:
        """Wait until a reachable grasp has an expected score of at least `score`, or no further look is worth its cost.

        Looks that other robots have announced are waited for, if they are worth their cost. Expected scores hold where
        the object lies at one of the poses: while the session's `absent` is above `most_absent`, none is good enough.

        Args:
            score: probability of success that is good enough.
            reachable: names of grasps; None: all.
            timeout_s: longest wait, seconds; a ranking that has begun is completed after it.
            most_absent: largest probability that the object lies at none of the poses at which to grasp; 1: grasp in
                any case. It matters only where the scenario states `absent`.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        seen = await self._client.get_session(self._session)
        try:
            async with aclosing(self._client.follow(self._session, timeout_s)) as sessions:
                async for session in sessions:
                    seen = session
                    best = await self.best_grasp(reachable)
                    absent = (session.absent or 0.0) > most_absent
                    if best is not None and best.expected_score >= score and not absent:
                        return Waited(session, "score")
                    if not await self._look_pays(session, reachable):
                        return Waited(session, "probably_absent" if absent else "no_look_pays")
            return Waited(await self._client.get_session(self._session), "timeout")
        except NotFoundError as error:
            if not error.is_of_the_service:
                raise
            return Waited(seen, "deleted")

    async def _look_pays(self, session: Session, reachable: Sequence[str] | None) -> bool:
        """True if a look is worth its cost, also one that is under way, or if a newer version than `session` exists."""
        request = VoaRequest(grasps=_named(reachable))
        ranking = await self._client.rank_looks(self._session, request)
        if isinstance(ranking.recommendation, Look):
            return True
        # Looks under way count as taken in the ranking: without them it says if they are worth waiting for.
        newest = await self._client.get_session(self._session)
        if newest.version == session.version and newest.under_way:
            alone = request.model_copy(update={"pending": []})
            ranking = await self._client.rank_looks(self._session, alone)
        return newest.version != session.version or isinstance(ranking.recommendation, Look)

    async def report(
        self, grasp: str, success: bool, *, object_moved: float = 0.0, key: str | None = None
    ) -> UpdatedSession:
        """Report the outcome of a grasp attempt, and return the updated session.

        Args:
            grasp: name of the grasp that was tried.
            success: True if it succeeded.
            object_moved: probability that the attempt moved the object, 0 to 1; where it is above 0, the prior is mixed
                into the belief with this share, and earlier looks no longer count.
            key: idempotency key: a report that is repeated with it takes effect once; None: a new key.

        Raises:
            VoaClientError: the service cannot be reached, or refuses.
        """
        return await self._client.report_outcome(
            self._session, OutcomeRequest(grasp=grasp, success=success, object_moved=object_moved), key=key
        )

    def follow(self, for_s: float | None = None) -> AsyncGenerator[Session, None]:
        """Yield the current version of the session, then each newer one; see `Client.follow`.

        Args:
            for_s: seconds after which to end; None: when the session is deleted.
        """
        return self._client.follow(self._session, for_s)


def _named(reachable: Sequence[str] | None) -> list[str] | None:
    return None if reachable is None else list(reachable)


def _geometry(grasps: dict[str, Grasp], name: str) -> GraspGeometry | None:
    if name not in grasps:
        raise UsageError(f"the scenario has no grasp {name!r}; there are: {', '.join(grasps)}")
    try:
        return grasp_geometry(grasps[name].data)
    except ValidationError as error:
        mistake = error.errors()[0]
        where = ".".join(["data", *map(str, mistake["loc"])])
        raise UsageError(f"grasp {name!r} of the scenario has no valid geometry: {where}: {mistake['msg']}") from error


def _best(ranked: RankedGrasps) -> RankedGrasp | None:
    best = ranked.grasps[0] if ranked.grasps else None
    return best if best is not None and best.expected_score > 0.0 else None
