"""The process drains, and ends some seconds after the signal to stop, whatever hangs."""

import os
import signal
import socket
import subprocess
import sys
import threading
from contextlib import ExitStack
from pathlib import Path

import httpx2
import pytest
from structlog.testing import capture_logs

from tests.support.replicas import replicas
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from voa_client.local import running
from voa_service.runtime.stopping import Deadline, Drain


def test_a_drain_is_over_some_seconds_after_it_has_begun() -> None:
    now = [100.0]
    drain = Drain(5.0, lambda: now[0])
    assert (drain.has_begun, drain.is_over) == (False, False)
    drain.begin()
    now[0] = 104.9
    assert (drain.has_begun, drain.is_over) == (True, False)
    now[0] = 105.0
    assert (drain.has_begun, drain.is_over) == (True, True)


def test_a_service_that_drains_is_not_ready_and_serves_until_a_second_signal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VOA_STOP_SECONDS", "60")
    monkeypatch.setenv("VOA_DRAIN_SECONDS", "55")
    with (
        replicas(f"sqlite:///{tmp_path / 'voa.db'}", tmp_path) as (own,),
        httpx2.Client(base_url=own.url, timeout=30) as http,
    ):
        scenario = http.post("/v1/scenarios", json=data_scenario()).json()["id"]
        own.signal(signal.SIGTERM)
        wait_for(lambda: http.get("/readyz").status_code == 503, "the drain")
        refused = http.get("/readyz")
        assert refused.json()["type"] == "urn:voa:problem:not-ready"
        assert "the service is stopping: send requests to another replica" in refused.json()["detail"]
        written = http.post("/v1/sessions", json={"scenario": scenario})
        assert (written.status_code, written.headers["connection"]) == (201, "close")
        session = f"/v1/sessions/{written.json()['id']}"
        with http.stream("GET", f"{session}/events") as events:
            assert next(events.iter_lines()) == "event: session"
            assert http.get("/livez").status_code == 200
            own.signal(signal.SIGTERM)
            assert own.wait() == 0  # within 30 s: sooner than the drain


def test_a_deadline_ends_the_process_after_it_has_begun() -> None:
    codes: list[int] = []
    ended = threading.Event()

    def end(code: int) -> None:
        codes.append(code)
        ended.set()

    with capture_logs() as lines, Deadline(0.01, end) as deadline:
        assert not ended.is_set()
        assert deadline.left == 0.01
        deadline.begin()
        deadline.begin()
        assert ended.wait(30)
        assert deadline.left == 0.0
    assert codes == [0]
    assert [line["event"] for line in lines] == ["stopped with work under way"]


def test_a_deadline_that_never_began_ends_nothing() -> None:
    codes: list[int] = []
    before = set(threading.enumerate())
    with Deadline(0.0, codes.append):
        (waiting,) = set(threading.enumerate()) - before
    waiting.join(30)
    assert not waiting.is_alive()
    assert codes == []


def test_a_service_with_connections_that_hang_ends_in_time_and_says_so_to_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VOA_STOP_SECONDS", "3")
    with ExitStack() as stack:
        options = ["--database-url", f"sqlite:///{tmp_path / 'voa.db'}"]
        service = stack.enter_context(running("voa_service", options, tmp_path / "log"))
        address = ("127.0.0.1", int(service.url.rpartition(":")[2]))
        scenario = httpx2.post(f"{service.url}/v1/scenarios", json=data_scenario()).json()["id"]
        session = httpx2.post(f"{service.url}/v1/sessions", json={"scenario": scenario}).json()["id"]
        requests = (
            f"GET /v1/sessions/{session}/events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
            "POST /v1/scenarios HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
            "Content-Length: 10\r\n\r\n{",
            "GET /livez HTTP",
        )
        opened = [stack.enter_context(socket.create_connection(address, timeout=30)) for _ in (*requests, "")]
        for connection, request in zip(opened, requests, strict=False):
            connection.sendall(request.encode())
        assert opened[0].recv(65_536).startswith(b"HTTP/1.1 200")
        os.kill(service.pid, signal.SIGTERM)
        assert opened[1].recv(65_536).startswith(b"HTTP/1.1 503")
        assert opened[3].recv(65_536) == b""  # was idle
        wait_for(lambda: "Finished server process" in (tmp_path / "log").read_text(), "the service to end")
        os.kill(service.pid, signal.SIGTERM)  # a second one, while it closes, breaks into nothing
    assert "Traceback" not in (tmp_path / "log").read_text()


def test_a_service_that_waits_for_its_database_ends_at_once(tmp_path: Path) -> None:
    url = "postgresql+psycopg://voa:s3cret@127.0.0.1:1/voa"
    arguments = ["--port", "0", "--database-url", url, "--wait-for-database", "600"]
    with (tmp_path / "log").open("w") as log:
        process = subprocess.Popen([sys.executable, "-m", "voa_service", *arguments], stderr=log, cwd=tmp_path)
    try:
        wait_for(lambda: "waiting for the database" in (tmp_path / "log").read_text(), "the service to wait")
        process.terminate()
        assert process.wait(30) == 0
    finally:
        process.kill()
        process.wait()
    assert "s3cret" not in (tmp_path / "log").read_text()
