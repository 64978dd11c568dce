"""The rebuilt sessions of a recording, as a JSON document and as sentences."""

from typing import Any

from rich.console import Console

from voa_recordings.replay.sessions import SessionReplay, SessionsReport
from voa_recordings.session_file import RebuiltSession


def document(report: SessionsReport) -> dict[str, Any]:
    """Return the document of `voa replay --json` for a recording with sessions."""
    return {
        "messages": report.messages,
        "damage": report.damage,
        "sessions": [_session(replay) for replay in report.sessions],
    }


def _session(replay: SessionReplay) -> dict[str, Any]:
    rebuilt = replay.rebuilt
    return {
        "recorded": replay.recorded.session,
        "lacks": replay.recorded.lacks,
        "same": None if rebuilt is None else rebuilt.same,
        "session": None if rebuilt is None else rebuilt.session.model_dump(mode="json"),
    }


def show_one(console: Console, rebuilt: RebuiltSession) -> None:
    """Print a sentence about a session that was rebuilt from a session file."""
    session = rebuilt.session
    console.print(f"session {session.id}, version {session.version}: {_verdict(rebuilt)}", highlight=False)


def show(console: Console, report: SessionsReport) -> None:
    """Print a sentence per session of a recording, and the damage of the recording."""
    for replay in report.sessions:
        session, rebuilt = replay.recorded.session, replay.rebuilt
        if rebuilt is None:
            console.print(f"session {session} cannot be rebuilt: {replay.recorded.lacks}", highlight=False)
            continue
        as_ = f"rebuilt as {rebuilt.session.id}, {_verdict(rebuilt)}"
        console.print(f"session {session}, version {rebuilt.session.version}: {as_}", highlight=False)
    show_damage(console, report.damage, report.messages)


def show_damage(console: Console, damage: str | None, messages: int) -> None:
    """Print the damage of a recording and the number of messages that were read all the same; nothing for None."""
    if damage is not None:
        console.print(f"! the recording {damage}: {messages} messages recovered", highlight=False, markup=False)


def _verdict(rebuilt: RebuiltSession) -> str:
    return "its belief is exactly the recorded one" if rebuilt.same else "its belief DIFFERS from the recorded one"
