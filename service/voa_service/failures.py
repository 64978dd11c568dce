"""Failures: requests that cannot be answered, as callers of every entrypoint see them.

`guard` turns other errors into failures; `problem_schemas` describes their members for the OpenAPI document.
"""

import json
from collections.abc import Sequence
from typing import Any, ClassVar

import structlog
from pydantic import BaseModel, ValidationError

from voa_msgs import WIRE_VERSION
from voa_msgs.bounds import MOST_ERRORS
from voa_msgs.reading import by_weight, dotted, headline, json_problem, problem


class Failure(Exception):
    """A request that cannot be answered.

    Attributes:
        kind: last part of the problem document's `type`.
        status: of the HTTP response.
        title: the kind in words.
        members: names of the further members that a problem document of this kind may have.
        detail: explanation for the caller: expected value, received value, and remedy.
        headers: of the HTTP response.
        more: further members of the problem document, by name.
    """

    kind: ClassVar[str]
    status: ClassVar[int]
    title: ClassVar[str]
    members: ClassVar[tuple[str, ...]] = ()

    def __init__(self, detail: str, headers: dict[str, str] | None = None, **more: Any) -> None:
        super().__init__(detail)
        self.detail = detail
        self.headers = headers or {}
        self.more = more


class MalformedJson(Failure):
    """A body that is not JSON."""

    kind, status, title = "malformed-json", 400, "The body is not JSON"


class MalformedForm(Failure):
    """A body that is not a multipart form."""

    kind, status, title = "malformed-form", 400, "The body is not a multipart form"


class Unauthenticated(Failure):
    """A call without a valid key, to a service that needs one."""

    kind, status, title = "unauthenticated", 401, "A valid key is required"

    def __init__(self, detail: str, headers: dict[str, str] | None = None) -> None:
        super().__init__(detail, {"WWW-Authenticate": "Bearer"} | (headers or {}))


class TooManyRequests(Failure):
    """More calls than a key may make in that time."""

    kind, status, title = "too-many-requests", 429, "Too many calls with this key"
    members = ("retry_after_s",)


class TooManyWithoutKey(Failure):
    """A call without a valid key, after more of them than one origin may make in that time."""

    kind, status, title = "too-many-without-key", 429, "Too many calls without a valid key"
    members = ("retry_after_s",)


class Forbidden(Failure):
    """A call that is not allowed."""

    kind, status, title = "forbidden", 403, "This call is not allowed"


class NotFound(Failure):
    """An address that names no resource."""

    kind, status, title = "not-found", 404, "Not found"
    members = ("known",)


class MethodNotAllowed(Failure):
    """A path that does not have the requested method."""

    kind, status, title = "method-not-allowed", 405, "This path does not have that method"


class ClaimConflict(Failure):
    """A claim of a robot that its mapping does not allow."""

    kind, status, title = "claim-conflict", 409, "The robot's mapping does not allow the claim"


class InUse(Failure):
    """A deletion of content that something needs."""

    kind, status, title = "in-use", 409, "Something needs it"


class StaleVersion(Failure):
    """An `If-Match` that does not name the session's version."""

    kind, status, title = "stale-version", 412, "The session has another version"
    members = ("version",)


class TooLarge(Failure):
    """A request or response that is larger than the service accepts."""

    kind, status, title = "too-large", 413, "Larger than this service accepts"


class UnsupportedMeshType(Failure):
    """A mesh file of a type that the service does not read."""

    kind, status, title = "unsupported-mesh-type", 415, "Unsupported mesh type"


class UnsupportedMediaType(Failure):
    """A body of a type that the call does not accept."""

    kind, status, title = "unsupported-media-type", 415, "Unsupported media type"


class MisdirectedRequest(Failure):
    """A request under a host name that is not the service's."""

    kind, status, title = "misdirected-request", 421, "Unknown host name"


class InvalidRequest(Failure):
    """A request whose shape or values are not as expected."""

    kind, status, title = "invalid-request", 422, "Invalid request"
    members = ("errors",)


class UnknownReference(Failure):
    """A request that names something that does not exist."""

    kind, status, title = "unknown-name", 422, "Unknown name in the request"
    members = ("known",)


class MeshRequired(Failure):
    """A prediction that needs a mesh, in a scenario without one."""

    kind, status, title = "no-mesh", 422, "A mesh is required"


class BeamGridMismatch(Failure):
    """A scan whose beams differ from those of the predictions."""

    kind, status, title = "beam-grid-mismatch", 422, "The scan's beams do not match"


class InvalidMesh(Failure):
    """A file that is not a usable mesh."""

    kind, status, title = "invalid-mesh", 422, "The file is not a usable mesh"


