"""Session files: a session's scenario and history as JSON, from which another service can rebuild the session.

A file holds the request that made the scenario, the history, and the last belief. It names the object's mesh by its
digest: the other service needs that object already, or the mesh file with the session file.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from voa_client import Client, NotFoundError, VoaClientError
from voa_client.message_files import read_file
from voa_msgs.base import Message
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, HistoryEntry, OutcomeRequest, ScanRequest, Session, SessionRequest


class InvalidSessionFile(VoaClientError):
    """The file is not a session file, or its mesh is missing or wrong; the message says which."""


class SessionFile(Message):
    """Content of a session file."""

    scenario: ScenarioRequest
    history: list[HistoryEntry]
    belief: list[float]
    """The last belief: a probability for each pose."""


@dataclass(frozen=True)
class RebuiltSession:
    """A session that was rebuilt from a file; `same` is True if its belief equals the file's, bit for bit."""

    session: Session
    same: bool


def export_session(client: Client, session_id: str) -> SessionFile:
    """Read a session, its scenario and its history from a service; raises VoaClientError."""
    session = client.get_session(session_id)
    scenario = client.get_scenario(session.scenario).request()
    history = [entry for entry in client.history(session_id) if entry.version <= (session.version or 0)]
    return SessionFile(scenario=scenario, history=history, belief=session.belief)


def read_session_file(path: Path) -> SessionFile:
    """Read a session file; raises InvalidSessionFile if it is missing or not one."""
    return read_file(SessionFile, path, InvalidSessionFile)


def stored_mesh(client: Client, mesh: Path) -> str:
    """Upload a mesh file (metres, z up) and return its object's id; raises InvalidSessionFile if it cannot be read."""
    try:
        return client.create_object(mesh).id
    except OSError as error:
        raise InvalidSessionFile(f"{mesh}: {error.strerror}; expected the mesh file of the session's object") from error


def rebuild_session(client: Client, file: SessionFile, mesh: Path | None = None) -> RebuiltSession:
    """Rebuild a session on another service by sending its history, version by version.

    Args:
        client: of that service.
        file: the session's scenario, history and last belief.
        mesh: the object's mesh file; None: the service has the object, or the scenario has none.

    Raises:
        InvalidSessionFile: the mesh is not that of the session's object.
        VoaClientError: the service cannot be reached, or refuses.
    """
    if mesh is not None:
        stored = stored_mesh(client, mesh)
        if stored != file.scenario.object:
            raise InvalidSessionFile(
                f"{mesh} is object {stored}, but the session needs {file.scenario.object}: give that object's mesh"
            )
    elif file.scenario.object is not None:
        try:
            client.get_object(file.scenario.object)
        except NotFoundError as error:
            missing = f"this service has no object {file.scenario.object}"
            raise InvalidSessionFile(f"{missing}: give its mesh with `voa replay --mesh FILE`") from error
    scenario = client.create_scenario(file.scenario)
    opened = {
        name: value for name, value in _body(file.history[0]).items() if name != "robots"
    }  # a claim would move live robots
    session = client.create_session(SessionRequest.model_validate(opened | {"scenario": scenario.id}))
    for entry in file.history[1:]:
        session = _send(client, session.id, entry)
    return RebuiltSession(session, session.belief == file.belief)


def _send(client: Client, session_id: str, entry: HistoryEntry) -> Session:
    match entry.kind:
        case "scan":
            return client.apply_scan(session_id, ScanRequest.model_validate(_body(entry)))
        case "outcome":
            return client.report_outcome(session_id, OutcomeRequest.model_validate(_body(entry)))
        case _:
            return client.put_belief(session_id, BeliefRequest.model_validate(_body(entry)))


def _body(entry: HistoryEntry) -> dict[str, Any]:
    body: dict[str, Any] = json.loads(json.dumps(entry.request))
    return body
