"""Session files through a service: made anew, version by version."""

from pathlib import Path

from rich.console import Console

from voa_client import Client
from voa_recordings.session_file import Replayed, read_session_file, replay_session


def replay_file(client: Client, path: Path, mesh: Path | None) -> Replayed:
    """The session of a file, made anew.

    Raises:
        InvalidSessionFile: the file is none, or the mesh is another one.
        VoaClientError: the service cannot be reached, or refuses.
    """
    return replay_session(client, read_session_file(path), mesh)


def show(console: Console, done: Replayed) -> None:
    """Whether it believes the same, in a sentence."""
    told = "exactly what the first one did" if done.same else "something ELSE than the first one did"
    console.print(f"session {done.session.id}, version {done.session.version}: believes {told}", highlight=False)
