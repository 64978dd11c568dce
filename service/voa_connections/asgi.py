"""The types of ASGI, and the headers of its requests and responses."""

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

Message = MutableMapping[str, Any]
Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Asgi = Callable[[Scope, Receive, Send], Awaitable[None]]


def header(scope: Scope, name: bytes) -> str | None:
    """Return the first header of a request with a name, in lower case; None: there is none."""
    for given, value in scope["headers"]:
        if given == name:
            return str(value, "latin-1")
    return None


def set_header(message: Message, name: bytes, value: bytes) -> None:
    """Set a header of a response that begins, in place of those with its name, in lower case."""
    message["headers"] = [(given, kept) for given, kept in message.get("headers", ()) if given != name]
    message["headers"].append((name, value))
