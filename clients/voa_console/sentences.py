"""Sentences for people about calls that failed, and about scans that were not accepted."""

from voa_client import (
    ConflictError,
    DeniedError,
    InvalidRequestError,
    NotFoundError,
    OverloadedError,
    ProblemError,
    StaleVersionError,
    TimedOutError,
    UnavailableError,
    UnreachableError,
    VoaClientError,
)

REASONS = {
    "no_beams": "no beam could be compared, because every beam of the scan is missing",
    "nothing_seen": "no beam met the object",
    "bad_fit": "no pose fits well enough: it may be another object, or the robot may stand elsewhere",
    "no_match": "no pose explains the scan",
    "nearest": "no pose explains the scan, so the nearest poses share the belief",
}
"""Reasons of updates in words."""


def needs_key(error: VoaClientError | None) -> bool:
    """True if a call failed because the service needs a key, or no longer accepts the one that it received."""
    return isinstance(error, DeniedError) and error.needs_key


def sentence_of(error: VoaClientError) -> str:
    """Write in plain words why a call failed, and what to do.

    Args:
        error: that a client of the service raised.
    """
    if isinstance(error, UnavailableError):
        return _unavailable(error)
    if isinstance(error, ProblemError):
        return _refused(error)
    if isinstance(error, TimedOutError):
        return "The service did not answer in time. To find out why: voa doctor."
    if isinstance(error, UnreachableError):
        return "The service does not respond. Start it, or correct the address; to find out why: voa doctor."
    return f"The call failed: {str(error).rstrip('.')}."


def not_followed(error: VoaClientError, *, is_known: bool) -> str:
    """Write why a session is not followed at the moment.

    Args:
        error: that a client of the service raised.
        is_known: True if a version of the session was received before.
    """
    state = " What you see is the last state that was received; it continues by itself." if is_known else ""
    return f"{sentence_of(error)}{state}"


def _refused(error: ProblemError) -> str:
    """Write why the service refused a request that it may not accept at another time either."""
    match error:
        case StaleVersionError(version=version):
            now = "" if version is None else f" (it has version {version} now)"
            return f"Somebody else changed the session in the meantime{now}. Look at the new state, then try again."
        case ConflictError():
            return f"This contradicts the present state: {_detail(error)}."
        case NotFoundError():
            return f"This does not exist, or no longer exists: {_detail(error)}."
        case InvalidRequestError():
            return f"The service cannot use these values: {_fields(error)}."
        case DeniedError():
            return f"The service {_denial(error)}: {_detail(error)}."
    return f"The service refused: {_detail(error)}."


def _denial(error: DeniedError) -> str:
    if error.kind == "too-many-without-key":
        return "received no valid key, and too many such calls"
    return "does not accept the key" if needs_key(error) else "does not allow this"


def _unavailable(error: UnavailableError) -> str:
    """Write why the service cannot answer at the moment, and when to try again."""
    again = "in a moment" if error.retry_after_s is None else f"in {error.retry_after_s:.0f} s"
    if isinstance(error, OverloadedError) and error.kind == "too-many-requests":
        return f"This key has made more calls than the service allows in a short time. Try again {again}."
    if isinstance(error, OverloadedError):
        return f"The service is busy at the moment, and changed nothing. Try again {again}."
    return f"The service cannot answer at the moment: {_detail(error)}. Try again {again}."


def _detail(error: ProblemError) -> str:
    return error.problem.detail.rstrip(".")


def _fields(error: ProblemError) -> str:
    """Write the mistakes of an invalid request field by field, or else the whole problem."""
    mistakes = error.problem.errors or []
    if not mistakes:
        return _detail(error)
    return "; ".join(f"{mistake.field.removeprefix('body.')}: {mistake.problem}" for mistake in mistakes)
