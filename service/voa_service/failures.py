"""What can go wrong, as a caller sees it: one table from errors to kinds and statuses, for every entrypoint."""

import json
from collections.abc import Sequence
from typing import Any

import structlog
from pydantic import BaseModel, ValidationError

from voa_core.errors import BeamGridMismatch, InvalidInput, NoMesh, UnknownName, VoaError
from voa_msgs import WIRE_VERSION
from voa_msgs.bounds import MOST_ERRORS
from voa_msgs.reading import by_weight, dotted, headline, json_problem, problem

MALFORMED = ("malformed-json", 400, "The body is not JSON")
MALFORMED_FORM = ("malformed-form", 400, "The body is not a multipart form")
FORBIDDEN = ("forbidden", 403, "This call is not allowed")
NOT_FOUND = ("not-found", 404, "There is no such thing")
METHOD_NOT_ALLOWED = ("method-not-allowed", 405, "This path does not have that method")
CLAIM_CONFLICT = ("claim-conflict", 409, "The robot's mapping does not allow that")
STALE = ("stale-version", 412, "The session has moved on")
TOO_LARGE = ("too-large", 413, "More than this service takes at once")
MESH_TYPE = ("unsupported-mesh-type", 415, "Not a mesh type that this service reads")
MEDIA_TYPE = ("unsupported-media-type", 415, "Not a type of body that this call takes")
MISDIRECTED = ("misdirected-request", 421, "This service does not go by that name")
INVALID = ("invalid-request", 422, "The request is not as expected")
UNKNOWN = ("unknown-name", 422, "The request names something that does not exist")
NO_MESH = ("no-mesh", 422, "A prediction is needed and nothing can make it")
GRID_MISMATCH = ("beam-grid-mismatch", 422, "The scan's beams are not those that are expected")
INVALID_MESH = ("invalid-mesh", 422, "The file is not a usable mesh")
LOOK_COUNTED = ("look-counted", 409, "The session has this look already")
NOT_ACCEPTED = ("not-accepted", 422, "The look was not accepted")
KEY_REUSED = ("idempotency-key-reused", 422, "This Idempotency-Key came with another request before")
SPEAKS_OTHERWISE = ("wire-version", 400, "The caller speaks another version of the messages")
OVERLOADED = ("overloaded", 503, "Too much to do at the moment")
NOT_READY = ("not-ready", 503, "The service cannot work at the moment")
DAMAGED = ("damaged", 500, "What is stored is not as it was written")
INTERNAL = ("internal", 500, "The service failed")

Kind = tuple[str, int, str]


class Failure(Exception):
    """A request that cannot be answered, with what a caller should know."""

    def __init__(self, kind: Kind, detail: str, headers: dict[str, str] | None = None, **more: Any) -> None:
        super().__init__(detail)
        self.kind, self.status, self.title = kind
        self.detail = detail
        self.headers = headers or {}
        self.more = more


def not_found(what: str, id_: str) -> Failure:
    """For an id in the path that names nothing."""
    return Failure(NOT_FOUND, f"there is no {what} {id_!r}")


def wire_failure(theirs: object) -> Failure:
    """For a caller that speaks another version of the messages."""
    return Failure(
        SPEAKS_OTHERWISE,
        f"this service speaks version {WIRE_VERSION} of the messages, the caller version {theirs}: "
        "install the client that came with the service",
    )


def of_core(error: VoaError) -> Failure:
    """The failure that an error of the mathematics is to a caller."""
    match error:
        case UnknownName():
            return Failure(UNKNOWN, str(error), known=error.known[:100])
        case NoMesh():
            return Failure(NO_MESH, str(error))
        case BeamGridMismatch():
            return Failure(GRID_MISMATCH, str(error))
        case InvalidInput():
            problem = f"expected {error.expected}, got {error.got}"
            return Failure(INVALID, str(error), errors=[{"field": error.field, "problem": problem}])
        case _:
            return Failure(INVALID, str(error))


def malformed(what: str, text: str, at: int) -> Failure:
    """The failure that a body is in which a JSON parser found something wrong at a character."""
    return Failure(MALFORMED, f"{json_problem(what, text, at)} at character {at}")


def of_validation(errors: Sequence[Any], kind: Any) -> Failure:
    """The failure that a message of the wrong shape is.

    Args:
        errors: as pydantic lists them; each place begins with where the message stands, "body" or "query".
        kind: the type of the message.
    """
    mistakes = [(dotted(error["loc"]), problem(kind, error | {"loc": error["loc"][1:]})) for error in by_weight(errors)]
    fields = [{"field": field, "problem": what} for field, what in mistakes[:MOST_ERRORS]]
    return Failure(INVALID, headline(mistakes), errors=fields)


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
