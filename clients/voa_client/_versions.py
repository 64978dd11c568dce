"""A session at one version: what may be taken for it, and what the service's history says of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_client._answers import parse
from voa_client._errors import UnexpectedAnswerError
from voa_msgs.sessions import HistoryEntry, Session


@dataclass(frozen=True)
class Version:
    """A session that is stored somewhere, and its version."""

    number: int
    session: Session


def stored(session_id: str, session: Session) -> Version:
    """The session as one that is stored; raises UnexpectedAnswerError if it is another one, or has no version."""
    if session.id != session_id or session.version is None or session.version < 0:
        raise UnexpectedAnswerError(
            f"expected a version of session {session_id}, got {session.version} of {session.id[:80]!r}"
        )
    return Version(session.version, session)


def received(session_id: str, body: bytes) -> Version:
    """The version of a session that a body is; raises UnexpectedAnswerError if it is none."""
    return stored(session_id, parse(Session, body))


def confirmed(entry: HistoryEntry, bodies: Sequence[bytes], now: Session) -> Session | None:
    """The session at the version of an entry of its history; None if no body, or more than one, can be it.

    Args:
        entry: of the session's history, as the service says.
        bodies: what claims to be that version, from anybody.
        now: the session as it stands, as the service says.
    """
    true: list[Session] = []
    for body in bodies:
        try:
            session = parse(Session, body)
        except UnexpectedAnswerError:
            continue
        if _is_it(session, entry, now) and session not in true:
            true.append(session)
    return true[0] if len(true) == 1 else None


def _is_it(session: Session, entry: HistoryEntry, now: Session) -> bool:
    fixed = all(getattr(session, name) == getattr(now, name) for name in ("id", "scenario", "poses", "created_at"))
    dated = (session.version, session.updated_at) == (entry.version, entry.at)
    return fixed and dated and len(session.belief) == len(session.poses)
