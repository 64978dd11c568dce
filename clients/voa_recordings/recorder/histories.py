"""Fetching of scenarios and histories from the service, in a thread of its own, so that sessions can be rebuilt."""

import threading
from collections.abc import Callable
from typing import Protocol

from pydantic import BaseModel

from voa_client import Client, NotFoundError, VoaClientError
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import HistoryEntry
from voa_recordings.recorder.inbox import FetchedDocument, Inbox

_AT_MOST_EVERY_S = 0.5  # a history is fetched whole, so not at each version of a session that changes quickly
_END_S = 10.0
_WITHOUT_BELIEF = dict.fromkeys(("belief", "best_grasp", "expected_score", "entropy_nats"))
"""Fields of a history's entry that are recorded on topics of their own."""


class OnVersion(Protocol):
    """Function that receives each new version of a session, in order."""

    def __call__(self, session: str, scenario: Scenario, entry: HistoryEntry, *, newest: bool) -> None:
        """Receive a version with its belief; `newest` is True for the last one that the service has so far."""


class Histories:
    """Fetcher of scenarios and histories, which it puts into the inbox.

    Attributes:
        failed: per session, why the newest attempt failed; sessions that were fetched are not in it.
    """

    def __init__(self, client: Client, inbox: Inbox, now_ns: Callable[[], int], on_version: OnVersion) -> None:
        """Fetch from `client`; `on_version` receives each version that was put into the inbox."""
        self.failed: dict[str, str] = {}
        self._client = client
        self._inbox = inbox
        self._now_ns = now_ns
        self._on_version = on_version
        self._scenarios: dict[str, Scenario] = {}
        self._fetched: dict[str, int] = {}  # session -> newest version whose entry was fetched; -1: only its scenario
        self._wanted: set[str] = set()
        self._changed = threading.Condition()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="voa-histories", daemon=True)

    def start(self) -> None:
        """Start the thread that fetches."""
        self._thread.start()

    def want(self, session: str) -> None:
        """Fetch the history of a session soon, because it has a new version; from any thread, returns at once."""
        with self._changed:
            self._wanted.add(session)
            self._changed.notify()

    def end(self) -> None:
        """Fetch the histories that are still wanted, for ten seconds at most, and end the thread."""
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
            if session not in self._fetched:
                state = self._client.get_session(session)
                self._scenarios[session] = self._client.get_scenario(state.scenario)
                self._put(session, "scenario", self._scenarios[session])
                self._put(session, "belief", state)
                self._fetched[session] = -1
            history = self._client.history(session, beliefs=True)
            new = [entry for entry in history if entry.version > self._fetched[session]]
            for entry in new:
                self._put(session, "history", entry.model_copy(update=_WITHOUT_BELIEF))
                self._fetched[session] = entry.version
                self._on_version(session, self._scenarios[session], entry, newest=entry is new[-1])
        except VoaClientError as error:
            self.failed[session] = str(error)
            if not isinstance(error, NotFoundError) and not self._ending.is_set():
                self.want(session)
        else:
            self.failed.pop(session, None)

    def _put(self, session: str, what: str, body: BaseModel) -> None:
        now = self._now_ns()
        self._inbox.put(FetchedDocument(session, what, body.model_dump_json().encode(), now, now))
