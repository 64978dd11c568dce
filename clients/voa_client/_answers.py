"""What comes back over any transport, and what it means."""

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
    """An answer as it arrived.

    Attributes:
        body: JSON; empty for an answer without content.
        refused: whether the body is a problem document.
        wire: the version of the messages that the service speaks, if it said so.
        retry_after_s: when to try again, if it said so.
    """

    body: bytes
    refused: bool = False
    wire: int | None = None
    retry_after_s: float | None = None


def read(call: Call[M], reply: Reply) -> M:
    """The answer to a call.

    An old robot may talk to a new service: what it does not know in an answer, it ignores.

    Raises:
        WireVersionError: the service speaks another version of the messages.
        ProblemError: it refuses.
        UnexpectedAnswerError: that is no answer to this call.
    """
    check(reply)
    return parse(call.answer, reply.body or b"{}")


def check(reply: Reply) -> None:
    """Raise what a reply is, unless it is an answer; raises as `read`."""
    if reply.wire is not None and reply.wire != WIRE_VERSION:
        raise WireVersionError(_skew(reply.wire))
    if not reply.refused:
        return
    problem = parse(Problem, reply.body)
    if problem.type.endswith(":wire-version"):
        raise WireVersionError(f"the service does not speak version {WIRE_VERSION} of the messages: {problem.detail}")
    raise refusal(problem, problem.retry_after_s if reply.retry_after_s is None else reply.retry_after_s)


def parse(kind: type[M], body: bytes) -> M:
    """A message from JSON, fields that it does not know left out; raises UnexpectedAnswerError."""
    try:
        return kind.model_validate_json(body, extra="ignore")
    except ValidationError as error:
        raise UnexpectedAnswerError(
            f"expected a {kind.__name__}, got {body[:80]!r} ({in_one_line(kind, error)})"
        ) from error


def made_up(status: int, where: str, text: str) -> bytes:
    """The problem document of an error that something in between answered."""
    title = f"HTTP {status} from {where}"
    return json.dumps(
        {"type": f"urn:voa:problem:{ANSWERED_BETWEEN}", "title": title, "status": status, "detail": text[:200]}
    ).encode()


def _skew(theirs: int) -> str:
    side = f"this program: {install_hint()}, of a newer clone" if theirs > WIRE_VERSION else "the service"
    return f"the service speaks version {theirs} of the messages, this program version {WIRE_VERSION}: update {side}"
