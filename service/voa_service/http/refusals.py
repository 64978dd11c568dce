"""Problem documents of connections and requests that are refused below the application."""

import secrets

import structlog

from voa_connections.refusals import Refusal
from voa_connections.responses import RefusalResponse
from voa_msgs import WIRE_VERSION
from voa_service.failures import (
    Failure,
    HeadersTooLarge,
    MalformedRequest,
    NotReady,
    Overloaded,
    RequestTimeout,
    document,
)
from voa_service.http.problems import MEDIA_TYPE

_FAILURES: dict[str, type[Failure]] = {
    kind.kind: kind for kind in (MalformedRequest, RequestTimeout, HeadersTooLarge, Overloaded, NotReady)
}


def refusal_response(refusal: Refusal) -> RefusalResponse:
    """Make the response of a refusal: a problem document with a request id of its own.

    Raises:
        ValueError: the refusal has no response.
    """
    if refusal.answer is None:
        raise ValueError(f"{refusal.reason}: expected a refusal with a response")
    failure = _FAILURES[refusal.answer](refusal.detail, dict(refusal.headers))
    known = structlog.contextvars.get_contextvars().get("request_id")
    request_id = secrets.token_hex(8) if known is None else str(known)
    with structlog.contextvars.bound_contextvars(request_id=request_id):
        body = document(failure)
    headers = {"Content-Type": MEDIA_TYPE, "X-Request-Id": request_id, "Voa-Wire-Version": str(WIRE_VERSION)}
    return RefusalResponse(failure.status, headers | failure.headers, body)
