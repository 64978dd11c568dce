"""The synchronous client: one method per call of the service, over any transport."""

import random
import time
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from voa_client import _calls as calls
from voa_client._addresses import transport_to
from voa_client._answers import Reply, read
from voa_client._attempts import ATTEMPT_S, RETRIES, TIMEOUT_S, Attempts, Patience, Retries, new_key
from voa_client._calls import Call, M
from voa_client._errors import VoaClientError
from voa_client._following import Ask, Following, Pause, Result, Step, Wait, taken
from voa_client._mailbox import Mailbox
from voa_client._transport import Transport
from voa_msgs.lidars import LidarPresets
from voa_msgs.objects import Object, StablePoses, UpAxis
from voa_msgs.problems import Health
from voa_msgs.rankings import RankedGrasps, Ranking, RankingRequest, VoaRequest
from voa_msgs.robots import ClaimRequest, RobotReport, Robots
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioRequest, ScenarioSummary
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
from voa_msgs.warnings import Warnings


class Client:
    """Talks to one service; use as a context manager.

    A call that finds nobody, or a service that has too much to do, is tried again until `timeout_s` is over. All
    attempts of one write share an idempotency key, so that it takes effect once, however often it was sent; give a
    `key` of your own to send it again later, from another process too.

    Every method raises `UnreachableError` if there is no answer in time, and `ProblemError` if the service refuses;
    the others are in `voa_client._errors`.

    Args:
        to: an address (`http://`, `https://`, `zenoh://`, `zenoh+tls://`, or an endpoint like `tcp/127.0.0.1:7447`;
            `voa_client._addresses` has examples), or a transport.
        timeout_s: bounds a whole call.
        attempt_s: bounds one attempt; rankings, predictions, uploads and scenarios may use all of `timeout_s`.
        retries: what lies between attempts.
        clock: seconds, never going back.
        sleep: waits so many seconds.
        chance: uniform in [0, 1).
        keys: a new idempotency key.
    """

    def __init__(
        self,
        to: str | Transport,
        timeout_s: float = TIMEOUT_S,
        attempt_s: float = ATTEMPT_S,
        retries: Retries = RETRIES,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
        chance: Callable[[], float] = random.random,
        keys: Callable[[], str] = new_key,
    ) -> None:
        self._patience = Patience(timeout_s, attempt_s, retries, clock, chance, keys)
        self._sleep = sleep
        self._transport = transport_to(to) if isinstance(to, str) else to

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Release the transport; leaving a `with` does it."""
        self._transport.close()

    def health(self) -> Health:
        """How the service is, asked once."""
        call = calls.health()
        return read(call, self._transport.send(call, None, self._patience.attempt_s))

    def ready(self) -> Health:
        """Wait until the service can work."""
        return self._do(calls.health())

    def create_object(
        self, mesh: Path, name: str | None = None, scale: float = 1.0, up: UpAxis | None = None
    ) -> Object:
        """Upload a mesh file; `scale` is metres per unit of the file, `up` its axis that points up.

        Without `up`, +Y is up in a GLB file, as its standard says, and +Z in any other. +Y is turned to z.
        """
        return self._do(calls.create_object(mesh.name, mesh.read_bytes(), name, scale, up))

    def find_object(self, mesh: Path, scale: float = 1.0, up: UpAxis | None = None) -> Object | None:
        """Find what `create_object` would return for a mesh file that was uploaded before, without uploading it again.

        None: this file was never uploaded so, or the service is an older one, which does not know.
        """
        call = calls.find_object(mesh.name, mesh.read_bytes(), scale, up)
        return calls.found_object(call, self._do(call))

    def get_object(self, object_id: str) -> Object:
        """A stored mesh."""
        return self._do(calls.get_object(object_id))

    def list_objects(self) -> Iterator[Object]:
        """Every mesh, oldest first, a page at a time."""
        return self._items(calls.list_objects)

    def stable_poses(self, object_id: str) -> StablePoses:
        """How an object can rest."""
        return self._do(calls.stable_poses(object_id))

    def lidars(self) -> LidarPresets:
        """The lidars that scenarios can name."""
        return self._do(calls.lidars())

    def create_scenario(self, request: ScenarioRequest) -> Scenario:
        """Store a scenario."""
        return self._do(calls.create_scenario(request))

    def get_scenario(self, scenario_id: str) -> Scenario:
        """A stored scenario."""
        return self._do(calls.get_scenario(scenario_id))

    def list_scenarios(self) -> Iterator[ScenarioSummary]:
        """Every scenario, oldest first, a page at a time."""
        return self._items(calls.list_scenarios)

    def warnings(self, scenario_id: str) -> Warnings:
        """Ask for everything that is probably wrong with a scenario."""
        return self._do(calls.warnings(scenario_id))

    def predict(self, scenario_id: str, request: PredictionsRequest | None = None) -> Predictions:
        """Predicted scans of every pose."""
        return self._do(calls.predict(scenario_id, request or PredictionsRequest()))

    def create_session(self, request: SessionRequest, *, key: str | None = None) -> Session:
        """Open a session; the scans of the mapped robots in `request.robots` go to it from now on.

        Raises:
            InvalidRequestError: there is no such scenario or mapped robot, or the prior is none.
            ConflictError: the mapping of a robot names a session, or another scenario.
        """
        return self._do(calls.create_session(request), key)

    def get_session(self, session_id: str) -> Session:
        """A session as it stands."""
        return self._do(calls.get_session(session_id))

    def list_sessions(self) -> Iterator[SessionSummary]:
        """Every session, oldest first, a page at a time."""
        return self._items(calls.list_sessions)

    def delete_session(self, session_id: str, *, key: str | None = None, if_match: int | None = None) -> None:
        """Remove a session and its history; with `if_match` only if it is at that version (over HTTP)."""
        self._do(calls.delete_session(session_id, if_match), key)

    def history(self, session_id: str) -> Iterator[HistoryEntry]:
        """Every version of a session and what made it, the prior first."""
        return self._items(lambda after: calls.history(session_id, after))

    def put_belief(
        self, session_id: str, request: BeliefRequest, *, key: str | None = None, if_match: int | None = None
    ) -> Session:
        """Replace a session's belief; null: back to its prior. With `if_match` as in `apply_scan`."""
        return self._do(calls.put_belief(session_id, request, if_match), key)

    def report_outcome(
        self, session_id: str, request: OutcomeRequest, *, key: str | None = None, if_match: int | None = None
    ) -> UpdatedSession:
        """Update a session's belief by what came of a grasp attempt. With `if_match` as in `apply_scan`."""
        return self._do(calls.report_outcome(session_id, request, if_match), key)

    def apply_scan(
        self, session_id: str, request: ScanRequest, *, key: str | None = None, if_match: int | None = None
    ) -> UpdatedSession:
        """Update a session's belief by a raw scan.

        Args:
            session_id: which.
            request: the scan, and where it was taken.
            key: idempotency key; None: a new one.
            if_match: only if the session is at this version, else `StaleVersionError`; over HTTP.
        """
        return self._do(calls.apply_scan(session_id, request, if_match), key)

    def rank_looks(self, session_id: str, request: VoaRequest | None = None) -> Ranking:
        """Looks by their Value of Assistance."""
        return self._do(calls.rank_looks(session_id, request or VoaRequest()))

    def rank_grasps(self, session_id: str, reachable: list[str] | None = None) -> RankedGrasps:
        """Grasps by their expected score."""
        return self._do(calls.rank_grasps(session_id, reachable))

    def update_once(self, request: UpdateRequest) -> UpdatedEstimate:
        """Update a belief of one's own; nothing is stored."""
        return self._do(calls.update_once(request))

    def rank_once(self, request: RankingRequest) -> Ranking:
        """Rank looks for a belief of one's own; nothing is stored."""
        return self._do(calls.rank_once(request))

    def robots(self) -> Robots:
        """The robots that the service has heard, or listens to."""
        return self._do(calls.robots())

    def request_look(self, robot: str) -> RobotReport:
        """The next scans of a robot that looks on request are a look."""
        return self._do(calls.request_look(robot))

    def claim_robot(self, robot: str, session_id: str | None) -> RobotReport:
        """Say whose session a mapped robot's scans are for from now on, over HTTP; None: nobody's until the next claim.

        Raises:
            NotFoundError: no such robot is mapped.
            InvalidRequestError: there is no such session.
            ConflictError: the mapping names a session, or another scenario than the session's.
            UsageError: the client does not speak HTTP.
        """
        return self._do(calls.claim_robot(robot, ClaimRequest(session=session_id)))

    def follow(self, session_id: str, for_s: float | None = None) -> Generator[Session, None, None]:
        """A session as it stands, then every newer version: in order, none twice.

        Ends when the session is deleted, or after `for_s` seconds. A service or router that goes away is waited for,
        however long it takes, once anything was received. Whoever reads slowly, or was cut off, may miss versions, but
        never the newest. The service alone is believed: what others put on a bus ends nothing and is never returned.

        Raises:
            NotFoundError: there is no such session to begin with.
            UnreachableError: nothing was ever received, within `timeout_s` or `for_s`.
        """
        following = Following(session_id, self._patience, for_s)
        while not following.is_over:
            box = Mailbox(following.seen)
            steps = following.steps(self._transport.ask_s)
            with self._transport.watch(session_id, following.seen, box.put):
                result: Result = None
                while isinstance(step := taken(steps, result), Step):
                    if isinstance(step, Session):
                        yield step
                    result = self._result(step, box)
            if step is not None:
                self._sleep(following.lost(step))
        following.end()

    def _result(self, step: Step, box: Mailbox) -> Result:
        """Result of a step of a follower."""
        match step:
            case Wait():
                return box.take(step.seconds, step.seen)
            case Pause():
                self._sleep(step.seconds)
            case Ask():
                return self._attempt(step)
        return None

    def _attempt(self, step: Ask) -> Reply | VoaClientError:
        try:
            return self._transport.send(step.call, None, step.seconds)
        except VoaClientError as error:
            return error

    def _do(self, call: Call[M], key: str | None = None) -> M:
        key = self._patience.key(call, key)
        attempts = Attempts(self._patience, heavy=call.heavy)
        while True:
            try:
                return read(call, self._transport.send(call, key, attempts.seconds))
            except VoaClientError as error:
                self._sleep(attempts.pause(error))

    def _items(self, page_after: Callable[[str | None], Call[Any]]) -> Iterator[Any]:
        """The items of every page."""
        after: str | None = None
        while True:
            page = self._do(page_after(after))
            yield from page.items
            after = page.next
            if after is None:
                return
