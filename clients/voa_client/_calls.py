"""What can be asked of the service, one function per call, without any I/O.

A `Call` says the same thing twice: as a method, a path and a query for HTTP, and as the name of an rpc for the other
transports, whose payload has the ids and the query beside the body's fields.
"""

import base64
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any, Generic, TypeVar
from urllib.parse import quote

from pydantic import BaseModel
from pydantic_core import to_json

from voa_client._errors import UsageError
from voa_msgs.base import Message
from voa_msgs.lidars import LidarPresets
from voa_msgs.objects import Object, ObjectPage, StablePoses, UpAxis
from voa_msgs.problems import Health
from voa_msgs.rankings import RankedGrasps, Ranking, RankingRequest, VoaRequest
from voa_msgs.robots import ClaimRequest, RobotReport, Robots
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioPage, ScenarioRequest
from voa_msgs.sessions import (
    BeliefRequest,
    HistoryPage,
    OutcomeRequest,
    ScanRequest,
    Session,
    SessionPage,
    SessionRequest,
    UpdatedEstimate,
    UpdatedSession,
    UpdateRequest,
)
from voa_msgs.warnings import Warnings

M = TypeVar("M", bound=BaseModel)


class Nothing(Message):
    """The answer to a call that has none."""


@dataclass(frozen=True)
class Upload:
    """A mesh file: a multipart form over HTTP, base64 elsewhere."""

    filename: str
    content: bytes
    name: str | None
    scale: float
    up: UpAxis | None = None

    def form(self) -> dict[str, str]:
        """The fields of the form beside the file."""
        return {"scale": repr(self.scale)} | self._stated()

    def fields(self) -> dict[str, Any]:
        """The same as JSON, file included."""
        file = base64.b64encode(self.content).decode("ascii")
        return {"filename": self.filename, "file": file, "scale": float(self.scale)} | self._stated()

    def _stated(self) -> dict[str, str]:
        """Pick the form fields that the caller has stated; the others keep their defaults."""
        given = {"name": self.name, "up": self.up}
        return {name: value for name, value in given.items() if value is not None}


@dataclass(frozen=True)
class Call(Generic[M]):
    """One call, before it is sent.

    Attributes:
        rpc: its name on Zenoh.
        method: of HTTP.
        path: of HTTP, with the names of `ids` in braces.
        answer: what comes back.
        ids: what the path names.
        query: what HTTP has in the query string; None is left out.
        body: the message.
        upload: the file, instead of a body.
        writes: whether it takes an idempotency key.
        heavy: whether its answer may take long: one long attempt instead of several short ones.
        if_match: the version that the session must be at.
        http_only: whether the service answers it over HTTP alone.
    """

    rpc: str
    method: str
    path: str
    answer: type[M]
    ids: Mapping[str, str] = field(default_factory=dict)
    query: Mapping[str, str | int | float | list[str] | None] = field(default_factory=dict)
    body: BaseModel | None = None
    upload: Upload | None = None
    writes: bool = False
    heavy: bool = False
    if_match: int | None = None
    http_only: bool = False

    def __post_init__(self) -> None:
        for what, id_ in self.ids.items():
            if not id_:
                raise UsageError(f"{self.rpc}: expected the {what}, got an empty text")

    def check_has_rpc(self) -> None:
        """Raise UsageError unless the call means the same by name as over HTTP."""
        if self.http_only:
            raise UsageError(f"{self.rpc}: goes over HTTP only; make the client with the service's http:// address")
        if self.if_match is not None:
            raise UsageError(f"{self.rpc}: if_match goes over HTTP only; the other transports have no such condition")

    @property
    def url(self) -> str:
        """The path of HTTP, with the ids in it."""
        return self.path.format(**{name: _quoted(id_) for name, id_ in self.ids.items()})

    @property
    def asked(self) -> dict[str, str | int | float | list[str]]:
        """The query, without what is None."""
        return {name: value for name, value in self.query.items() if value is not None}

    def content(self) -> bytes | None:
        """The body of HTTP as JSON; only what the caller has set."""
        return None if self.body is None else self.body.model_dump_json(exclude_unset=True).encode()

    def payload(self) -> bytes:
        """The payload of an rpc."""
        fields: dict[str, Any] = {} if self.body is None else self.body.model_dump(exclude_unset=True)
        if self.upload is not None:
            fields = self.upload.fields()
        return to_json(fields | dict(self.ids) | self.asked)


def _quoted(id_: str) -> str:
    """An id as one segment of a path, also one that is nothing but dots."""
    quoted = quote(id_, safe="")
    return quoted.replace(".", "%2E") if not quoted.strip(".") else quoted


def health() -> Call[Health]:
    """How the service is."""
    return Call("service.health", "GET", "/readyz", Health)


def create_object(
    filename: str, content: bytes, name: str | None, scale: float, up: UpAxis | None = None
) -> Call[Object]:
    """Store a mesh."""
    upload = Upload(filename, content, name, scale, up)
    return Call("object.create", "POST", "/v1/objects", Object, upload=upload, heavy=True)


def get_object(object_id: str) -> Call[Object]:
    """One mesh."""
    return Call("object.get", "GET", "/v1/objects/{id}", Object, {"id": object_id})


def list_objects(after: str | None) -> Call[ObjectPage]:
    """A page of meshes."""
    return Call("object.list", "GET", "/v1/objects", ObjectPage, query={"after": after})


def find_object(filename: str, content: bytes, scale: float, up: UpAxis | None = None) -> Call[ObjectPage]:
    """Ask for the mesh that a file became when it was uploaded, by the digest of its bytes; see `found_object`."""
    file = {"sha256": hashlib.sha256(content).hexdigest(), "type": PurePath(filename).suffix.lower().removeprefix(".")}
    return Call("object.list", "GET", "/v1/objects", ObjectPage, query=file | {"scale": float(scale), "up": up})


