"""Admits requests by their keys, from their headers alone: nobody uploads a mesh to be refused afterwards.

Writes are recorded in the audit when their response begins.
"""

from typing import Any

import structlog
from starlette.datastructures import Headers
from starlette.requests import HTTPConnection

from voa_connections.asgi import Asgi, Message, Receive, Scope, Send, header
from voa_service.access.audit import is_recorded, record_write
from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.access.gate import Gate
from voa_service.access.roles import CALLS
from voa_service.access.routing import Matched, Routes
from voa_service.failures import Failure, NotFound, TooManyWithoutKey
from voa_service.http.headers import created_id, version_of
from voa_service.http.problems import problem_response
from voa_service.services import Services
from voa_store.records import IdempotencyKey

_CALLER = "voa.caller"


class Authentication:
    """ASGI middleware that refuses requests without a valid key, or with a key whose role may not make them.

    Args:
        app: the application behind this middleware.
        gate: identifies callers, and admits their calls.
    """

    def __init__(self, app: Asgi, gate: Gate) -> None:
        self._app = app
        self._gate = gate
        self._routes = Routes(CALLS)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        matched = self._routes.match(scope["method"], scope["path"])
        caller: Caller | None = None
        try:
            caller = self._gate.identify(key_of(header(scope, b"authorization")), matched.call, origin_of(scope))
            if caller.key is not None:
                structlog.contextvars.bind_contextvars(caller=caller.name)
            self._gate.admit(caller, matched.call, matched.subject)
            if not scope["path"].isprintable():  # the routes' patterns would ignore a newline at the end
                raise NotFound("there is no such path: it has a control character")
        except Failure as failure:
            if matched.call.writes and not isinstance(failure, TooManyWithoutKey):
                _record(caller, matched, failure.status, [])
            await problem_response(failure)(scope, receive, send)
            return
        scope[_CALLER] = caller
        if not matched.call.writes:
            await self._app(scope, receive, send)
            return

        async def send_recorded(message: Message) -> None:
            if message["type"] == "http.response.start":
                _record(caller, matched, message["status"], message.get("headers", []))
            await send(message)

        await self._app(scope, receive, send_recorded)


def key_of(given: str | None) -> str | None:
    """Return the key in a header `Authorization`; None: there is no such header, "": it has another form."""
    if given is None:
        return None
    scheme, _, key = given.partition(" ")
    return key.strip() if scheme.lower() == "bearer" else ""


def origin_of(scope: Scope) -> str:
    """Return the address that a request comes from, as the server or a trusted proxy states it."""
    client = scope.get("client")
    return str(client[0]) if client else "an unknown address"


def caller_of(request: HTTPConnection) -> Caller:
    """Return the caller of a request that was admitted."""
    caller: Any = request.scope.get(_CALLER, ANONYMOUS)
    return caller if isinstance(caller, Caller) else ANONYMOUS


def check_acting(
    request: HTTPConnection, services: Services, session: str, key: IdempotencyKey | None, robot: str | None = None
) -> None:
    """Return if the API key of a request may change a session, or the request repeats one that was answered.

    Reads the store where the API key is bound to robots: call it in a worker thread.

    Args:
        request: that was admitted.
        services: the use cases.
        session: id of the session.
        key: idempotency key of the request, if it has one.
        robot: name of the robot that the request names; None: it names none.

    Raises:
        Forbidden: the key is bound to other robots, or to robots that have nothing to do with the session.
    """
    caller, acting = caller_of(request), services.acting
    if caller.robots is not None and not acting.is_answered(key):
        caller.check_acting(session, robot, acting)


def _record(caller: Caller | None, matched: Matched, status: int, raw: list[tuple[bytes, bytes]]) -> None:
    """Record a write in the audit, by the headers of its response; they are not read where nothing is recorded."""
    if not is_recorded():
        return
    call, headers = matched.call, Headers(raw=raw)
    session = created_id(headers) if call.on == "sessions" else matched.subject if call.on == "session" else None
    robot = matched.subject if call.on == "robot" else None
    record_write(caller, call.name, status, session=session, robot=robot, version=version_of(headers))
