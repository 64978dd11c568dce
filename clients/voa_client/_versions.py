"""Versions of a session: parsed, and confirmed by the service's history."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_client._errors import UnexpectedResponseError
from voa_client._responses import parse
from voa_msgs.sessions import HistoryEntry, Session


@dataclass(frozen=True)
class Version:
    """A stored session with its version number."""

    number: int
    session: Session


def stored(session_id: str, session: Session) -> Version:
    """Check that a session has the expected id and a version; raises UnexpectedResponseError if not."""
    if session.id != session_id or session.version is None or session.version < 0:
        raise UnexpectedResponseError(
            f"expected a version of session {session_id}, got {session.version} of {session.id[:80]!r}"
        )
    return Version(session.version, session)


def received(session_id: str, body: bytes) -> Version:
    """Parse a body as a version of a session; raises UnexpectedResponseError if it is not one."""
    return stored(session_id, parse(Session, body))


def confirmed(entry: HistoryEntry, bodies: Sequence[bytes], now: Session) -> Session | None:
    """Return the body that fits an entry of a session's history; None if none fits, or several different ones.

    Args:
        entry: of the session's history, from the service.
        bodies: that claim to be that version, from any program.
        now: the current version of the session, from the service.
    """
    fitting: list[Session] = []
    for body in bodies:
        try:
            session = parse(Session, body)
        except UnexpectedResponseError:
            continue
        if _fits(session, entry, now) and session not in fitting:
            fitting.append(session)
    return fitting[0] if len(fitting) == 1 else None


def _fits(session: Session, entry: HistoryEntry, now: Session) -> bool:
    fixed = all(getattr(session, name) == getattr(now, name) for name in ("id", "scenario", "poses", "created_at"))
    dated = (session.version, session.updated_at) == (entry.version, entry.at)
    return fixed and dated and len(session.belief) == len(session.poses)
