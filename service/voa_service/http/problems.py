"""Problem documents (RFC 9457) for every error that leaves a request."""

import structlog
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.routing import Route, compile_path

from voa_service.failures import (
    Failure,
    HttpError,
    MalformedForm,
    MalformedJson,
    MethodNotAllowed,
    NotFound,
    TooLarge,
    document,
    of_validation,
)
from voa_service.guard import EXPECTED_ERRORS, failure_of

MEDIA_TYPE = "application/problem+json"
_KINDS: dict[int, type[Failure]] = {400: MalformedJson, 404: NotFound, 405: MethodNotAllowed, 413: TooLarge}


class RefusedBody(HTTPException):
    """The failure of a request's body, as a type of error that FastAPI lets pass while it reads the body."""

    def __init__(self, failure: Failure) -> None:
        super().__init__(failure.status, failure.detail)
        self.failure = failure


def problem_response(failure: Failure) -> Response:
    """Make the response of a failure: its status, its headers and its problem document."""
    return Response(document(failure), failure.status, failure.headers, MEDIA_TYPE)


def install(app: FastAPI) -> None:
    """Answer every error of an application with a problem document."""

    async def on_expected(_: Request, error: Exception) -> Response:
        return problem_response(failure_of(error))

    async def on_invalid(request: Request, error: Exception) -> Response:
        assert isinstance(error, RequestValidationError)  # noqa: S101 - as registered
        return problem_response(_of_invalid(request, error))

    async def on_http(request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)  # noqa: S101 - as registered
        if isinstance(error, RefusedBody):
            return problem_response(error.failure)
        return problem_response(_of_http(app, request, error))

    async def on_defect(_: Request, error: Exception) -> Response:
        failure = failure_of(error)
        # This response does not pass through `RequestLog`, which adds the id to the others.
        failure.headers["X-Request-Id"] = str(structlog.contextvars.get_contextvars().get("request_id"))
        return problem_response(failure)

    for kind in EXPECTED_ERRORS:
        app.add_exception_handler(kind, on_expected)
    app.add_exception_handler(RequestValidationError, on_invalid)
    app.add_exception_handler(HTTPException, on_http)
    app.add_exception_handler(Exception, on_defect)


def _of_invalid(request: Request, error: RequestValidationError) -> Failure:
    body = getattr(request.scope.get("route"), "body_field", None)
    return of_validation(error.errors(), None if body is None else body.field_info.annotation)


def _of_http(app: FastAPI, request: Request, error: HTTPException) -> Failure:
    kind = _KINDS.get(error.status_code)
    headers = dict(error.headers or {})
    detail = str(error.detail)
    if error.status_code == 405:
        allowed = _methods(app, request)
        headers["Allow"] = ", ".join(allowed)
        detail = f"{request.url.path} supports {', '.join(allowed)}, not {request.method}"
    elif error.status_code == 400 and request.headers.get("content-type", "").startswith("multipart/"):
        kind, detail = MalformedForm, f"expected a multipart form: {detail}"
    elif error.status_code == 400:
        detail = "expected JSON in UTF-8, nested a few hundred deep at most"
    elif error.status_code == 404:
        detail = f"there is no resource at {request.url.path}: /docs describes the resources"
    return HttpError(error.status_code, detail, headers) if kind is None else kind(detail, headers)


def _methods(app: FastAPI, request: Request) -> list[str]:
    """List the methods of the request's path: those of the OpenAPI document, and of the pages that show it."""
    described = {path: {method.upper() for method in methods} for path, methods in app.openapi()["paths"].items()}
    pages = {route.path: route.methods or set() for route in app.routes if isinstance(route, Route)}
    paths = (described | pages).items()
    return sorted(set().union(*(has for path, has in paths if compile_path(path)[0].match(request.url.path))))
