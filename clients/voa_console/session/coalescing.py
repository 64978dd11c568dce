"""Work that is requested more often than it can be done, such as requests for facts about a session that changes."""

from collections.abc import Awaitable, Callable

from nicegui import background_tasks

Work = Callable[[], Awaitable[None]]
"""Work, such as a request and what follows from it."""


class Coalesced:
    """Work in the background, done once for all requests that arrive while it is under way.

    Args:
        work: to do.
        name: of the task.
    """

    def __init__(self, work: Work, name: str) -> None:
        self._work = work
        self._name = name
        self._is_running = False
        self._is_requested = False

    def request(self) -> None:
        """Do the work once more, now or when it is done that is under way."""
        self._is_requested = True
        if not self._is_running:
            self._is_running = True
            background_tasks.create(self._run(), name=self._name)

    async def _run(self) -> None:
        try:
            while self._is_requested:
                self._is_requested = False
                await self._work()
        finally:
            self._is_running = False
