"""OpenAPI document: summaries, tags, the problems of each operation by status, and the limits of the service."""

from collections.abc import Callable, Iterable
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from voa_service.access.roles import CALLS, ROLES, Call
from voa_service.access.routing import Routes
from voa_service.failures import (
    Failure,
    Forbidden,
    InvalidRequest,
    MalformedForm,
    MalformedJson,
    MisdirectedRequest,
    NotReady,
    Overloaded,
    TooLarge,
    TooManyRequests,
    TooManyWithoutKey,
    Unauthenticated,
    UnsupportedMediaType,
    WireVersionMismatch,
)
from voa_service.http.problems import MEDIA_TYPE
from voa_service.problem_schemas import problem_schema
from voa_service.settings import Limits

TAGS = [
    {"name": "objects", "description": "Upload and list the meshes of objects, and compute how they rest on a table."},
    {
        "name": "scenarios",
        "description": "Store and check scenarios (object, poses, grasps, scores, lidar, sensor configurations, update "
        "rule and prior), predict scans, and list the known lidars.",
    },
    {
        "name": "sessions",
        "description": "Open sessions, update their beliefs by scans and grasp outcomes, and read or follow them.",
    },
    {"name": "rankings", "description": "Rank the looks and the grasps of a session by their value under its belief."},
    {
        "name": "stateless",
        "description": "Update a belief and rank looks with the belief in the request, so that nothing is stored.",
    },
    {"name": "robots", "description": "List the robots that send scans, request looks, and claim robots for sessions."},
    {"name": "caller", "description": "Read who the caller is by its key, and what it may do."},
    {"name": "health", "description": "Probe whether a process is alive and ready, and read its metrics."},
]
"""Tags of the operations, in the order of the document; each operation has exactly one."""

_KINDS: dict[str, type[Failure]] = {kind.kind: kind for kind in Failure.__subclasses__()}
_WORDS = {"integer": "maximum", "array": "maxItems", "object": "maxProperties"}
_PROBLEMS = "x-problems"
_SCHEME = "key"
_KEY = {
    "type": "http",
    "scheme": "bearer",
    "description": "API key, which `voa keys create` makes. Without any key, the service answers everybody; once the "
    "first key was made, it needs one for every call but those about health. `x-roles` lists the roles of each call.",
}
_OF_KEYS: tuple[type[Failure], ...] = (Unauthenticated, Forbidden, TooManyRequests, TooManyWithoutKey)
_ANY_CALL: tuple[type[Failure], ...] = (
    WireVersionMismatch,
    Forbidden,
    UnsupportedMediaType,
    MisdirectedRequest,
    InvalidRequest,
    Overloaded,
    NotReady,
)
_WITH_BODY: dict[str, tuple[type[Failure], ...]] = {
    "application/json": (MalformedJson, TooLarge),
    "multipart/form-data": (MalformedForm, TooLarge),
}


def problems(*kinds: type[Failure]) -> dict[int | str, dict[str, Any]]:
    """Describe the problems that are particular to a route, as its `responses`.

    The problems that every call, or every call with a body, may have are added to the document for all routes.

    Args:
        kinds: failures with which the route may respond.

    Returns:
        Responses of FastAPI by status.
    """
    responses: dict[int | str, dict[str, Any]] = {}
    for kind in kinds:
        response = responses.setdefault(kind.status, {"description": "", _PROBLEMS: []})
        response[_PROBLEMS].append(kind.kind)
    return responses


def install(app: FastAPI, limits: Limits, needs_key: Callable[[], bool]) -> None:
    """Make `app` describe itself with its limits and problems.

    Args:
        app: to describe.
        limits: of requests.
        needs_key: returns True once the service refuses callers without a key.
    """
    documents: dict[bool, dict[str, Any]] = {}

    def describe() -> dict[str, Any]:
        closed = needs_key()
        if closed not in documents:
            documents[closed] = _document(app, limits, closed=closed)
        return documents[closed]

    app.openapi = describe  # type: ignore[method-assign] # FastAPI's documented way to extend the document


def _document(app: FastAPI, limits: Limits, *, closed: bool) -> dict[str, Any]:
    document = get_openapi(
        title=app.title, version=app.version, description=app.description, routes=app.routes, tags=TAGS
    )
    schemas, table = document["components"]["schemas"], Routes(CALLS)
    document["components"]["securitySchemes"] = {_SCHEME: _KEY}
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            _summarise(operation)
            _add_security(operation, table.match(method.upper(), path).call, closed=closed)
            if path.startswith("/v1/"):
                _add_problems(operation["responses"], _of_any_call(operation))
            _describe_problems(operation["responses"], schemas)
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    _state_limits(schemas, limits)
    return document


def _add_security(operation: dict[str, Any], call: Call, *, closed: bool) -> None:
    """State whether an operation needs a key, and the roles that may call it."""
    if call.public:
        return
    operation["security"] = [{_SCHEME: []}] if closed else [{}, {_SCHEME: []}]
    operation["x-roles"] = [role for role in ROLES if role in call.roles]
    _add_problems(operation["responses"], _OF_KEYS)


def _summarise(operation: dict[str, Any]) -> None:
    """Split the docstring of a route: its first sentence is the summary, the rest the description."""
    summary, _, rest = operation.pop("description").partition("\n\n")
    operation["summary"] = " ".join(summary.split()).removesuffix(".")
    if rest:
        operation["description"] = rest


def _of_any_call(operation: dict[str, Any]) -> Iterable[type[Failure]]:
    """List the failures of every call, and those of every call with such a body."""
    for media_type in operation.get("requestBody", {}).get("content", {}):
        yield from _WITH_BODY[media_type]
    yield from _ANY_CALL


def _add_problems(responses: dict[str, Any], kinds: Iterable[type[Failure]]) -> None:
    """Add failures after those that the route names itself; FastAPI's own response for 422 is replaced."""
    for kind in kinds:
        response = responses.setdefault(str(kind.status), {})
        entries = response.setdefault(_PROBLEMS, [])
        if kind.kind not in entries:
            entries.append(kind.kind)


def _describe_problems(responses: dict[str, Any], schemas: dict[str, Any]) -> None:
    """Replace the marks of problems by descriptions; the schema of each kind goes into the document's `schemas`."""
    for status in [status for status, response in responses.items() if _PROBLEMS in response]:
        kinds = [_KINDS[kind] for kind in responses[status][_PROBLEMS]]
        schemas |= {_schema_name(kind): problem_schema(kind) for kind in kinds}
        references = [{"$ref": f"#/components/schemas/{_schema_name(kind)}"} for kind in kinds]
        responses[status] = {
            "description": "; ".join(f"{kind.title} (`{kind.kind}`)" for kind in kinds),
            "content": {MEDIA_TYPE: {"schema": references[0] if len(references) == 1 else {"oneOf": references}}},
        }


def _schema_name(kind: type[Failure]) -> str:
    return f"{kind.__name__}Problem"


def _state_limits(node: Any, limits: Limits) -> None:
    """Replace the name of each limit in the schemas by its number."""
    if isinstance(node, dict):
        name = node.pop("x-limit", None)
        if name is not None:
            word, limit = _WORDS[node["type"]], getattr(limits, name)
            node[word] = min(limit, node.get(word, limit))  # the message's own limit may be smaller
        for child in node.values():
            _state_limits(child, limits)
    elif isinstance(node, list):
        for child in node:
            _state_limits(child, limits)
