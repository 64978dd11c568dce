"""Refusal of connections that a browser opens for a web page of another site.

Events of a page arrive over a WebSocket, which browsers let any site open; only its `Origin` shows where it comes from.
Host names are checked before, so that an origin which equals the host is the console's own.
"""

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Asgi = Callable[[Scope, Receive, Send], Awaitable[None]]

_REFUSAL = b"the request comes from a web page of another site: open the console at its own address"


class SameOrigin:
    """ASGI middleware that refuses requests and WebSockets whose `Origin` is another host than the console's.

    Args:
        app: the application behind this middleware.
    """

    def __init__(self, app: Asgi) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request, or refuse it with status 403."""
        if scope["type"] not in ("http", "websocket") or is_same_origin(dict(scope["headers"])):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": "the page is of another site"})
        else:
            headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", b"%d" % len(_REFUSAL))]
            await send({"type": "http.response.start", "status": 403, "headers": headers})
            await send({"type": "http.response.body", "body": _REFUSAL})


def is_same_origin(headers: dict[bytes, bytes]) -> bool:
    """True if a request with these headers does not come from a page of another host.

    Args:
        headers: of the request, with names in lower case.
    """
    if headers.get(b"sec-fetch-site", b"").strip().lower() == b"cross-site" and b"origin" in headers:
        return False
    origin = headers.get(b"origin")
    if origin is None:
        return True
    return urlsplit(origin.decode("latin-1")).netloc.lower() == headers.get(b"host", b"").decode("latin-1").lower()
