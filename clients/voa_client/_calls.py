"""Calls of the service as data, made by one function each, without I/O."""

import hashlib
from pathlib import PurePath
from typing import Any

from voa_client._call import Call, Nothing, Upload
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
