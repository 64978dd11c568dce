"""Admission of requests: pages, meshes and files are for browsers whose key the service accepts.

Everything needs admission but what is listed here: the page of the key itself, the health of the process, and the files
and events of NiceGUI. Events concern a page that was admitted: its identifier is a random number that only the browser
which loaded the page knows.
"""

from collections.abc import Mapping
from typing import Any

from fastapi import Request
from starlette.requests import cookie_parser
from starlette.responses import PlainTextResponse, RedirectResponse, Response

from voa_console.guard import Asgi, Receive, Scope, Send
from voa_console.keys.access import KEY_PATH, Access, Admitted

_PUBLIC = (KEY_PATH, f"{KEY_PATH}/forget", "/livez", "/favicon.ico")
_NICEGUI = ("/_nicegui/", "/_nicegui_ws/")
_NEEDED = "The service needs a key."
_FILES = ("/meshes/", "/new/files/")


class Admission:
    """ASGI middleware that admits requests, and leads others to the page on which a person gives a key.

    Args:
        app: the application behind this middleware.
        access: decides by which key a page calls the service.
    """

    def __init__(self, app: Asgi, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve an admitted request, or lead it to the page of the key."""
        if scope["type"] not in ("http", "websocket") or _is_public(scope["path"]):
            await self._app(scope, receive, send)
            return
        if scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
            return
        admitted = await self._access.admit(secret_of(scope))
        if isinstance(admitted, Admitted):
            scope.setdefault("state", {})["admitted"] = admitted
            await self._app(scope, receive, send)
        else:
            await self._refusal(scope, admitted)(scope, receive, send)

    def _refusal(self, scope: Scope, sentence: str) -> Response:
        path: str = scope["path"]
        if scope["method"] not in ("GET", "HEAD") or path.startswith(_FILES):
            return PlainTextResponse(f"{sentence or _NEEDED} Open {KEY_PATH} to enter one.", 401)
        query = scope["query_string"].decode("latin-1")
        to = f"{path}?{query}" if query else path
        return RedirectResponse(self._access.key_page(to, sentence), 303, headers={"Cache-Control": "no-store"})


def _is_public(path: str) -> bool:
    return path in _PUBLIC or path.startswith(_NICEGUI)


def admitted_of(request: Request) -> Admitted:
    """Return the admission of a request that has passed the middleware."""
    admitted = request.state.admitted
    assert isinstance(admitted, Admitted)  # noqa: S101 - set by the middleware
    return admitted


def cookie_name(scope: Mapping[str, Any]) -> str:
    """Return the name of the cookie, with the port: browsers send the cookies of a host to every port of it."""
    server = scope.get("server")
    return f"voa_console_{server[1] if server else ''}"


def secret_of(scope: Mapping[str, Any]) -> str | None:
    """Return the secret in the cookie of a request; None: there is none."""
    cookies = "; ".join(value.decode("latin-1") for name, value in scope["headers"] if name == b"cookie")
    # Other programs on the host have cookies of any form; `http.cookies` reads none of those behind an odd one.
    return cookie_parser(cookies).get(cookie_name(scope)) or None
