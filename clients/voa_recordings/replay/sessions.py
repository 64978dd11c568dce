"""Replay of the sessions in a recording (`voa record`): each is rebuilt on a service from its scenario and history."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from voa_client import Client
from voa_recordings.files.sessions import RecordedSession
from voa_recordings.session_file import InvalidSessionFile, RebuiltSession, rebuild_session, stored_mesh


@dataclass(frozen=True)
class SessionReplay:
    """A session of a recording, and the session rebuilt from it; `rebuilt` is None if the recording is incomplete."""

    recorded: RecordedSession
    rebuilt: RebuiltSession | None


@dataclass(frozen=True)
class SessionsReport:
    """The sessions of a recording, rebuilt.

    Attributes:
        messages: number of messages that were read from the recording.
        damage: of the recording, as predicates ("ends in the middle"); None: none.
        sessions: by their id in the recording.
    """

    messages: int
    damage: str | None
    sessions: Sequence[SessionReplay]

    @property
    def agrees(self) -> bool:
        """True if at least one session was rebuilt, and every rebuilt one has exactly the recorded belief."""
        same = [each.rebuilt.same for each in self.sessions if each.rebuilt is not None]
        return bool(same) and all(same)


def replay_sessions(client: Client, sessions: Sequence[RecordedSession], mesh: Path | None) -> list[SessionReplay]:
    """Rebuild each session of a recording on a service.

    Args:
        client: of the service.
        sessions: of a recording.
        mesh: the object's mesh file; None: the service has all objects, or no scenario has one.

    Raises:
        InvalidSessionFile: the mesh belongs to none of the sessions.
        VoaClientError: the service cannot be reached, or refuses.
    """
    if mesh is not None:
        stored = stored_mesh(client, mesh)
        objects = sorted({each.file.scenario.object or "none" for each in sessions if each.file is not None})
        if stored not in objects:
            raise InvalidSessionFile(
                f"{mesh} is object {stored}, but the sessions need {', '.join(objects)}: give the mesh of one of these"
            )
    return [SessionReplay(each, None if each.file is None else rebuild_session(client, each.file)) for each in sessions]
