"""A rolling restart of two replicas under load: no request fails, no answered write is lost, no scan counts twice.

HAProxy, with the configuration of `deploy/`, stands in front of the two. Programs write and read by HTTP through it,
and by Zenoh through a router; one puts raw scans there, which both replicas receive. Meanwhile the replicas are ended
by SIGTERM and started again, one after the other. No caller repeats a call, as the project's clients would.
"""

import itertools
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.support.balancer import Balancer, balancer
from tests.support.bus import Stranger, stranger
from tests.support.postgres import Server
from tests.support.replicas import Listener, Replica, replicas
from tests.support.routers import router
from tests.support.serving import data_scenario, scan_of
from tests.support.waiting import wait_for

EVERY_S = 0.05
"""Pause of a caller between a response and the next call."""
REVOLUTION_S = 0.2
"""Pause of a robot between two scans that it puts: it receives no response, so it must not outrun the service."""
DRAIN_S = "2"
"""Longer than HAProxy's two quick probes also on a busy machine."""
STOP_S = "25"
"""Enough for the scans that wait in a replica on a busy machine when it stops."""
SECONDS = 60.0
SCAN = scan_of([0.5, 0.5, None, 1.0])

Call = Callable[[str], Any]
"""Makes one call about a scan with a stamp, and returns the response to a write, None for any other."""
RAW = "raw scan on Zenoh"


class Load:
    """Callers at a steady rate, and what they received."""

    def __init__(self) -> None:
        self.failed: list[str] = []
        self.made: Counter[str] = Counter()
        self.answered: dict[str, int] = {}
        """Version that each write was answered with, by the stamp of its scan."""
        self._ended = threading.Event()

    @contextmanager
    def of(self, calls: dict[str, Call]) -> Iterator[None]:
        """Make each call again and again within a `with` block."""
        with ThreadPoolExecutor(len(calls)) as pool:
            running = [pool.submit(self._repeat, name, call) for name, call in calls.items()]
            try:
                yield
            finally:
                self._ended.set()
            for each in running:
                each.result()

    def _repeat(self, name: str, call: Call) -> None:
        for number in itertools.count():
            if self._ended.wait(REVOLUTION_S if name == RAW else EVERY_S):
                return
            stamp = f"{name} {number}"
            try:
                answer = call(stamp)
            except Exception as error:
                self.failed.append(f"{stamp}: {type(error).__name__}: {error}")
                continue
            self.made[name] += 1
            if answer is not None:
                self.answered[stamp] = answer["version"]


def calls_of(http: httpx2.Client, bus: Stranger, session: str, put: list[str]) -> dict[str, Call]:
    """Calls of the programs of a laboratory about one session; `put` receives the stamps of scans put on Zenoh."""

    def by_http(method: str, path: str, **more: Any) -> Any:
        response = http.request(method, f"/v1/sessions/{session}{path}", **more)
        assert response.is_success, (response.status_code, response.text)
        return response.json()

    def with_stamp(stamp: str) -> Any:
        return SCAN | {"scan": SCAN["scan"] | {"stamp": stamp}}

    def put_on_zenoh(stamp: str) -> None:
        bus.put_scan(session, with_stamp(stamp), id=stamp)
        put.append(stamp)

    def read_on_zenoh(stamp: str) -> None:
        bus.call("session.get", {"id": session})

    return {
        "scan by HTTP": lambda stamp: by_http("POST", "/scans", json=with_stamp(stamp)),
        "another scan by HTTP": lambda stamp: by_http("POST", "/scans", json=with_stamp(stamp)),
        "session by HTTP": lambda stamp: by_http("GET", "") and None,
        "ranking by HTTP": lambda stamp: by_http("POST", "/voa", json={}) and None,
        "scan by Zenoh": lambda stamp: bus.call("scan.apply", {"session": session} | with_stamp(stamp)),
        "session by Zenoh": read_on_zenoh,
        RAW: put_on_zenoh,
    }


def restart(replica: Replica, front: Balancer) -> None:
    """Restart a replica as an orchestrator does, and wait until the balancer uses it again."""
    replica.signal(signal.SIGTERM)
    assert replica.wait() == 0
    replica.start()
    all_are_used(front)


def all_are_used(front: Balancer) -> None:
    wait_for(lambda: set(front.states().values()) == {"UP"}, "both replicas behind the balancer", SECONDS)


def stamps_of(http: httpx2.Client, session: str) -> dict[str, int]:
    """Version of each scan in the history, by its stamp; fails where a scan is there twice."""
    versions: dict[str, int] = {}
    after = ""
    while True:
        page = http.get(f"/v1/sessions/{session}/history?limit=1000{after}").raise_for_status().json()
        for entry in page["items"]:
            if entry["kind"] == "scan":
                stamp = entry["request"]["scan"]["stamp"]
                assert stamp not in versions, f"{stamp} counts twice"
                versions[stamp] = entry["version"]
        if page["next"] is None:
            return versions
        after = f"&after={page['next']}"


def test_a_rolling_restart_fails_no_request_and_loses_no_scan(
    postgres: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VOA_DRAIN_SECONDS", DRAIN_S)
    monkeypatch.setenv("VOA_STOP_SECONDS", STOP_S)
    with ExitStack() as stack:
        own = stack.enter_context(router())
        options = ["--zenoh", own.endpoint]
        both = stack.enter_context(replicas(postgres.new_database(), tmp_path, 2, *options, kind=Listener))
        front = stack.enter_context(balancer([each.url for each in both], tmp_path, quick=True))
        bus = stack.enter_context(stranger(own.endpoint))
        http = stack.enter_context(httpx2.Client(base_url=front.url, timeout=SECONDS))
        for each in both:
            wait_for(lambda own=each: own.zenoh == "connected", "a replica on the bus", SECONDS)  # type: ignore[misc] # bound in each round, which mypy cannot infer
        scenario = http.post("/v1/scenarios", json=data_scenario()).raise_for_status().json()["id"]
        session = http.post("/v1/sessions", json={"scenario": scenario}).raise_for_status().json()["id"]
        all_are_used(front)
        load, put = Load(), list[str]()

        with load.of(calls_of(http, bus, session, put)):
            wait_for(lambda: len(load.made) == 7 and min(load.made.values()) > 5, "the load", SECONDS)
            for each in both:
                restart(each, front)
        print(f"{dict(load.made)}; {front.retries()} sent again by HAProxy")

        assert load.failed == [], load.failed
        assert front.retries() == 0, "requests reached a replica that was gone, and HAProxy sent them again"
        expected = set(load.answered) | set(put)
        with suppress(AssertionError):  # the next assertion names the scans that are missing
            wait_for(lambda: stamps_of(http, session).keys() >= expected, "every scan in the history", SECONDS)
        stored = stamps_of(http, session)
        assert sorted(expected ^ stored.keys()) == []
        assert sorted(stored.values()) == list(range(1, len(expected) + 1))
        assert {stamp: stored[stamp] for stamp in load.answered} == load.answered
