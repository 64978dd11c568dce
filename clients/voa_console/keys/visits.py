"""Visits: browsers that have given a key, recognised by a secret in a cookie; kept in memory alone."""

import hashlib
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from voa_console.context import Console

IDLE_S = 12.0 * 3600.0
"""Time after which a visit ends that has no open page, seconds."""
MOST = 1000
"""Most visits; beyond them, one without an open page ends, of those the one that was not used for the longest time."""
MOST_OF_KEY = 50
"""Most visits of a key; beyond them, another one of that key ends, so that nobody logs out those with other keys."""
Leave = Callable[[], None]
"""Function of an open page that is called when its visit ends."""


@dataclass(eq=False)
class Visit:
    """Browser that has given a key.

    Attributes:
        console: of the key.
        used_s: time of its last request, or at which its last page was closed, by the clock of the visits.
        pages: open pages of the browser.
    """

    console: Console
    used_s: float
    pages: list[Leave] = field(default_factory=list)


class Visits:
    """Visits by the secrets of their browsers. Only digests of the secrets are kept.

    Args:
        ended: called with the console of a visit that has ended.
        clock: returns seconds that never go back.
        idle_s: time after which a visit ends that has no open page, seconds.
        most: most visits.
        most_of_key: most visits of a key.
    """

    def __init__(
        self,
        ended: Callable[[Console], None],
        clock: Callable[[], float] = time.monotonic,
        idle_s: float = IDLE_S,
        most: int = MOST,
        most_of_key: int = MOST_OF_KEY,
    ) -> None:
        self._ended = ended
        self._clock = clock
        self._idle_s = idle_s
        self._most = most
        self._most_of_key = most_of_key
        self._visits: dict[bytes, Visit] = {}

    def begin(self, console: Console) -> str:
        """Begin a visit; return the secret by which its browser is recognised."""
        self.end_idle()
        self._make_room([each for each, visit in self._visits.items() if visit.console is console], self._most_of_key)
        self._make_room(list(self._visits), self._most)
        secret = secrets.token_urlsafe(32)
        self._visits[_digest(secret)] = Visit(console, self._clock())
        return secret

    def get(self, secret: str | None) -> Visit | None:
        """Return the visit of a browser, which counts as used; None: there is none, or no longer."""
        self.end_idle()
        visit = None if secret is None else self._visits.get(_digest(secret))
        if visit is not None:
            visit.used_s = self._clock()
        return visit

    def end(self, secret: str) -> None:
        """End the visit of a browser, and let its pages leave."""
        self._end(_digest(secret))

    def open_page(self, visit: Visit, leave: Leave) -> Callable[[], None]:
        """Count a page of a visit as open; return the function that counts it as closed.

        Args:
            visit: of the browser.
            leave: called when the visit ends.
        """
        visit.pages.append(leave)
        if visit not in self._visits.values():  # it has ended while the page was requested
            leave()

        def close() -> None:
            if leave in visit.pages:
                visit.pages.remove(leave)
                visit.used_s = self._clock()

        return close

    def is_visited(self, console: Console) -> bool:
        """True if a browser has given the key of a console, and has not left."""
        return any(visit.console is console for visit in self._visits.values())

    def end_idle(self) -> None:
        """End the visits that were not used for a long time."""
        oldest = self._clock() - self._idle_s
        for digest in [each for each, visit in self._visits.items() if not visit.pages and visit.used_s < oldest]:
            self._end(digest)

    def _make_room(self, digests: list[bytes], most: int) -> None:
        """End one of these visits if there are so many, one without an open page first."""
        if len(digests) >= most:
            self._end(min(digests, key=lambda each: (bool(self._visits[each].pages), self._visits[each].used_s)))

    def _end(self, digest: bytes) -> None:
        visit = self._visits.pop(digest, None)
        if visit is not None:
            for leave in list(visit.pages):
                leave()
            self._ended(visit.console)


def _digest(secret: str) -> bytes:
    return hashlib.sha256(secret.encode()).digest()
