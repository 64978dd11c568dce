"""Session files: one session with everything that happened to it, to be replayed on another service.

A file holds the scenario's request, the history, and the belief at the end. The object's mesh is named by its
digest: where a scenario has one, it must be on the other service already, or be given beside.
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
    """A file is not a session file; says what is wrong."""


class SessionFile(Message):
    """The content of a session file."""

    scenario: ScenarioRequest
    history: list[HistoryEntry]
    belief: list[float]
    """At the end."""


@dataclass(frozen=True)
class Replayed:
    """A session made anew from a file, and whether it believes exactly what the first one did."""

    session: Session
    same: bool


def export_session(client: Client, session_id: str) -> SessionFile:
    """Everything about a session."""
    session = client.get_session(session_id)
    scenario = client.get_scenario(session.scenario).request()
    history = [entry for entry in client.history(session_id) if entry.version <= (session.version or 0)]
    return SessionFile(scenario=scenario, history=history, belief=session.belief)


def read_session_file(path: Path) -> SessionFile:
    """Read a session file; raises InvalidSessionFile."""
    return read_file(SessionFile, path, InvalidSessionFile)


def stored_mesh(client: Client, mesh: Path) -> str:
    """Store a mesh file, in metres with z up; its id. Raises InvalidSessionFile where there is no such file."""
    try:
        return client.create_object(mesh).id
    except OSError as error:
        raise InvalidSessionFile(f"{mesh}: {error.strerror}; expected the mesh file of the session's object") from error


def replay_session(client: Client, told: SessionFile, mesh: Path | None = None) -> Replayed:
    """Make the session anew on another service, version by version.

    Args:
        client: of that service.
        told: the session.
        mesh: the object's file; None: the service has it, or the scenario has none.

    Raises:
        InvalidSessionFile: the mesh is another one.
        VoaClientError: the service cannot be reached, or refuses.
    """
    if mesh is not None:
        stored = stored_mesh(client, mesh)
        if stored != told.scenario.object:
            raise InvalidSessionFile(f"{mesh} is object {stored}, the session's is {told.scenario.object}")
    elif told.scenario.object is not None:
        try:
            client.get_object(told.scenario.object)
        except NotFoundError as error:
            lacking = f"this service has no object {told.scenario.object}"
            raise InvalidSessionFile(f"{lacking}: name its mesh, with `voa replay --mesh FILE`") from error
    scenario = client.create_scenario(told.scenario)
    opened = {name: value for name, value in _body(told.history[0]).items() if name != "robots"}  # they are live ones
    session = client.create_session(SessionRequest.model_validate(opened | {"scenario": scenario.id}))
    for entry in told.history[1:]:
        session = _again(client, session.id, entry)
    return Replayed(session, session.belief == told.belief)


def _again(client: Client, session_id: str, entry: HistoryEntry) -> Session:
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
