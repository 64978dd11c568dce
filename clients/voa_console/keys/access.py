"""Access to the pages: by which key the page of a browser calls the service, if by any."""

import asyncio
import re
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from urllib.parse import quote

from voa_client import DeniedError, TimedOutError, UnavailableError, UnreachableError, VoaClientError
from voa_console.context import Console
from voa_console.keys.consoles import Connect, Consoles
from voa_console.keys.notices import Notices
from voa_console.keys.visits import Leave, Visits
from voa_console.sentences import sentence_of
from voa_console.settings import ConsoleSettings

KEY_PATH = "/key"
"""Path of the page on which a person gives a key, and of the form that sends it."""
_OWN_PAGES = re.compile(r"/(new(\?of=[0-9a-f]+)?|robots|sessions/[A-Za-z0-9_.-]+)?")
_IDENTIFY_S = 4.0
"""Time for which a page waits for the service to identify its caller, seconds."""
_FRESH_S = 2.0
"""Time for which an identified caller is not identified again for another request, seconds."""
_SWEEP_S = 600.0
"""Interval at which visits end that were not used for a long time, seconds."""
_LEAVE_S = 10.0
"""Longest time in which the pages of a key that was forgotten leave, seconds."""


@dataclass(frozen=True)
class Admitted:
    """Request that was admitted: its page calls the service by the key of a console.

    Attributes:
        console: of the key.
        is_own: True if it is the console of the process's own key, or the service has no keys.
        open_page: counts a page as open, with a function that is called when the browser's key is forgotten; returns
            the function that counts it as closed.
    """

    console: Console
    is_own: bool
    open_page: Callable[[Leave], Callable[[], None]]


class Access:
    """Access of browsers to the pages of a console.

    Args:
        settings: of the console.
        connect: makes a client of the service.
        clock: returns seconds that never go back.
        identify_s: time for which a page waits for the service to identify its caller, seconds.
    """

    def __init__(
        self,
        settings: ConsoleSettings,
        connect: Connect,
        clock: Callable[[], float] = time.monotonic,
        identify_s: float = _IDENTIFY_S,
    ) -> None:
        self.settings = settings
        self.consoles = Consoles(settings, connect, clock)
        self.notices = Notices()
        self._visits = Visits(self._close_unused, clock)
        self._clock = clock
        self._identify_s = identify_s
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self) -> None:
        """Let the hub of the own console watch, and idle visits end, from now on."""
        self.consoles.start()
        self._tasks.add(asyncio.create_task(self._end_idle(), name="voa-console-visits"))

    async def admit(self, secret: str | None) -> Admitted | str:
        """Return by which key the pages of a browser call the service, or why by none.

        The reason is a sentence, or "" for a browser that has given no key.

        A browser is admitted only once the service has accepted its key, or is known to have no keys. While it does not
        respond, a browser that was admitted before is admitted again, and sees the last state.

        Args:
            secret: of the browser's cookie; None: it has none.
        """
        visit = self._visits.get(secret)
        if visit is not None and secret is not None:
            refusal = await self._refusal(visit.console)
            if refusal is not None:
                if visit.console.caller is None:  # else the service did not say that the key is not valid
                    self.leave(secret)
                return refusal
            if self._visits.get(secret) is visit:  # it may have ended in the meantime
                return Admitted(visit.console, False, lambda leave: self._visits.open_page(visit, leave))
        refusal = await self._refusal(self.consoles.own)
        return Admitted(self.consoles.own, True, lambda _: lambda: None) if refusal is None else refusal

    async def enter(self, key: str, before: str | None) -> str | None:
        """Begin the visit of a browser that has given a key; return the secret of its cookie.

        None is returned where the service has no keys, so that none is needed.

        Args:
            key: text of the key.
            before: secret of the browser's last visit, which ends; None: there was none.

        Raises:
            UsageError: the text cannot be that of a key.
            VoaClientError: the service does not accept the key, or does not respond.
        """
        console = await self.consoles.open(key)
        secret = None if console is self.consoles.own else self._visits.begin(console)
        if before is not None:
            self.leave(before)
        return secret

    def leave(self, secret: str) -> None:
        """End the visit of a browser; its pages leave, and its key is forgotten if no other browser has given it."""
        self._visits.end(secret)

    def key_page(self, to: str, sentence: str = "") -> str:
        """Return the address of the page on which a person gives a key.

        Args:
            to: path of the page to which it leads.
            sentence: that it shows; "": none.
        """
        notice = f"&notice={self.notices.put(sentence)}" if sentence else ""
        return f"{KEY_PATH}?to={quote(own_page(to), safe='')}{notice}"

    async def close(self) -> None:
        """Close every console."""
        for task in self._tasks:
            task.cancel()
        await self.consoles.close_all()

    def _close_unused(self, console: Console) -> None:
        """Close the console of a key that no browser uses any more, once its pages have left."""
        task = asyncio.create_task(self._close_soon(console), name="voa-console-close")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _end_idle(self) -> None:
        while True:
            await asyncio.sleep(_SWEEP_S)
            self._visits.end_idle()

    async def _close_soon(self, console: Console) -> None:
        with suppress(TimeoutError):
            async with asyncio.timeout(_LEAVE_S):
                await console.hub.has_no_pages()
        if not self._visits.is_visited(console):  # a browser may have given the key again
            await self.consoles.close(console)

    async def _refusal(self, console: Console) -> str | None:
        """Identify the caller of a console; return None if the service accepts it, else a sentence, as `admit` does."""
        hub = console.hub
        if hub.caller is not None and self._clock() - hub.identified_s < _FRESH_S:
            return None
        try:
            async with asyncio.timeout(self._identify_s):
                await hub.identify()
        except VoaClientError as error:
            return _refusal_after(console, error)
        except TimeoutError:
            late = TimedOutError("the service did not identify the caller in time")
            hub.error = hub.error or late  # what the page of the key shows
            return _refusal_after(console, late)
        return None


def _refusal_after(console: Console, error: VoaClientError) -> str | None:
    """Return None if a failed identification leaves the last one in force, else a sentence, as `admit` does."""
    caller = console.caller
    if caller is not None and (caller.key is None or isinstance(error, UnreachableError | UnavailableError)):
        return None
    is_only_without_key = isinstance(error, DeniedError) and error.kind == "unauthenticated" and console.key is None
    return "" if is_only_without_key else sentence_of(error)


def own_page(to: str) -> str:
    """Return a path if it is that of a page of the console, else that of the page Now."""
    return to if _OWN_PAGES.fullmatch(to) else "/"
