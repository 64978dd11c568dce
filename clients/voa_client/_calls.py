"""Calls of the service as data, made by one function each, without I/O.

A `Call` holds the request in two forms: as a method, a path and a query for HTTP, and as the name of an rpc for the
other transports, whose payload has the ids and the query parameters beside the body's fields.
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
from voa_msgs.callers import Caller
from voa_msgs.lidars import LidarPresets
from voa_msgs.looks import AnnouncedLook, LookAnnouncement
from voa_msgs.objects import MeshFile, Object, ObjectPage, StablePoses, UpAxis
from voa_msgs.problems import Health
from voa_msgs.rankings import RankedGrasps, Ranking, RankingRequest, VoaRequest
from voa_msgs.robots import ClaimRequest, RobotReport, Robots, RobotScan
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

_USE_HTTP = "make the client with the service's http:// address"


class Nothing(Message):
    """Empty response, to calls that return nothing."""


@dataclass(frozen=True)
class Upload:
    """A mesh file to upload: a multipart form over HTTP, base64 over other transports."""

    filename: str
    content: bytes
    name: str | None
    scale: float
    up: UpAxis | None = None

    def form(self) -> dict[str, str]:
        """Return the fields of the multipart form, without the file."""
        return {"scale": repr(self.scale)} | self._stated()

    def fields(self) -> dict[str, Any]:
        """Return the fields of the JSON payload, with the file in base64."""
        file = base64.b64encode(self.content).decode("ascii")
        return {"filename": self.filename, "file": file, "scale": float(self.scale)} | self._stated()

    def _stated(self) -> dict[str, str]:
        """Return the optional fields that the caller gave; the service has defaults for the others."""
        given = {"name": self.name, "up": self.up}
        return {name: value for name, value in given.items() if value is not None}


@dataclass(frozen=True)
class Call(Generic[M]):
    """A request to the service, before it is sent.

    Attributes:
        rpc: name of the method on Zenoh.
        method: of HTTP.
        path: of HTTP, with the names of `ids` in braces.
        response: class of the message in the response.
        ids: values for the names in the path.
        query: parameters of the query string; those that are None are left out.
        body: message to send; None: there is none.
        upload: file to send instead of a body.
        writes: True if the call takes an idempotency key.
        heavy: True if the response may take long, so that one long attempt is made instead of several short ones.
        if_match: version that the session must have; None: any.
        http_only: True if the service answers the call over HTTP only.
    """

    rpc: str
    method: str
    path: str
    response: type[M]
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
                raise UsageError(f"{self.rpc}: {what}: expected an id, got an empty string")

    def check_has_rpc(self) -> None:
        """Raise UsageError if the call can be sent over HTTP only."""
        if self.http_only:
            raise UsageError(f"{self.rpc}: can be called over HTTP only; {_USE_HTTP}")
        if self.if_match is not None:
            raise UsageError(f"{self.rpc}: if_match can be used over HTTP only; {_USE_HTTP}")

    @property
    def url(self) -> str:
        """The path of HTTP, with the ids filled in."""
        return self.path.format(**{name: _quoted(id_) for name, id_ in self.ids.items()})

    @property
    def parameters(self) -> dict[str, str | int | float | list[str]]:
        """The parameters of the query that are not None."""
        return {name: value for name, value in self.query.items() if value is not None}

    def content(self) -> bytes | None:
        """Return the body of HTTP as JSON, with the fields that the caller has set; None if there is no body."""
        return None if self.body is None else self.body.model_dump_json(exclude_unset=True).encode()

    def payload(self) -> bytes:
        """Return the payload of an rpc as JSON: ids, parameters, and the fields of the body that the caller has set."""
        fields: dict[str, Any] = {} if self.body is None else self.body.model_dump(exclude_unset=True)
        if self.upload is not None:
            fields = self.upload.fields()
        return to_json(fields | dict(self.ids) | self.parameters)


def _quoted(id_: str) -> str:
    """Quote an id as one segment of a path; dots, too, where it has nothing else."""
    quoted = quote(id_, safe="")
    return quoted.replace(".", "%2E") if not quoted.strip(".") else quoted


def health() -> Call[Health]:
    """Read the state of the service."""
    return Call("service.health", "GET", "/readyz", Health)


def caller() -> Call[Caller]:
    """Read who the caller is, and what it may do."""
    return Call("caller.get", "GET", "/v1/caller", Caller)


def create_object(
    filename: str, content: bytes, name: str | None, scale: float, up: UpAxis | None = None
) -> Call[Object]:
    """Upload a mesh file."""
    upload = Upload(filename, content, name, scale, up)
    return Call("object.create", "POST", "/v1/objects", Object, upload=upload, heavy=True)


def get_object(object_id: str) -> Call[Object]:
    """Read a stored object."""
    return Call("object.get", "GET", "/v1/objects/{id}", Object, {"id": object_id})


def list_objects(after: str | None) -> Call[ObjectPage]:
    """List stored objects, a page at a time."""
    return Call("object.list", "GET", "/v1/objects", ObjectPage, query={"after": after})


def find_object(filename: str, content: bytes, scale: float, up: UpAxis | None = None) -> Call[ObjectPage]:
    """Search the object that was made from a mesh file, by its digest; `matching_object` reads the response."""
    file = {"sha256": hashlib.sha256(content).hexdigest(), "type": PurePath(filename).suffix.lower().removeprefix(".")}
    return Call("object.list", "GET", "/v1/objects", ObjectPage, query=file | {"scale": float(scale), "up": up})


def matching_object(call: Call[ObjectPage], response: ObjectPage) -> Object | None:
    """Pick the object of a `find_object` call; None if it is not there. Older services ignore the digest."""
    return next((item for item in response.items if item.sha256 == call.query["sha256"]), None)


def object_mesh(object_id: str, most_faces: int | None) -> Call[MeshFile]:
    """Read the mesh of an object as an STL file."""
    query = {} if most_faces is None else {"most_faces": most_faces}
    return Call("object.mesh", "GET", "/v1/objects/{id}/mesh", MeshFile, {"id": object_id}, query, heavy=True)


def stable_poses(object_id: str) -> Call[StablePoses]:
    """Compute the poses in which an object can rest on the table."""
    path = "/v1/objects/{id}/stable-poses"
    return Call("object.stable_poses", "GET", path, StablePoses, {"id": object_id}, heavy=True)


def lidars() -> Call[LidarPresets]:
    """List the lidars that scenarios can name."""
    return Call("lidar.list", "GET", "/v1/lidars", LidarPresets)


def create_scenario(request: ScenarioRequest) -> Call[Scenario]:
    """Store a scenario; equal content gives the same id."""
    return Call("scenario.create", "POST", "/v1/scenarios", Scenario, body=request, heavy=True)


def get_scenario(scenario_id: str) -> Call[Scenario]:
    """Read a stored scenario."""
    return Call("scenario.get", "GET", "/v1/scenarios/{id}", Scenario, {"id": scenario_id})


def list_scenarios(after: str | None) -> Call[ScenarioPage]:
    """List stored scenarios, a page at a time."""
    return Call("scenario.list", "GET", "/v1/scenarios", ScenarioPage, query={"after": after})


def warnings(scenario_id: str) -> Call[Warnings]:
    """List the probable mistakes in a scenario."""
    return Call("scenario.warnings", "GET", "/v1/scenarios/{id}/warnings", Warnings, {"id": scenario_id}, heavy=True)


def predict(scenario_id: str, request: PredictionsRequest) -> Call[Predictions]:
    """Predict scans."""
    path = "/v1/scenarios/{id}/predictions"
    return Call("scenario.predict", "POST", path, Predictions, {"id": scenario_id}, body=request, heavy=True)


def create_session(request: SessionRequest) -> Call[Session]:
    """Open a session."""
    return Call("session.create", "POST", "/v1/sessions", Session, body=request, writes=True)


def get_session(session_id: str) -> Call[Session]:
    """Read the current version of a session."""
    return Call("session.get", "GET", "/v1/sessions/{session}", Session, {"session": session_id})


def list_sessions(after: str | None) -> Call[SessionPage]:
    """List sessions, a page at a time."""
    return Call("session.list", "GET", "/v1/sessions", SessionPage, query={"after": after})


def delete_object(object_id: str) -> Call[Nothing]:
    """Delete a mesh that no scenario needs."""
    return Call("object.delete", "DELETE", "/v1/objects/{id}", Nothing, {"id": object_id})


def delete_scenario(scenario_id: str) -> Call[Nothing]:
    """Delete a scenario that no session is on."""
    return Call("scenario.delete", "DELETE", "/v1/scenarios/{id}", Nothing, {"id": scenario_id})


def delete_session(session_id: str, if_match: int | None) -> Call[Nothing]:
    """Delete a session with its history."""
    path, ids = "/v1/sessions/{session}", {"session": session_id}
    return Call("session.delete", "DELETE", path, Nothing, ids, writes=True, if_match=if_match)


def history(session_id: str, after: str | None, *, beliefs: bool = False) -> Call[HistoryPage]:
    """Read a session's history, a page at a time; with the belief of each version if `beliefs` is true."""
    query: dict[str, Any] = {"after": after} | ({"beliefs": True} if beliefs else {})
    path = "/v1/sessions/{session}/history"
    return Call("history.get", "GET", path, HistoryPage, {"session": session_id}, query)


