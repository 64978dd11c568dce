"""Responses of the service, as transports return them: read as messages, or raised as errors."""

import json
from dataclasses import dataclass

from pydantic import ValidationError

from voa_client._call import Call, M
from voa_client._errors import PROXY_PROBLEM, UnexpectedResponseError, WireVersionError, refusal
from voa_client.installing import install_hint
from voa_msgs import WIRE_VERSION
from voa_msgs.problems import Problem
from voa_msgs.reading import in_one_line


@dataclass(frozen=True)
class Response:
    """A response of the service, before it is read.

    Attributes:
        body: JSON; empty for a response without content.
        refused: True if the body is a problem document.
        wire: version of the messages that the service uses; None: not stated.
        retry_after_s: seconds after which to try again; None: not stated.
    """

    body: bytes
    refused: bool = False
    wire: int | None = None
    retry_after_s: float | None = None


def read(call: Call[M], response: Response) -> M:
    """Read the response to a call.

    Fields of the response that this version does not know are ignored, so that an older robot can use a newer service.

    Raises:
        WireVersionError: the service uses another version of the messages.
        ProblemError: the service refuses the call.
        UnexpectedResponseError: the body is not a response to this call.
    """
    check(response)
    return parse(call.response, response.body or b"{}")


def check(response: Response) -> None:
    """Raise ProblemError if the service refused the call, WireVersionError if its messages are of another version."""
    if response.wire is not None and response.wire != WIRE_VERSION:
        raise WireVersionError(_skew(response.wire))
    if not response.refused:
        return
    problem = parse(Problem, response.body)
    if problem.type.endswith(":wire-version"):
        raise WireVersionError(f"the service does not accept version {WIRE_VERSION} of the messages: {problem.detail}")
    raise refusal(problem, problem.retry_after_s if response.retry_after_s is None else response.retry_after_s)


def parse(kind: type[M], body: bytes) -> M:
    """Parse a message from JSON, and ignore unknown fields; raises UnexpectedResponseError for another document."""
    try:
        return kind.model_validate_json(body, extra="ignore")
    except ValidationError as error:
        raise UnexpectedResponseError(
            f"expected a {kind.__name__}, got {body[:80]!r} ({in_one_line(kind, error)})"
        ) from error


def synthetic_problem(status: int, where: str, text: str) -> bytes:
    """Make a problem document for an HTTP error that a proxy sent instead of the service."""
    title = f"HTTP {status} from {where}"
    return json.dumps(
        {"type": f"urn:voa:problem:{PROXY_PROBLEM}", "title": title, "status": status, "detail": text[:200]}
    ).encode()


def _skew(theirs: int) -> str:
    side = f"this program: {install_hint()}, of a newer clone" if theirs > WIRE_VERSION else "the service"
    return f"the service uses version {theirs} of the messages, this program version {WIRE_VERSION}: update {side}"
