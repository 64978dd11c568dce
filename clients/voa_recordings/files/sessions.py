"""The sessions in a recording: each with its scenario, its history, and its beliefs.

| topic                           | message                       | how often                                       |
|---------------------------------|-------------------------------|-------------------------------------------------|
| `/voa/<session>/scenario`       | `scenarios.Scenario`          | once                                            |
| `/voa/<session>/history`        | `sessions.HistoryEntry`       | each version, in order                          |
| `/voa/<session>/belief`         | `sessions.Session`            | each version that was received                  |
| `/voa/<session>/scan`           | `sessions.ScanRequest`        | each raw scan in JSON                           |
| `/voa/<session>/laser_scan`     | `sensor_msgs/msg/LaserScan`   | each raw scan in CDR; on `scan` in older files  |
| `/voa/<session>/scan_attachment`| `keys.Attachment`             | beside a raw scan that had one                  |
| `/voa/<session>/refused`        | `problems.Problem`            | each scan that could not be used                |
| `/voa/<session>/deleted`        | `{}`                          | when the session ended                          |

All but LaserScan are JSON (`json_text`). Beside them stand the messages that show a version (`voa_recordings.scenes`).
"""

import re
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from pydantic import BaseModel, ValidationError

from voa_msgs.reading import in_one_line
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import HistoryEntry, Session
from voa_recordings.files.json_text import json_of
from voa_recordings.files.message import RecordedMessage, UnreadableRecording
from voa_recordings.session_file import SessionFile

_TOPIC = re.compile(r"/voa/([^/]+)/([a-z_]+)")
_KINDS: dict[str, type[BaseModel]] = {"scenario": Scenario, "history": HistoryEntry, "belief": Session}


def topic_of(session: str, what: str) -> str:
    """Return the topic of a recording for one kind of a session's messages, such as "history"."""
    return f"/voa/{session}/{what}"


class RecordedSession(NamedTuple):
    """A session of a recording: the file to rebuild it from, or in `lacks` what the recording lacks for that."""

    session: str
    file: SessionFile | None
    lacks: str | None


@dataclass
class _Messages:
    scenario: Scenario | None = None
    history: dict[int, HistoryEntry] = field(default_factory=dict)
    beliefs: dict[int, list[float]] = field(default_factory=dict)


def recorded_sessions(messages: Iterable[RecordedMessage]) -> list[RecordedSession]:
    """Collect every session of a recording, by id, up to the newest version that has both history and belief.

    Raises:
        UnreadableRecording: a message is not of the kind that its topic names.
    """
    sessions: defaultdict[str, _Messages] = defaultdict(_Messages)
    for message in messages:
        named = _TOPIC.fullmatch(message.topic)
        body = None if named is None else json_of(message)
        if named is not None and body is not None:
            _note(sessions[named[1]], named[2], message.topic, body)
    return [_session(session, sessions[session]) for session in sorted(sessions)]


def _note(known: _Messages, what: str, topic: str, body: bytes) -> None:
    try:
        if what == "scenario":
            known.scenario = Scenario.model_validate_json(body, extra="ignore")
        elif what == "history":
            entry = HistoryEntry.model_validate_json(body, extra="ignore")
            known.history[entry.version] = entry
        elif what == "belief":
            session = Session.model_validate_json(body, extra="ignore")
            if session.version is not None:
                known.beliefs[session.version] = session.belief
    except ValidationError as error:
        raise UnreadableRecording(f"{topic}: {in_one_line(_KINDS[what], error)}") from error


def _session(session: str, known: _Messages) -> RecordedSession:
    if known.scenario is None:
        return RecordedSession(session, None, "its scenario was not recorded")
    history: list[HistoryEntry] = []
    while len(history) in known.history:
        history.append(known.history[len(history)])
    complete = [version for version in known.beliefs if version < len(history)]
    if not complete:
        return RecordedSession(session, None, "no version has both its belief and all of its history")
    last = max(complete)
    file = SessionFile(scenario=known.scenario.request(), history=history[: last + 1], belief=known.beliefs[last])
    return RecordedSession(session, file, None)
