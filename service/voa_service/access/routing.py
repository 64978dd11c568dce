"""Finds the call of an HTTP request by its method and path, before the web framework sees the request."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from voa_service.access.roles import UNLISTED, Call

_ANY = "/{}"
"""Stands for a parameter in a path; no segment of a path contains a slash."""
_END = "/"
"""Key of the calls of a path, by method; no segment of a path contains it."""


class Matched(NamedTuple):
    """A call, with the part of the path that says what it concerns."""

    call: Call
    subject: str | None


class Routes:
    """The table of calls as a tree of the segments of paths.

    Args:
        calls: the table.
    """

    def __init__(self, calls: Iterable[Call]) -> None:
        self._root: dict[str, Any] = {}
        for call in calls:
            for route in call.routes:
                method, _, path = route.partition(" ")
                node = self._root
                for segment in path.split("/")[1:]:
                    node = node.setdefault(_ANY if segment.startswith("{") else segment, {})
                node.setdefault(_END, {})[method] = call

    def match(self, method: str, path: str) -> Matched:
        """Find the call of a request; `UNLISTED` where the table has none.

        Args:
            method: of the request; HEAD counts as GET.
            path: of the request, decoded.
        """
        node, subject = self._root, None
        for segment in path.split("/")[1:]:
            branch = node.get(segment)
            if branch is None:
                branch = node.get(_ANY) if segment else None
                if branch is None:
                    return Matched(UNLISTED, None)
                subject = segment if subject is None else subject
            node = branch
        call = node.get(_END, {}).get("GET" if method == "HEAD" else method, UNLISTED)
        return Matched(call, subject)
