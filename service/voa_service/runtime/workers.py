"""Worker threads that do not keep a process from ending."""

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from typing import Any

_Job = tuple[Future[Any], Callable[[], Any]]


class Workers:
    """Up to `count` daemon threads, started when they are needed.

    The interpreter joins the threads of `concurrent.futures` when it exits, however long they take: a call into a
    database that does not answer would delay the end of the service.
    """

    def __init__(self, name: str, count: int) -> None:
        self._name = name
        self._count = count
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._threads: list[threading.Thread] = []
        self._open = 0
        self._closed = False
        self._lock = threading.RLock()

    def submit(self, future: Future[Any], work: Callable[[], Any]) -> None:
        """Call `work` in one of the threads and give its result to `future`, unless that is cancelled before."""
        with self._lock:
            if self._closed:
                future.cancel()
                return
            self._open += 1
            self._jobs.put((future, work))
            if self._open > len(self._threads) < self._count:
                name = f"voa-{self._name}-{len(self._threads)}"
                self._threads.append(threading.Thread(target=self._run, name=name, daemon=True))
                self._threads[-1].start()

    def close(self, seconds: float) -> None:
        """Cancel the calls that wait, and wait at most so many seconds for those under way."""
        with self._lock:
            self._closed = True
            threads = list(self._threads)
        while True:
            try:
                job = self._jobs.get_nowait()
            except Empty:
                break
            if job is not None:
                job[0].cancel()
        for _ in threads:
            self._jobs.put(None)
        until = time.monotonic() + seconds
        for thread in threads:
            thread.join(max(0.0, until - time.monotonic()))

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            future, work = job
            del job
            if future.set_running_or_notify_cancel():
                self._work(future, work)
            del future, work  # an idle thread keeps no result alive
            with self._lock:
                self._open -= 1

    @staticmethod
    def _work(future: Future[Any], work: Callable[[], Any]) -> None:
        try:
            result = work()
        except BaseException as error:  # any error is the caller's to handle
            future.set_exception(error)
        else:
            future.set_result(result)
