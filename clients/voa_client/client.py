"""The synchronous client over HTTP: one method per call of the service."""

from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

import httpx2
from pydantic import BaseModel

from voa_client.errors import ProblemError, UnreachableError
from voa_msgs.lidars import LidarPresets
from voa_msgs.objects import Object, StablePoses
from voa_msgs.problems import Health, Problem
from voa_msgs.rankings import RankedGrasps, Ranking, RankingRequest, VoaRequest
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioRequest
from voa_msgs.sessions import (
    BeliefRequest,
    HistoryEntry,
    HistoryPage,
    OutcomeRequest,
    ScanRequest,
    Session,
    SessionPage,
    SessionRequest,
    SessionSummary,
    UpdatedEstimate,
    UpdatedSession,
    UpdateRequest,
)

M = TypeVar("M", bound=BaseModel)

_SECONDS = 120.0


class Client:
    """Talks to one service; use as a context manager.

    Every method raises `UnreachableError` if there is no answer within `timeout_s`, and `ProblemError` if the
    service refuses.
    """

    def __init__(self, url: str, timeout_s: float = _SECONDS) -> None:
        self._http = httpx2.Client(base_url=url, timeout=timeout_s)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._http.close()

    def ready(self) -> Health:
        """Whether the service can work."""
        return self._call("GET", "/readyz", Health)

    def create_object(self, mesh: Path, name: str | None = None, scale: float = 1.0) -> Object:
        """Upload a mesh file; `scale` is metres per unit of the file."""
        form = {"scale": str(scale)} | ({} if name is None else {"name": name})
        return self._call("POST", "/v1/objects", Object, files={"file": (mesh.name, mesh.read_bytes())}, data=form)

    def stable_poses(self, object_id: str) -> StablePoses:
        """How an object can rest."""
        return self._call("GET", f"/v1/objects/{object_id}/stable-poses", StablePoses)

    def lidars(self) -> LidarPresets:
        """The lidars that scenarios can name."""
        return self._call("GET", "/v1/lidars", LidarPresets)

    def create_scenario(self, request: ScenarioRequest) -> Scenario:
        """Store a scenario."""
        return self._send("/v1/scenarios", request, Scenario)

    def get_scenario(self, scenario_id: str) -> Scenario:
        """A stored scenario."""
        return self._call("GET", f"/v1/scenarios/{scenario_id}", Scenario)

    def predict(self, scenario_id: str, request: PredictionsRequest | None = None) -> Predictions:
        """Predicted scans of every pose."""
        return self._send(f"/v1/scenarios/{scenario_id}/predictions", request or PredictionsRequest(), Predictions)

    def create_session(self, request: SessionRequest) -> Session:
        """Open a session."""
        return self._send("/v1/sessions", request, Session)

    def get_session(self, session_id: str) -> Session:
        """A session as it stands."""
        return self._call("GET", f"/v1/sessions/{session_id}", Session)

    def list_sessions(self) -> Iterator[SessionSummary]:
        """Every session, oldest first, a page at a time."""
        after: dict[str, str] = {}
        while True:
            page = self._call("GET", "/v1/sessions", SessionPage, params=after)
            yield from page.items
            if page.next is None:
                return
            after = {"after": page.next}

    def delete_session(self, session_id: str) -> None:
        """Remove a session and its history."""
        self._request("DELETE", f"/v1/sessions/{session_id}")

    def history(self, session_id: str) -> Iterator[HistoryEntry]:
        """Every version of a session and what made it, the prior first."""
        after: dict[str, str] = {}
        while True:
            page = self._call("GET", f"/v1/sessions/{session_id}/history", HistoryPage, params=after)
            yield from page.items
            if page.next is None:
                return
            after = {"after": page.next}

    def put_belief(self, session_id: str, request: BeliefRequest) -> Session:
        """Replace a session's belief; null: back to its prior."""
        return self._send(f"/v1/sessions/{session_id}/belief", request, Session, method="PUT")

    def report_outcome(self, session_id: str, request: OutcomeRequest) -> UpdatedSession:
        """Update a session's belief by what came of a grasp attempt."""
        return self._send(f"/v1/sessions/{session_id}/grasp-outcomes", request, UpdatedSession)

    def apply_scan(self, session_id: str, request: ScanRequest) -> UpdatedSession:
        """Update a session's belief by a raw scan."""
        return self._send(f"/v1/sessions/{session_id}/scans", request, UpdatedSession)

    def rank_looks(self, session_id: str, request: VoaRequest | None = None) -> Ranking:
        """Looks by their Value of Assistance."""
        return self._send(f"/v1/sessions/{session_id}/voa", request or VoaRequest(), Ranking)

    def rank_grasps(self, session_id: str, reachable: list[str] | None = None) -> RankedGrasps:
        """Grasps by their expected score."""
        asked = {} if reachable is None else {"grasps": reachable}
        return self._call("GET", f"/v1/sessions/{session_id}/grasps", RankedGrasps, params=asked)

    def update_once(self, request: UpdateRequest) -> UpdatedEstimate:
        """Update a belief of one's own; nothing is stored."""
        return self._send("/v1/updates", request, UpdatedEstimate)

    def rank_once(self, request: RankingRequest) -> Ranking:
        """Rank looks for a belief of one's own; nothing is stored."""
        return self._send("/v1/rankings", request, Ranking)

    def _send(self, path: str, request: BaseModel, answer: type[M], method: str = "POST") -> M:
        body = request.model_dump_json(exclude_unset=True)
        return self._call(method, path, answer, content=body, headers={"Content-Type": "application/json"})

    def _call(self, method: str, path: str, answer: type[M], **more: Any) -> M:
        # An old robot may talk to a new service: what it does not know in an answer, it ignores.
        return answer.model_validate_json(self._request(method, path, **more), extra="ignore")

    def _request(self, method: str, path: str, **more: Any) -> bytes:
        try:
            response = self._http.request(method, path, **more)
        except httpx2.TransportError as error:
            raise UnreachableError(f"no answer from {self._http.base_url}: {error or type(error).__name__}") from error
        if response.is_error:
            raise ProblemError(_problem(response))
        return response.content


def _problem(response: httpx2.Response) -> Problem:
    """The problem document of an answer; one made up where something in between answered."""
    if response.headers.get("content-type", "").startswith("application/problem+json"):
        return Problem.model_validate_json(response.content, extra="ignore")
    return Problem(
        type="urn:voa:problem:http-error",
        title=f"HTTP {response.status_code} from {response.url}",
        status=response.status_code,
        detail=response.text[:200],
    )
