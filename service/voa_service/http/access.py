"""Refusal of requests that a browser sends for a web page of another site, by host name and by origin."""

import ipaddress

from voa_connections.asgi import Asgi, Receive, Scope, Send, header
from voa_service.failures import Failure, Forbidden, MisdirectedRequest
from voa_service.http.problems import problem_response

HEALTH = ("/livez", "/readyz", "/metrics")
"""Paths that are answered under any host name, since supervisors of processes call them by address."""
_READS = frozenset({"GET", "HEAD", "OPTIONS"})


class Access:
    """ASGI middleware that refuses requests under unknown host names, and requests from web pages of other sites.

    A page whose host name is made to point to 127.0.0.1 (DNS rebinding) has the service's origin for the browser, but
    `Host` still has the page's own name.

    Args:
        app: the application behind this middleware.
        names: host names under which the service may be called, besides those of loopback; None: any.
    """

    def __init__(self, app: Asgi, names: frozenset[str] | None) -> None:
        self._app = app
        self._names = names

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        refusal = self._refusal(scope) if scope["type"] == "http" else None
        await (self._app if refusal is None else problem_response(refusal))(scope, receive, send)

    def _refusal(self, scope: Scope) -> Failure | None:
        path: str = scope["path"]
        host = header(scope, b"host") or ""
        if path not in HEALTH and self._names is not None and not _is_ours(host, self._names):
            known = ", ".join(sorted(self._names | {"localhost", "127.0.0.1"}))
            return MisdirectedRequest(
                f"expected Host to be one of {known}, got {host[:80]!r}: call the service by one of these, "
                "or start it with this name in VOA_HOSTS",
            )
        is_call = scope["method"] not in _READS or path.startswith("/v1/")
        if is_call and (header(scope, b"sec-fetch-site") or "").strip().lower() == "cross-site":
            return Forbidden(
                "the request comes from a web page of another site: serve the page from the service's own origin"
            )
        return None


def name_of(host: str) -> str:
    """Return the name in a `Host` header: without the port, the brackets of IPv6 and a trailing dot."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.partition(":")[0].lower().rstrip(".")


def _is_ours(host: str, names: frozenset[str]) -> bool:
    name = name_of(host)
    return name in names or _is_loopback(name)


def _is_loopback(name: str) -> bool:
    if name in ("127.0.0.1", "localhost"):
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False
