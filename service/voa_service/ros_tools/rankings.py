"""Ranking of the places of a version for ROS tools: once for each version, in the queue of heavy work."""

import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future

import structlog

from voa_msgs.rankings import Ranking, VoaRequest
from voa_service.failures import Failure
from voa_service.guard import guarded
from voa_service.runtime.queues import Cancelled
from voa_service.services import Services
from voa_service.usecases.rankings import Question

Version = tuple[str, int]
"""Session and version."""


class VersionRankings:
    """Ranks the places of the newest version; a ranking that an even newer version overtakes is given up.

    Scans do not wait for it: it is one more piece of heavy work, and its answer is kept for clients with the question.

    Args:
        services: use cases and the queue of heavy work.
        ready: called from any thread when a ranking is ready.
    """

    def __init__(self, services: Services, ready: Callable[[], None]) -> None:
        self._services = services
        self._ready = ready
        self._wanted: Version | None = None
        self._begun: Version | None = None
        self._call: Future[bytes] | None = None
        self._lock = threading.Lock()

    def poll(self, version: Version) -> Ranking | None:
        """Return the ranking of a version; None: it is not ready, and is begun if it was not.

        A full queue, or an error, leaves the ranking for the next call.
        """
        with self._lock:
            self._wanted = version
            if self._begun != version:
                self._begin(version)
            call = self._call
            if call is None or not call.done():
                return None
        try:
            with guarded():
                return Ranking.model_validate_json(call.result())
        except (Failure, Cancelled, CancelledError) as error:
            if isinstance(error, Failure):
                structlog.get_logger().info("no ranking for the outputs to ROS", why=error.detail)
            with self._lock:
                self._begun = self._call = None
            return None

    def stop(self) -> None:
        """Give up the ranking that is under way."""
        with self._lock:
            self._wanted = self._begun = self._call = None

    def _begin(self, version: Version) -> None:
        """Begin the ranking of a version; the caller holds the lock."""
        self._begun = self._call = None
        try:
            with guarded():
                question = self._services.rankings.of_session(version[0], VoaRequest())
                if question.version != version[1]:
                    return
                self._call = self._services.heavy.submit(lambda: self._answer(question, version))
        except Failure:
            return
        self._begun = version
        self._call.add_done_callback(lambda _: self._ready())

    def _answer(self, question: Question, version: Version) -> bytes:
        def check() -> None:
            self._services.heavy.check()
            if self._wanted != version:
                raise Cancelled

        check()
        return self._services.rankings.answer(question, check).to(question)
