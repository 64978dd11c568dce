"""The OpenAPI document, made true: problem documents are what errors are, and limits stand in the schemas."""

from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from voa_msgs.problems import Problem
from voa_service.http.problems import MEDIA_TYPE
from voa_service.settings import Limits

_TITLES = {
    400: "The body is not JSON",
    403: "The call comes from a page of another site",
    404: "There is no such thing",
    409: "It contradicts what is there",
    412: "The session has moved on",
    413: "More than this service takes at once",
    415: "Not a type of body, or of mesh, that this call takes",
    421: "The service does not go by that name",
    422: "The request is not as expected",
    503: "Too much to do at the moment, or not able to work",
}

_WORDS = {"integer": "maximum", "array": "maxItems", "object": "maxProperties"}
_ANY_CALL = (403, 415, 421, 422)
"""From a page of another site; with a body of another type; under another name; with parameters that it has not."""


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """`responses=` of a route that may answer with these problems."""
    return {status: {"description": _TITLES[status], "model": Problem} for status in statuses}


def install(app: FastAPI, limits: Limits) -> None:
    """Have `app` describe itself with its limits."""

    def describe() -> dict[str, Any]:
        if app.openapi_schema is None:
            document = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
            for path, operations in document["paths"].items():
                for operation in operations.values():
                    if path.startswith("/v1/"):
                        _add_problems(operation["responses"])
                    _mark_problems(operation["responses"])
            schemas = document["components"]["schemas"]
            for unused in ("HTTPValidationError", "ValidationError"):
                schemas.pop(unused, None)
            _state_limits(schemas, limits)
            app.openapi_schema = document
        return app.openapi_schema

    app.openapi = describe  # type: ignore[method-assign] # FastAPI's documented way to extend the document


def _add_problems(responses: dict[str, Any]) -> None:
    """Add what every call may be answered, whatever it does, after the problems of its own."""
    schema = {"$ref": f"#/components/schemas/{Problem.__name__}"}
    for status in _ANY_CALL:
        answer = {"description": _TITLES[status], "content": {"application/json": {"schema": schema}}}
        responses.setdefault(str(status), answer)


def _mark_problems(responses: dict[str, Any]) -> None:
    for status, response in responses.items():
        content = response.get("content", {})
        if status >= "400" and "application/json" in content:
            content[MEDIA_TYPE] = content.pop("application/json")


def _state_limits(node: Any, limits: Limits) -> None:
    if isinstance(node, dict):
        name = node.pop("x-limit", None)
        if name is not None:
            node[_WORDS[node["type"]]] = getattr(limits, name)
        for child in node.values():
            _state_limits(child, limits)
    elif isinstance(node, list):
        for child in node:
            _state_limits(child, limits)