def found_object(call: Call[ObjectPage], answer: ObjectPage) -> Object | None:
    """Pick the mesh that `find_object` asked for; a service that does not know the question lists any meshes."""
    return next((item for item in answer.items if item.sha256 == call.query["sha256"]), None)


def stable_poses(object_id: str) -> Call[StablePoses]:
    """How a mesh can rest."""
    path = "/v1/objects/{id}/stable-poses"
    return Call("object.stable_poses", "GET", path, StablePoses, {"id": object_id}, heavy=True)


def lidars() -> Call[LidarPresets]:
    """The presets."""
    return Call("lidar.list", "GET", "/v1/lidars", LidarPresets)


def create_scenario(request: ScenarioRequest) -> Call[Scenario]:
    """Store a scenario; the same content again is the same scenario."""
    return Call("scenario.create", "POST", "/v1/scenarios", Scenario, body=request, heavy=True)


def get_scenario(scenario_id: str) -> Call[Scenario]:
    """One scenario."""
    return Call("scenario.get", "GET", "/v1/scenarios/{id}", Scenario, {"id": scenario_id})


def list_scenarios(after: str | None) -> Call[ScenarioPage]:
    """A page of scenarios."""
    return Call("scenario.list", "GET", "/v1/scenarios", ScenarioPage, query={"after": after})


def warnings(scenario_id: str) -> Call[Warnings]:
    """Ask for everything that is probably wrong with a scenario."""
    return Call("scenario.warnings", "GET", "/v1/scenarios/{id}/warnings", Warnings, {"id": scenario_id}, heavy=True)


def predict(scenario_id: str, request: PredictionsRequest) -> Call[Predictions]:
    """Predicted scans."""
    path = "/v1/scenarios/{id}/predictions"
    return Call("scenario.predict", "POST", path, Predictions, {"id": scenario_id}, body=request, heavy=True)


def create_session(request: SessionRequest) -> Call[Session]:
    """Open a session."""
    return Call("session.create", "POST", "/v1/sessions", Session, body=request, writes=True)


def get_session(session_id: str) -> Call[Session]:
    """A session as it stands."""
    return Call("session.get", "GET", "/v1/sessions/{session}", Session, {"session": session_id})


def list_sessions(after: str | None) -> Call[SessionPage]:
    """A page of sessions."""
    return Call("session.list", "GET", "/v1/sessions", SessionPage, query={"after": after})


def delete_session(session_id: str, if_match: int | None) -> Call[Nothing]:
    """Remove a session."""
    path, ids = "/v1/sessions/{session}", {"session": session_id}
    return Call("session.delete", "DELETE", path, Nothing, ids, writes=True, if_match=if_match)


def history(session_id: str, after: str | None) -> Call[HistoryPage]:
    """A page of a session's history."""
    path = "/v1/sessions/{session}/history"
    return Call("history.get", "GET", path, HistoryPage, {"session": session_id}, {"after": after})


def put_belief(session_id: str, request: BeliefRequest, if_match: int | None) -> Call[Session]:
    """Replace a session's belief."""
    path, ids = "/v1/sessions/{session}/belief", {"session": session_id}
    return Call("belief.put", "PUT", path, Session, ids, body=request, writes=True, if_match=if_match)


def report_outcome(session_id: str, request: OutcomeRequest, if_match: int | None) -> Call[UpdatedSession]:
    """What came of a grasp attempt."""
    path, ids = "/v1/sessions/{session}/grasp-outcomes", {"session": session_id}
    return Call("outcome.report", "POST", path, UpdatedSession, ids, body=request, writes=True, if_match=if_match)


def apply_scan(session_id: str, request: ScanRequest, if_match: int | None) -> Call[UpdatedSession]:
    """A raw scan."""
    path, ids = "/v1/sessions/{session}/scans", {"session": session_id}
    return Call("scan.apply", "POST", path, UpdatedSession, ids, body=request, writes=True, if_match=if_match)


def rank_looks(session_id: str, request: VoaRequest) -> Call[Ranking]:
    """Looks by their Value of Assistance."""
    path = "/v1/sessions/{session}/voa"
    return Call("voa.rank", "POST", path, Ranking, {"session": session_id}, body=request, heavy=True)


def rank_grasps(session_id: str, reachable: list[str] | None) -> Call[RankedGrasps]:
    """Grasps by their expected score."""
    path = "/v1/sessions/{session}/grasps"
    return Call("grasp.rank", "GET", path, RankedGrasps, {"session": session_id}, {"grasps": reachable})


def update_once(request: UpdateRequest) -> Call[UpdatedEstimate]:
    """An update of a belief in the request."""
    return Call("update.compute", "POST", "/v1/updates", UpdatedEstimate, body=request)


def rank_once(request: RankingRequest) -> Call[Ranking]:
    """A ranking for a belief in the request."""
    return Call("ranking.compute", "POST", "/v1/rankings", Ranking, body=request, heavy=True)


def robots() -> Call[Robots]:
    """The robots that were heard."""
    return Call("robot.list", "GET", "/v1/robots", Robots)


def request_look(robot: str) -> Call[RobotReport]:
    """The next scans of a robot are a look."""
    return Call("robot.look", "POST", "/v1/robots/{robot}/look", RobotReport, {"robot": robot})


def claim_robot(robot: str, request: ClaimRequest) -> Call[RobotReport]:
    """Say whose session a mapped robot's scans are for."""
    path = "/v1/robots/{robot}/session"
    return Call("robot.claim", "PUT", path, RobotReport, {"robot": robot}, body=request, http_only=True)
