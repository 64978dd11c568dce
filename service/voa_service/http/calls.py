"""Strict reading of requests: only the query parameters, the type of body and the fields that a route declares."""

from collections.abc import Callable, Coroutine
from typing import Any, get_args, get_origin

from fastapi import Request, Response, params
from fastapi.routing import APIRoute
from pydantic import BaseModel
from starlette.datastructures import QueryParams

from voa_connections.asgi import Scope, header
from voa_msgs.reading import models_of
from voa_service.failures import Failure, InvalidRequest, UnsupportedMediaType
from voa_service.http.problems import RefusedBody
from voa_service.requests.bodies import Reader

_JSON, _FORM = "application/json", "multipart/form-data"
_MOST_NAMED = 20


class _MessageRequest(Request):
    """Request whose `json()` is the message itself, read in a worker thread where it is large."""

    def __init__(self, request: Request, reader: Reader, kind: type[BaseModel], keeps_body: bool, optional: bool):
        super().__init__(request.scope, request.receive)
        self._reader = reader
        self._kind = kind
        self._keeps_body = keeps_body
        self._optional = optional

    async def json(self) -> BaseModel | None:
        """Read the message; raises RefusedBody."""
        body = await self.body()
        if not self._keeps_body:
            self._body = b"{}"  # the route does not read it again, and it may be large
        if self._optional and body.strip() == b"null":
            return None
        try:
            return await self._reader.received(self._kind, body)
        except Failure as failure:
            raise RefusedBody(failure) from failure


def strict_route(reader: Reader) -> type[APIRoute]:
    """Make the class of routes that refuse unknown query parameters and bodies of another type.

    Args:
        reader: reads the messages in bodies.
    """

    class StrictRoute(APIRoute):
        """A route that refuses query parameters and body types that it does not declare."""

        def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
            """Return the handler: it checks the query and the type of the body, then reads the message in the body."""
            handle = super().get_route_handler()
            parameters = {field.alias: _is_list(field.field_info.annotation) for field in self.dependant.query_params}
            field = self.body_field
            is_form = field is not None and isinstance(field.field_info, params.Form)
            annotation = None if field is None or is_form else field.field_info.annotation
            kinds = models_of(annotation)
            keeps_body = self.dependant.request_param_name is not None
            optional = type(None) in get_args(annotation)

            async def strict(request: Request) -> Response:
                check_query(request.query_params, parameters)
                check_type(request.scope, _FORM if is_form else _JSON)
                if kinds:
                    request = _MessageRequest(request, reader, kinds[0], keeps_body, optional)
                return await handle(request)

            return strict

    return StrictRoute


def check_query(given: QueryParams, known: dict[str, bool]) -> None:
    """Refuse query parameters that the route does not have, and repeated ones.

    Args:
        given: query of the request.
        known: names of the route's parameters; True where a parameter may be repeated.

    Raises:
        Failure: a parameter is unknown, or repeated though it must not be.
    """
    names = [name for name, _ in given.multi_items()]
    wrong: dict[str, str] = {}
    for name in names:
        if name not in known:
            expected = f"expected one of {', '.join(known)}" if known else "this call takes none"
            wrong[f"query.{name[:80]}"] = f"no such parameter: {expected}"
        elif not known[name] and (times := names.count(name)) > 1:
            wrong[f"query.{name}"] = f"expected once, got {times} times"
        if len(wrong) == _MOST_NAMED:
            break
    if wrong:
        errors = [{"field": name, "problem": problem} for name, problem in wrong.items()]
        raise InvalidRequest("{field}: {problem}".format(**errors[0]), errors=errors)


def check_type(scope: Scope, expected: str) -> None:
    """Refuse a body whose declared type is not the expected one; a web page of another site could send such a body.

    Args:
        scope: of the request.
        expected: media type of the bodies that the route accepts.

    Raises:
        Failure: there is a body, and its type is missing or another one.
    """
    if header(scope, b"content-length") in (None, "0") and header(scope, b"transfer-encoding") is None:
        return
    given = header(scope, b"content-type") or ""
    if given.partition(";")[0].strip().lower() != expected:
        got = repr(given[:80]) if given else "none"
        raise UnsupportedMediaType(f"expected a body with Content-Type: {expected}, got {got}")


def _is_list(annotation: Any) -> bool:
    return get_origin(annotation) is list or any(map(_is_list, get_args(annotation)))
