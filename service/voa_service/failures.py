"""What can go wrong, as a caller sees it: one table from errors to kinds and statuses, for every entrypoint."""

import json
from collections.abc import Sequence
from typing import Any, ClassVar

import structlog
from pydantic import BaseModel, ValidationError

from voa_core import errors as core
from voa_core.errors import InvalidInput, NoMesh, UnknownName, VoaError
from voa_msgs import WIRE_VERSION
from voa_msgs.bounds import MOST_ERRORS
from voa_msgs.reading import by_weight, dotted, headline, json_problem, problem


class Failure(Exception):
    """A request that cannot be answered, with what a caller should know.

    Attributes:
        kind: the last part of the problem document's `type`.
        status: of the HTTP response.
        title: the kind in words.
        detail: what was expected, what came, and what to do.
        headers: of the HTTP response.
        more: further members of the problem document.
    """

    kind: ClassVar[str]
    status: ClassVar[int]
    title: ClassVar[str]

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


class Forbidden(Failure):
    """A call that is not allowed."""

    kind, status, title = "forbidden", 403, "This call is not allowed"


class NotFound(Failure):
    """A path that names nothing."""

    kind, status, title = "not-found", 404, "Not found"


class MethodNotAllowed(Failure):
    """A path without the method."""

    kind, status, title = "method-not-allowed", 405, "This path does not have that method"


class ClaimConflict(Failure):
    """A claim of a robot that its mapping does not allow."""

    kind, status, title = "claim-conflict", 409, "The robot's mapping does not allow the claim"


class StaleVersion(Failure):
    """An `If-Match` that names another version than the session has."""

    kind, status, title = "stale-version", 412, "The session has another version"


class TooLarge(Failure):
    """More than the service accepts at once."""

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


class UnknownReference(Failure):
    """A request that names something that does not exist."""

    kind, status, title = "unknown-name", 422, "Unknown name in the request"


class MeshRequired(Failure):
    """A prediction that needs a mesh where there is none."""

    kind, status, title = "no-mesh", 422, "A mesh is required"


class BeamGridMismatch(Failure):
    """A scan whose beams are not those of the predictions."""

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


class IdempotencyKeyReused(Failure):
    """An idempotency key that came with another request before."""

    kind, status, title = "idempotency-key-reused", 422, "Idempotency-Key was used for another request"


class WireVersionMismatch(Failure):
    """A caller that uses another version of the messages."""

    kind, status, title = "wire-version", 400, "Another version of the messages"


class Overloaded(Failure):
    """More requests than the service can handle at the moment."""

    kind, status, title = "overloaded", 503, "Overloaded"


class NotReady(Failure):
    """A service that cannot work at the moment."""

    kind, status, title = "not-ready", 503, "Not ready"


class Damaged(Failure):
    """Stored data that is not as it was written."""

    kind, status, title = "damaged", 500, "Stored data is damaged"


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
        self.status = status  # type: ignore[misc] # of each, not of the class


class InternalError(Failure):
    """A defect of the service."""

    kind, status, title = "internal", 500, "Internal error"


def not_found(what: str, id_: str) -> Failure:
    """For an id in the path that names nothing."""
    return NotFound(f"there is no {what} {id_!r}")


def wire_failure(theirs: object) -> Failure:
    """For a caller that speaks another version of the messages."""
    return WireVersionMismatch(
        f"this service speaks version {WIRE_VERSION} of the messages, the caller version {theirs}: "
        "install the client that came with the service",
    )


def of_core(error: VoaError) -> Failure:
    """The failure that an error of the mathematics is to a caller."""
    match error:
        case UnknownName():
            return UnknownReference(str(error), known=error.known[:100])
        case NoMesh():
            return MeshRequired(str(error))
        case core.BeamGridMismatch():
            return BeamGridMismatch(str(error))
        case core.RuleFault():
            structlog.get_logger().error("update_rule_failed", rule=error.name, exc_info=error)
            return RuleFailed(str(error))
        case InvalidInput():
            problem = f"expected {error.expected}, got {error.got}"
            return InvalidRequest(str(error), errors=[{"field": error.field, "problem": problem}])
        case _:
            return InvalidRequest(str(error))


def malformed(what: str, text: str, at: int) -> Failure:
    """The failure that a body is in which a JSON parser found something wrong at a character."""
    return MalformedJson(f"{json_problem(what, text, at)} at character {at}")


def of_validation(errors: Sequence[Any], kind: Any) -> Failure:
    """The failure that a message of the wrong shape is.

    Args:
        errors: as pydantic lists them; each place begins with where the message stands, "body" or "query".
        kind: the type of the message.
    """
    mistakes = [(dotted(error["loc"]), problem(kind, error | {"loc": error["loc"][1:]})) for error in by_weight(errors)]
    fields = [{"field": field, "problem": what} for field, what in mistakes[:MOST_ERRORS]]
    return InvalidRequest(headline(mistakes), errors=fields)


def of_message(kind: type[BaseModel], error: ValidationError, where: str) -> Failure:
    """The failure that a message of the wrong shape is that was read here; `where` it stands leads the fields."""
    errors = [dict(each) | {"loc": (where, *each["loc"])} for each in error.errors(include_url=False)]
    return of_validation(errors, kind)


def document(failure: Failure) -> bytes:
    """The problem document of a failure (RFC 9457), for any transport."""
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
