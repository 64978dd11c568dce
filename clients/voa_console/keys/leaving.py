"""Departure of a page: for the page of the key, or to be drawn again because its key may do something else now."""

import asyncio

from nicegui import Client, ui

from voa_client import Caller
from voa_console.context import Console
from voa_console.keys.access import KEY_PATH
from voa_console.sentences import needs_key

_DELETE_S = 2.0
"""Time after which a page that was left is deleted here, seconds, whatever its browser does."""


class Leaving:
    """Departure of one page.

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
        """Leave if the service no longer accepts the key; load the page again if the key may do something else now."""
        hub = self._console.hub
        if needs_key(hub.error) or (hub.caller is not None and _rights(hub.caller) != _rights(self._drawn_for)):
            self._go("location.reload()")  # the page of the key receives those whose key is not accepted

    def forgotten(self) -> None:
        """Leave because the key was forgotten, on this page or another one of the browser."""
        self._go(f"location.assign('{KEY_PATH}')")

    def _go(self, script: str) -> None:
        if self._has_left or self._client.is_deleted:
            return
        self._has_left = True
        with self._client:
            ui.run_javascript(script)
        asyncio.get_running_loop().call_later(_DELETE_S, self._delete)

    def _delete(self) -> None:
        if not self._client.is_deleted:
            self._client.delete()


def _rights(caller: Caller | None) -> tuple[object, ...]:
    """Return what a page shows of a caller."""
    return () if caller is None else (caller.name, caller.key, caller.calls, caller.sessions, caller.robots)
