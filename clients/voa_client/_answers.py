"""Answers of the service, as transports return them: read as messages, or raised as errors."""

import json
from dataclasses import dataclass

from pydantic import ValidationError

from voa_client._calls import Call, M
from voa_client._errors import ANSWERED_BETWEEN, UnexpectedAnswerError, WireVersionError, refusal
from voa_client.installing import install_hint
from voa_msgs import WIRE_VERSION
from voa_msgs.problems import Problem
from voa_msgs.reading import in_one_line


@dataclass(frozen=True)
class Reply:
    """An answer of the service, before it is read.

    Attributes:
        body: JSON; empty for an answer without content.
        refused: True if the body is a problem document.
        wire: version of the messages that the service uses; None: not stated.
        retry_after_s: seconds after which to try again; None: not stated.
    """

    body: bytes
    refused: bool = False
    wire: int | None = None
    retry_after_s: float | None = None


def read(call: Call[M], reply: Reply) -> M:
    """Read the answer to a call.

    Fields of the answer that this version does not know are ignored, so that an older robot can use a newer service.

    Raises:
        WireVersionError: the service uses another version of the messages.
        ProblemError: the service refuses the call.
        UnexpectedAnswerError: the body is not an answer to this call.
    """
    check(reply)
    return parse(call.answer, reply.body or b"{}")


def check(reply: Reply) -> None:
    """Raise ProblemError if the service refused the call, WireVersionError if its messages are of another version."""
    if reply.wire is not None and reply.wire != WIRE_VERSION:
        raise WireVersionError(_skew(reply.wire))
    if not reply.refused:
        return
    problem = parse(Problem, reply.body)
    if problem.type.endswith(":wire-version"):
        raise WireVersionError(f"the service does not accept version {WIRE_VERSION} of the messages: {problem.detail}")
    raise refusal(problem, problem.retry_after_s if reply.retry_after_s is None else reply.retry_after_s)


def parse(kind: type[M], body: bytes) -> M:
    """Parse a message from JSON, and ignore unknown fields; raises UnexpectedAnswerError if it is another document."""
    try:
        return kind.model_validate_json(body, extra="ignore")
    except ValidationError as error:
        raise UnexpectedAnswerError(
            f"expected a {kind.__name__}, got {body[:80]!r} ({in_one_line(kind, error)})"
        ) from error


def synthetic_problem(status: int, where: str, text: str) -> bytes:
    """Make a problem document for an HTTP error that a proxy answered, rather than the service."""
    title = f"HTTP {status} from {where}"
    return json.dumps(
        {"type": f"urn:voa:problem:{ANSWERED_BETWEEN}", "title": title, "status": status, "detail": text[:200]}
    ).encode()


def _skew(theirs: int) -> str:
    side = f"this program: {install_hint()}, of a newer clone" if theirs > WIRE_VERSION else "the service"
    return f"the service uses version {theirs} of the messages, this program version {WIRE_VERSION}: update {side}"
