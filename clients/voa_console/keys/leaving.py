"""Departure of a page whose key is forgotten, is no longer accepted, or may do something else now."""

import asyncio

from nicegui import Client, ui

from voa_client import Caller
from voa_console.context import Console
from voa_console.sentences import needs_key

_REDIRECTED_S = 1.0
"""Time in which the page that forgets a key is redirected by its form, seconds; after it, the other pages leave."""


class Leaving:
    """Departure of one page: its browser loads it again, and is admitted by another key, or led to the page of the key.

    Args:
        client: of the page.
        console: of the key by which the page calls the service.
    """

    def __init__(self, client: Client, console: Console) -> None:
        self._client = client
        self._console = console
        self._drawn_for = console.caller
        self._has_left = False

    def check(self) -> None:
        """Leave if the service no longer accepts the key, or allows the key something else than the page shows."""
        hub = self._console.hub
        if needs_key(hub.error) or (hub.caller is not None and _rights(hub.caller) != _rights(self._drawn_for)):
            self._leave(0.0)

    def forgotten(self) -> None:
        """Leave because the key was forgotten, on this page or another one of the browser."""
        self._leave(_REDIRECTED_S)

    def _leave(self, wait_s: float) -> None:
        if not self._has_left:
            self._has_left = True
            asyncio.get_running_loop().call_later(wait_s, self._reload)

    def _reload(self) -> None:
        if not self._client.is_deleted:
            with self._client:
                ui.run_javascript("location.reload()")


def _rights(caller: Caller | None) -> tuple[object, ...]:
    """Return what a page shows of a caller."""
    return () if caller is None else (caller.name, caller.key, caller.calls, caller.sessions, caller.robots)