def put_belief(session_id: str, request: BeliefRequest, if_match: int | None) -> Call[Session]:
    """Replace a session's belief."""
    path, ids = "/v1/sessions/{session}/belief", {"session": session_id}
    return Call("belief.put", "PUT", path, Session, ids, body=request, writes=True, if_match=if_match)


def report_outcome(session_id: str, request: OutcomeRequest, if_match: int | None) -> Call[UpdatedSession]:
    """Update a session's belief by the outcome of a grasp attempt."""
    path, ids = "/v1/sessions/{session}/grasp-outcomes", {"session": session_id}
    return Call("outcome.report", "POST", path, UpdatedSession, ids, body=request, writes=True, if_match=if_match)


def apply_scan(session_id: str, request: ScanRequest, if_match: int | None) -> Call[UpdatedSession]:
    """Update a session's belief by a raw scan."""
    path, ids = "/v1/sessions/{session}/scans", {"session": session_id}
    return Call("scan.apply", "POST", path, UpdatedSession, ids, body=request, writes=True, if_match=if_match)


def announce_look(session_id: str, request: LookAnnouncement) -> Call[AnnouncedLook]:
    """Announce a look that is under way."""
    path = "/v1/sessions/{session}/looks"
    return Call("look.announce", "POST", path, AnnouncedLook, {"session": session_id}, body=request, writes=True)


