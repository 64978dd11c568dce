"""A replica that ends hands its queries over: none that the router has sent to it already is lost."""

import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

from structlog.testing import capture_logs

from tests.support.bus import Stranger, bridged, stranger
from tests.support.routers import Router, router
from tests.support.serving import serving
from tests.support.waiting import wait_for

CALLERS = 6


def joined(folder: Path, own: Router) -> ExitStack:
    """A service of its own on the router, until the stack is closed."""
    with ExitStack() as stack:
        folder.mkdir()
        stack.enter_context(bridged(stack.enter_context(serving(folder)), own))
        return stack.pop_all()


def test_callers_without_a_pause_get_a_response_to_each_query(tmp_path: Path) -> None:
    responses, ended = list[int](), threading.Event()

    def call(bus: Stranger) -> None:
        while not ended.is_set():
            responses.append(len(bus.replies("lidar.list", {})))

    with (
        capture_logs() as lines,
        router() as own,
        stranger(own.endpoint) as bus,
        ThreadPoolExecutor(CALLERS) as pool,
    ):
        first = joined(tmp_path / "first", own)
        with first, joined(tmp_path / "second", own):
            wait_for(lambda: bus.replies("lidar.list", {}), "a replica")
            callers = [pool.submit(call, bus) for _ in range(CALLERS)]
            try:
                wait_for(lambda: len(responses) > 20 * CALLERS, "responses of the first replica")
                first.close()
                before = len(responses)
                wait_for(lambda: len(responses) > before + 20 * CALLERS, "responses of the second replica")
            finally:
                ended.set()
            for each in callers:
                each.result()
    assert set(responses) == {1}
    assert [line for line in lines if line["log_level"] not in ("debug", "info")] == []
