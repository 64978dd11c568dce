"""Consoles of a process: the one of its own key, and one for each key that browsers have given."""

import asyncio
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress

from voa_client import AsyncClient
from voa_console.context import Console
from voa_console.settings import ConsoleSettings
from voa_console.watching.hub import Hub

Connect = Callable[[str | None], AsyncClient]
"""Function that makes a client with a key; None: with the key of the process, if it has one."""

Closing = Callable[[Console], Awaitable[None]]
"""Function that ends what was done with the key of a console."""


class Consoles:
    """Consoles by key. Each has a client and a hub of its own, so that no page shows what its key may not see.

    Args:
        settings: of this console.
        connect: makes a client.
        clock: returns seconds that never go back.
    """

    def __init__(
        self, settings: ConsoleSettings, connect: Connect, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._settings = settings
        self._connect = connect
        self._clock = clock
        self._watching: dict[Console, asyncio.Task[None]] = {}
        self._of_keys: dict[str, Console] = {}
        self._closing: list[Closing] = []
        self.own = self._make(None)
        """Console of the key of this process, or of callers without a key."""

    def start(self) -> None:
        """Let the hub of the own console watch from now on."""
        self._watch(self.own)

    async def open(self, key: str) -> Console:
        """Return the console of a key, once the service has accepted the key.

        It is the own one where the service has no keys.

        Args:
            key: text of the key.

        Raises:
            UsageError: the text cannot be that of a key.
            VoaClientError: the service does not accept the key, or does not respond.
        """
        console = self._make(key)
        try:
            caller = await console.hub.identify()
        except BaseException:
            await console.client.close()
            raise
        if caller.key is None:
            await console.client.close()
            return self.own
        if caller.key in self._of_keys:
            await console.client.close()
            known = self._of_keys.get(caller.key)  # the last visit of the key may have ended while the client closed
            return await self.open(key) if known is None else known
        self._of_keys[caller.key] = console
        self._watch(console)
        return console

    def on_close(self, closing: Closing) -> None:
        """Call a function with each console that is closed, before its client is."""
        self._closing.append(closing)

    async def close(self, console: Console) -> None:
        """Close a console; that of a key is opened again when a browser gives the key again."""
        for key, each in list(self._of_keys.items()):
            if each is console:
                del self._of_keys[key]
        for closing in self._closing:
            await closing(console)
        watching = self._watching.pop(console, None)
        if watching is not None:
            watching.cancel()
            with suppress(asyncio.CancelledError):
                await watching
        await console.client.close()

    async def close_all(self) -> None:
        """Close every console."""
        for console in [*self._of_keys.values(), self.own]:
            await self.close(console)

    def _make(self, key: str | None) -> Console:
        client = self._connect(key)
        return Console(self._settings, client, Hub(client, self._settings.recent_s, clock=self._clock), key)

    def _watch(self, console: Console) -> None:
        self._watching[console] = asyncio.create_task(console.hub.run(), name="voa-console-hub")