def cancel_look(session_id: str, look_id: str) -> Call[Nothing]:
    """End the announcement of a look."""
    path, ids = "/v1/sessions/{session}/looks/{look}", {"session": session_id, "look": look_id}
    return Call("look.cancel", "DELETE", path, Nothing, ids)


def rank_looks(session_id: str, request: VoaRequest) -> Call[Ranking]:
    """Rank looks by Value of Assistance."""
    path = "/v1/sessions/{session}/voa"
    return Call("voa.rank", "POST", path, Ranking, {"session": session_id}, body=request, heavy=True)


def rank_grasps(session_id: str, reachable: list[str] | None) -> Call[RankedGrasps]:
    """Rank grasps by expected score."""
    path = "/v1/sessions/{session}/grasps"
    return Call("grasp.rank", "GET", path, RankedGrasps, {"session": session_id}, {"grasps": reachable})


def update_once(request: UpdateRequest) -> Call[UpdatedEstimate]:
    """Update a belief that is given in the request, by a scan."""
    return Call("update.compute", "POST", "/v1/updates", UpdatedEstimate, body=request)


def rank_once(request: RankingRequest) -> Call[Ranking]:
    """Rank looks for a belief that is given in the request."""
    return Call("ranking.compute", "POST", "/v1/rankings", Ranking, body=request, heavy=True)


def robots() -> Call[Robots]:
    """List the robots that the service knows."""
    return Call("robot.list", "GET", "/v1/robots", Robots)


def robot_scan(robot: str) -> Call[RobotScan]:
    """Get the newest scan of a robot."""
    return Call("robot.scan", "GET", "/v1/robots/{robot}/scan", RobotScan, {"robot": robot})


def request_look(robot: str) -> Call[RobotReport]:
    """Request a look of a robot's next scans."""
    return Call("robot.look", "POST", "/v1/robots/{robot}/look", RobotReport, {"robot": robot})


def claim_robot(robot: str, request: ClaimRequest) -> Call[RobotReport]:
    """Assign a mapped robot to a session."""
    path = "/v1/robots/{robot}/session"
    return Call("robot.claim", "PUT", path, RobotReport, {"robot": robot}, body=request, http_only=True)
