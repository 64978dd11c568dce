"""Histories and scenarios, by which sessions are made anew: asked of the service in a thread of its own."""

import threading
from collections.abc import Callable

from pydantic import BaseModel

from voa_client import Client, NotFoundError, VoaClientError
from voa_recordings.recorder.inbox import Answer, Inbox

_AT_MOST_EVERY_S = 0.5  # a history comes whole: a session that moves quickly is asked for once in a while
_END_S = 10.0


class Histories:
    """Fetches scenarios and histories; what it gets goes into the inbox.

    Attributes:
        failed: per session why the newest attempt came to nothing.
    """

    def __init__(self, client: Client, inbox: Inbox, now_ns: Callable[[], int]) -> None:
        self.failed: dict[str, str] = {}
        self._client = client
        self._inbox = inbox
        self._now_ns = now_ns
        self._told: dict[str, int] = {}  # session -> newest version whose entry was fetched; -1: only its scenario
        self._wanted: set[str] = set()
        self._changed = threading.Condition()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="voa-histories", daemon=True)

    def start(self) -> None:
        """Start the thread that asks."""
        self._thread.start()

    def want(self, session: str) -> None:
        """The session has moved. From any thread; returns at once."""
        with self._changed:
            self._wanted.add(session)
            self._changed.notify()

    def end(self) -> None:
        """Fetch what is still wanted, as far as that is quick."""
        self._ending.set()
        with self._changed:
            self._changed.notify()
        self._thread.join(_END_S)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._wanted or self._ending.is_set())
                now, self._wanted = sorted(self._wanted), set()
            if not now:
                return
            for session in now:
                self._fetch(session)
            self._ending.wait(_AT_MOST_EVERY_S)

    def _fetch(self, session: str) -> None:
        try:
            if session not in self._told:
                state = self._client.get_session(session)
                self._tell(session, "scenario", self._client.get_scenario(state.scenario))
                self._tell(session, "belief", state)
                self._told[session] = -1
            for entry in self._client.history(session):
                if entry.version > self._told[session]:
                    self._tell(session, "history", entry)
                    self._told[session] = entry.version
        except VoaClientError as error:
            self.failed[session] = str(error)
            if not isinstance(error, NotFoundError) and not self._ending.is_set():
                self.want(session)
        else:
            self.failed.pop(session, None)

    def _tell(self, session: str, what: str, body: BaseModel) -> None:
        now = self._now_ns()
        self._inbox.put(Answer(session, what, body.model_dump_json().encode(), now, now))
