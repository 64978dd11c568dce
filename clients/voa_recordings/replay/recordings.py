"""The sessions of a recording (`voa record`), each made anew on a service from its scenario and history."""

from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console

from voa_client import Client
from voa_recordings.files.reading import Recording
from voa_recordings.files.sessions import RecordedSession
from voa_recordings.session_file import InvalidSessionFile, Replayed, replay_session, stored_mesh


class Again(NamedTuple):
    """A recorded session, and what became of it; `done` is None where the recording lacks something."""

    recorded: RecordedSession
    done: Replayed | None


def replay_sessions(client: Client, sessions: list[RecordedSession], mesh: Path | None) -> list[Again]:
    """Make each session anew.

    Args:
        client: of the service.
        sessions: of a recording.
        mesh: an object's file; None: the service has them all, or no scenario has one.

    Raises:
        InvalidSessionFile: the mesh is of none of the sessions.
        VoaClientError: the service cannot be reached, or refuses.
    """
    if mesh is not None:
        stored = stored_mesh(client, mesh)
        objects = sorted({told.file.scenario.object or "none" for told in sessions if told.file is not None})
        if stored not in objects:
            raise InvalidSessionFile(f"{mesh} is object {stored}, the sessions' is {', '.join(objects)}")
    return [Again(told, None if told.file is None else replay_session(client, told.file)) for told in sessions]


def code_of(found: list[Again]) -> int:
    """The exit code: 0 if sessions were made anew, and all of them believe what was recorded."""
    same = [again.done.same for again in found if again.done is not None]
    return 0 if same and all(same) else 1


def report(found: list[Again], recording: Recording) -> dict[str, Any]:
    """The document of `--json`."""
    return {
        "messages": recording.recovered,
        "damage": recording.damage,
        "sessions": [
            {
                "recorded": again.recorded.session,
                "lacks": again.recorded.lacks,
                "same": None if again.done is None else again.done.same,
                "session": None if again.done is None else again.done.session.model_dump(mode="json"),
            }
            for again in found
        ],
    }


def show(console: Console, found: list[Again], recording: Recording) -> None:
    """A sentence per session, and what is wrong with the recording."""
    for again in found:
        told = f"session {again.recorded.session}"
        if again.done is None:
            console.print(f"{told} cannot be made anew: {again.recorded.lacks}", highlight=False)
            continue
        same = "exactly what was recorded" if again.done.same else "something ELSE than was recorded"
        anew = again.done.session
        console.print(f"{told}, version {anew.version}: made anew as {anew.id}, believes {same}", highlight=False)
    show_damage(console, recording)


def show_damage(console: Console, recording: Recording) -> None:
    """Print the damage of the recording, if it has any."""
    if recording.damage is not None:
        told = f"! the recording {recording.damage}: {recording.recovered} messages recovered"
        console.print(told, highlight=False, markup=False)
