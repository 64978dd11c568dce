"""State of a session in words, from its looks and the newest request that was no look."""

from voa_client import HistoryEntry, Session, SessionSummary

_WAITS = "waits for a look"


def state_of(session: Session | SessionSummary, newest: HistoryEntry | None) -> str:
    """Write what has happened in a session, as in "Looked 3 times; TOP succeeded".

    Args:
        session: at its newest version; of a summary, the number of its versions is all that is known.
        newest: newest entry of its history that is known; None: none.
    """
    if isinstance(session, SessionSummary):
        text = f"changed {_times(session.version)}" if session.version else _WAITS
    else:
        text = "; ".join(_parts(session, newest if newest and newest.version == session.version else None))
    return f"{text[:1].upper()}{text[1:]}"


def _parts(session: Session, newest: HistoryEntry | None) -> list[str]:
    """Write the looks, then what happened last if that was no look, then what is under way or waited for."""
    looks = sum(place.looks for place in session.places)
    parts = [f"looked {_times(looks)}"] if looks else []
    last = "" if newest is None else _end(newest)
    if last:
        parts.append(last)
    under_way = len(session.under_way)
    if under_way:
        parts.append("a look is under way" if under_way == 1 else f"{under_way} looks are under way")
    elif not looks and (newest is None or newest.kind != "outcome"):
        parts.append(_WAITS)
    return parts


def _end(entry: HistoryEntry) -> str:
    """Write an outcome, or that the belief was replaced; "" for another request."""
    body = entry.request if isinstance(entry.request, dict) else {}
    match entry.kind:
        case "outcome":
            return f"{body.get('grasp')} {'succeeded' if body.get('success') else 'failed'}"
        case "belief":
            return "belief reset to the prior" if body.get("belief") is None else "belief replaced"
        case _:
            return ""


def _times(number: int) -> str:
    return {1: "once", 2: "twice"}.get(number, f"{number} times")