class LookCounted(Failure):
    """A look that the session has counted before."""

    kind, status, title = "look-counted", 409, "The session has counted this look already"


class NotAccepted(Failure):
    """A look of a mapped robot that the session did not accept."""

    kind, status, title = "not-accepted", 422, "The look was not accepted"
    members = ("reason",)


class IdempotencyKeyReused(Failure):
    """An idempotency key that was used for another request before."""

    kind, status, title = "idempotency-key-reused", 422, "Idempotency-Key was used for another request"


class WireVersionMismatch(Failure):
    """A caller that uses another version of the messages."""

    kind, status, title = "wire-version", 400, "Another version of the messages"


class Overloaded(Failure):
    """More requests than the service can handle at the moment."""

    kind, status, title = "overloaded", 503, "Overloaded"
    members = ("retry_after_s",)


class NotReady(Failure):
    """A service that cannot work at the moment."""

    kind, status, title = "not-ready", 503, "Not ready"
    members = ("retry_after_s",)


class Damaged(Failure):
    """Stored data that differs from what was written."""

    kind, status, title = "damaged", 500, "Stored data is damaged"
    members = ("version",)


class RuleFailed(Failure):
    """An update rule of another package that raised an error or returned no usable result."""

    kind, status, title = "rule-failed", 500, "The update rule of another package failed"


class MalformedRequest(Failure):
    """Bytes that are not an HTTP request."""

    kind, status, title = "malformed-request", 400, "The bytes are not an HTTP request"


class RequestTimeout(Failure):
    """A request that did not arrive in time."""

    kind, status, title = "request-timeout", 408, "The request did not arrive in time"


class HeadersTooLarge(Failure):
    """Headers that are larger than the service accepts."""

    kind, status, title = "headers-too-large", 431, "The headers of the request are too large"


class HttpError(Failure):
    """Any other refusal of the web framework, by its status."""

    kind, title = "http-error", "The request cannot be answered"

    def __init__(self, status: int, detail: str, headers: dict[str, str] | None = None) -> None:
        super().__init__(detail, headers)
        self.status = status  # type: ignore[misc] # differs between instances


class InternalError(Failure):
    """A defect of the service."""

    kind, status, title = "internal", 500, "Internal error"


def not_found(what: str, id_: str) -> Failure:
    """Build the failure of a path whose id does not exist.

    Args:
        what: kind of the resource, such as "session".
        id_: that does not exist.
    """
    return NotFound(f"there is no {what} {id_!r}")


def wire_failure(theirs: object) -> Failure:
    """Build the failure of a caller that uses another version of the messages.

    Args:
        theirs: version that the caller stated.
    """
    return WireVersionMismatch(
        f"this service uses version {WIRE_VERSION} of the messages, the caller version {theirs}: "
        "install the client of the service's version",
    )


def malformed(what: str, text: str, at: int) -> Failure:
    """Build the failure of a body that is not JSON.

    Args:
        what: the parser's message.
        text: the body.
        at: index of the first wrong character.
    """
    return MalformedJson(f"{json_problem(what, text, at)} at character {at}")


def of_validation(errors: Sequence[Any], kind: Any) -> Failure:
    """Build the failure of a message that does not have the expected shape.

    Args:
        errors: listed by pydantic; each location begins with "body" or "query".
        kind: type of the message.
    """
    mistakes = [(dotted(error["loc"]), problem(kind, error | {"loc": error["loc"][1:]})) for error in by_weight(errors)]
    fields = [{"field": field, "problem": what} for field, what in mistakes[:MOST_ERRORS]]
    return InvalidRequest(headline(mistakes), errors=fields)


def of_message(kind: type[BaseModel], error: ValidationError, where: str) -> Failure:
    """Build the failure of a message that pydantic refused.

    Args:
        kind: type of the message.
        error: raised by pydantic.
        where: part of the request that holds the message, such as "body"; the fields' names begin with it.
    """
    errors = [dict(each) | {"loc": (where, *each["loc"])} for each in error.errors(include_url=False)]
    return of_validation(errors, kind)


def document(failure: Failure) -> bytes:
    """Return the problem document of a failure (RFC 9457) as JSON, for any transport."""
    request_id = structlog.contextvars.get_contextvars().get("request_id")
    fields = {
        "type": f"urn:voa:problem:{failure.kind}",
        "title": failure.title,
        "status": failure.status,
        "detail": failure.detail,
        "request_id": request_id,
    }
    if "Retry-After" in failure.headers:
        fields["retry_after_s"] = int(failure.headers["Retry-After"])
    return json.dumps(fields | failure.more, allow_nan=False).encode()
