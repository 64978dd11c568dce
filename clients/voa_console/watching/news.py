"""Callbacks of pages, called when something changed."""

import asyncio
import logging
from collections.abc import Callable

Callback = Callable[[], None]


LEAST_S = 0.1
"""Least time between two calls of `publish_soon`, seconds, so that many quick changes are drawn together."""


class News:
    """List of callbacks that are called together."""

    def __init__(self) -> None:
        self._callbacks: list[Callback] = []
        self._published_s = float("-inf")
        self._due: asyncio.TimerHandle | None = None

    def __len__(self) -> int:
        return len(self._callbacks)

    def subscribe(self, callback: Callback) -> Callback:
        """Call `callback` at each change from now on; return the function that ends that."""
        self._callbacks.append(callback)

        def unsubscribe() -> None:
            if callback in self._callbacks:
                self._callbacks.remove(callback)

        return unsubscribe

    def publish_soon(self) -> None:
        """Publish at once, or, shortly after another change, when `LEAST_S` have passed since that."""
        if self._due is not None:
            return
        loop = asyncio.get_running_loop()
        wait_s = self._published_s + LEAST_S - loop.time()
        if wait_s <= 0.0:
            self.publish()
        else:
            self._due = loop.call_later(wait_s, self.publish)

    def publish(self) -> None:
        """Call every callback; the failure of one is logged, and does not keep the others from being called."""
        if self._due is not None:
            self._due.cancel()
            self._due = None
        self._published_s = asyncio.get_running_loop().time()
        for callback in list(self._callbacks):
            try:
                callback()
            except Exception:  # a page that fails must not stop the others
                logging.getLogger("voa.console").exception("a page could not be updated")
