"""Direct calls of the operations, without FastAPI's routing and solving: the route is known after one walk of its path.

FastAPI tries the patterns of all routes in turn, and solves their parameters again for each request, which takes longer
than a small operation does itself. A request with a query, or with a header that its route refuses, goes on to FastAPI
with the body that was received; so do all requests of routes that take more than a path, headers and one JSON body.
"""

import inspect
from collections.abc import Awaitable, Callable, Iterable
from functools import partial
from typing import Any, NamedTuple, get_args

from fastapi import Response, params
from fastapi.routing import APIRoute
from pydantic import BaseModel
from starlette.exceptions import HTTPException
from starlette.requests import Request

from voa_connections.asgi import Asgi, Message, Receive, Scope, Send, header
from voa_msgs.reading import models_of
from voa_service.http.calls import check_type
from voa_service.requests.bodies import Reader

ReadBody = Callable[[bytes], Awaitable[BaseModel | None]]
"""A function that reads the message in a body; it raises `failures.Failure`."""

_JSON = "application/json"
_ANY = "/{}"
"""Stands for a parameter in a path; no segment of a path contains a slash."""
_END = "/"
"""Key of the operations of a path, by method; no segment of a path contains it."""


class Operation(NamedTuple):
    """An operation that can be called directly.

    Attributes:
        route: whose endpoint is called.
        segments: names of the parameters in the path, in its order.
        headers: names of the headers that the operation uses, with the fields of FastAPI that check them.
        read: reads the message in the body; None: there is no body.
        body: name of the parameter that takes the message; None: there is no body.
        needs_body: True if a request without a body is refused.
        request: name of the parameter that takes the request; None: there is none.
    """

    route: APIRoute
    segments: tuple[str, ...]
    headers: tuple[tuple[bytes, Any], ...]
    read: ReadBody | None
    body: str | None
    needs_body: bool
    request: str | None


class Received(Request):
    """A request whose body has been received."""

    def __init__(self, scope: Scope, receive: Receive, body: bytes) -> None:
        super().__init__(scope, receive)
        self._body = body


class Direct:
    """ASGI application that calls operations directly where it can, in front of one that serves every request.

    Args:
        app: FastAPI's router.
        routes: of the operations.
        reader: reads the messages in bodies.
    """

    def __init__(self, app: Asgi, routes: Iterable[APIRoute], reader: Reader) -> None:
        self._app = app
        self._root: dict[str, Any] = {}
        for route in routes:
            operation = _operation(route, reader)
            if operation is not None:
                node = self._root
                for segment in route.path.split("/")[1:]:
                    node = node.setdefault(_ANY if segment.startswith("{") else segment, {})
                for method in route.methods or ():
                    node.setdefault(_END, {})[method] = operation

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        matched = self.find(scope)
        if matched is None:
            await self._app(scope, receive, send)
            return
        operation, values = matched
        scope["route"] = operation.route
        scope["path_params"] = values
        check_type(scope, _JSON)
        body = b"" if operation.read is None else await _body(receive)
        arguments = await _arguments(operation, scope, body)
        if arguments is None:
            await self._app(scope, receive if operation.read is None else _replayed(body, receive), send)
            return
        if operation.request is not None:
            arguments[operation.request] = Received(scope, receive, body)
        del body  # it may be large, and the operation may take long
        response: Response = await operation.route.endpoint(**arguments)
        await response(scope, receive, send)

    def find(self, scope: Scope) -> tuple[Operation, dict[str, Any]] | None:
        """Find the operation of a request, with the parameters in its path; None: FastAPI serves the request."""
        if scope["type"] != "http" or scope["query_string"] or scope.get("root_path"):
            return None
        node, values = self._root, []
        for segment in scope["path"].split("/")[1:]:
            branch = node.get(segment)
            if branch is None:
                branch = node.get(_ANY) if segment else None
                if branch is None:
                    return None
                values.append(segment)
            node = branch
        operation: Operation | None = node.get(_END, {}).get(scope["method"])
        return None if operation is None else (operation, dict(zip(operation.segments, values, strict=True)))


async def _arguments(operation: Operation, scope: Scope, body: bytes) -> dict[str, Any] | None:
    """Return the arguments of an operation but for the request itself; None: FastAPI must say what is wrong with them.

    Raises:
        Failure: the body is not a message that the operation takes.
    """
    arguments = dict(scope["path_params"])
    if operation.needs_body and not body:
        return None
    if body and operation.read is not None and operation.body is not None:
        arguments[operation.body] = await operation.read(body)
    for name, field in operation.headers:
        given = header(scope, name)
        if given is not None:
            arguments[field.name], errors = field.validate(given, {}, loc=("header", field.alias))
            if errors:
                return None
    return arguments


def _operation(route: APIRoute, reader: Reader) -> Operation | None:
    """Return the operation of a route, or None where FastAPI must call it."""
    needs = route.dependant
    endpoint = route.endpoint
    has_more = needs.dependencies or needs.cookie_params or needs.background_tasks_param_name
    is_async = inspect.iscoroutinefunction(endpoint) and inspect.signature(endpoint).return_annotation is Response
    plain = all(_is_text(field) for field in needs.path_params)
    optional = not any(field.field_info.is_required() for field in (*needs.query_params, *needs.header_params))
    if has_more or not (is_async and plain and optional):
        return None
    read, name, needs_body = None, None, False
    if route.body_field is not None:
        info = route.body_field.field_info
        kinds = models_of(info.annotation)
        if isinstance(info, params.Form) or not kinds:
            return None
        needs_body = type(None) not in get_args(info.annotation)
        read, name = partial(_read, reader, kinds[0], needs_body), needs.body_params[0].name
    headers = tuple((field.alias.lower().encode(), field) for field in needs.header_params)
    segments = tuple(each[1:-1] for each in route.path.split("/") if each.startswith("{"))
    return Operation(route, segments, headers, read, name, needs_body, needs.request_param_name)


async def _read(reader: Reader, kind: type[BaseModel], needed: bool, body: bytes) -> BaseModel | None:
    """Read the message in a body; `null` is none where no message is needed. Raises Failure."""
    if not needed and body.strip() == b"null":
        return None
    return await reader.received(kind, body)


def _is_text(field: Any) -> bool:
    return field.field_info.annotation is str and not field.field_info.metadata


async def _body(receive: Receive) -> bytes:
    """Receive the body of a request; raises HTTPException."""
    parts = []
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise HTTPException(400, "the client has gone before the body ended")
        parts.append(message.get("body", b""))
        if not message.get("more_body", False):
            return parts[0] if len(parts) == 1 else b"".join(parts)


def _replayed(body: bytes, receive: Receive) -> Callable[[], Awaitable[Message]]:
    """Make a function that first gives a body that was received, then what arrives after it."""
    has_given = False

    async def replayed() -> Message:
        nonlocal has_given
        if has_given:
            return await receive()
        has_given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return replayed
