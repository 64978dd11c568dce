"""Crashes: every write with a response is stored exactly once, and the history replays every belief bit for bit."""

import json
import random
import socket
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import httpx2
import pytest

from tests.support.history_calls import (
    TIMEOUT,
    Recorder,
    Sent,
    assert_not_ready,
    opened,
    padded_scan,
    some_write,
)
from tests.support.history_store import check_answered, check_stored, stored
from tests.support.postgres import Server
from tests.support.replicas import replicas
from tests.support.scale import SCALE, scaled

SESSIONS = scaled(10, 100)
WRITERS = scaled(4, 16)
KILLS = scaled(3, 10)
ANSWERS_BETWEEN_KILLS = scaled((10, 40), (200, 400))
DUPLICATES = scaled(5, 50)
VANISHING = scaled(10, 200)


def test_kill_9_at_random_moments_under_writers_loses_nothing_and_repeats_nothing(
    database_url: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    processes = 2 if database_url.startswith("postgresql") else 1
    rng = random.Random(SCALE)  # noqa: S311 - not a secret
    recorder, checked = Recorder(), 0
    with ExitStack() as stack:
        running = stack.enter_context(replicas(database_url, tmp_path, processes))
        urls = [replica.url for replica in running]
        sessions = opened(recorder, urls[0], SESSIONS)
        store = stack.enter_context(stored(database_url))
        with recorder.running(urls, sessions, WRITERS):
            for _ in range(KILLS):
                recorder.wait_for(rng.randint(*ANSWERS_BETWEEN_KILLS))
                victim = rng.choice(running)
                victim.kill()
                answered = recorder.calls[checked:]
                victim.start()
                check_answered(store, answered)
                checked += len(answered)
            recorder.wait_for(ANSWERS_BETWEEN_KILLS[0])
    versions = check_stored(database_url, recorder.calls)
    reads = sum(call.kind == "read" for call in recorder.calls)
    with capsys.disabled():
        print(
            f"\n  {database_url.partition(':')[0]}, {processes} process(es): {KILLS} kills, {WRITERS} writers, "
            f"{SESSIONS} sessions; {recorder.answered} writes answered, {recorder.sent_again} sent again, "
            f"{reads} reads, {versions} versions; 0 missing, 0 applied twice, {versions} beliefs replayed bit for bit"
        )


def test_a_database_that_goes_and_comes_back_needs_no_restart(postgres: Server, tmp_path: Path) -> None:
    url, recorder = postgres.new_database(), Recorder()
    with replicas(url, tmp_path) as (replica,), httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http:
        (session,) = opened(recorder, replica.url, 1)
        writes = [padded_scan(session, number) for number in range(4)]
        assert recorder.response(http, writes[0]).status_code == 200
        with http.stream("GET", f"/v1/sessions/{session}/events", timeout=TIMEOUT) as events:
            ids = (line for line in events.iter_lines() if line.startswith("id: "))
            assert next(ids) == "id: 1"
            postgres.stop()
            try:
                for _ in range(3):
                    assert_not_ready(recorder.response(http, writes[1]))
                    assert_not_ready(http.get(f"/v1/sessions/{session}"))
                    assert_not_ready(http.get("/v1/sessions"))
                    assert_not_ready(http.get("/readyz"))
                    assert http.get("/livez").status_code == 200
            finally:
                postgres.start()
            assert http.get("/readyz").status_code == 200
            for sent in (writes[1], writes[1], writes[2], writes[2]):
                response = recorder.response(http, sent)
                assert response.status_code == 200, response.text
            assert [next(ids), next(ids)] == ["id: 2", "id: 3"]
        assert check_stored(url, recorder.calls) == 3
        assert "Traceback" not in replica.log.read_text()


def raw_request(sent: Sent) -> bytes:
    lines = [
        f"{sent.method} {sent.path} HTTP/1.1",
        "Host: 127.0.0.1",
        f"Idempotency-Key: {sent.key}",
        "Content-Type: application/json",
        f"Content-Length: {len(sent.body.encode())}",
    ]
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + sent.body.encode()


def test_a_client_that_vanishes_in_its_request_changes_nothing_and_after_it_once(tmp_path: Path) -> None:
    url, recorder = f"sqlite:///{tmp_path / 'voa.db'}", Recorder()
    with replicas(url, tmp_path) as (replica,), httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http:
        (session,) = opened(recorder, replica.url, 1)
        address = ("127.0.0.1", httpx2.URL(replica.url).port or 0)
        for number in range(VANISHING):
            sent = padded_scan(session, number)
            whole = raw_request(sent)
            for length in (40, len(whole) - len(sent.body) + 10, len(whole) - 1):
                with socket.create_connection(address) as half:
                    half.sendall(whole[:length])
            assert recorder.version(http, session) == number
            recorder.give_up(sent, lambda whole=whole: send_and_vanish(address, whole))  # type: ignore[misc] # bound in each round, which mypy cannot infer
            response = recorder.response(http, sent)
            assert response.status_code == 200, response.text
        assert check_stored(url, recorder.calls) == VANISHING
        log = replica.log.read_text()
        assert "Traceback" not in log
        assert "unexpected error" not in log


def send_and_vanish(address: tuple[str, int], whole: bytes) -> None:
    with socket.create_connection(address) as deaf:
        deaf.sendall(whole)


def test_a_duplicate_sent_to_two_processes_at_the_same_instant_has_one_effect(
    database_url: str, tmp_path: Path
) -> None:
    rng, recorder = random.Random(SCALE), Recorder()  # noqa: S311 - not a secret
    with replicas(database_url, tmp_path, 2) as pair, ThreadPoolExecutor(4) as pool, ExitStack() as stack:
        (session,) = opened(recorder, pair[0].url, 1)
        clients = [stack.enter_context(httpx2.Client(base_url=each.url, timeout=TIMEOUT)) for each in pair * 2]
        barrier = threading.Barrier(len(clients))

        def send(http: httpx2.Client, sent: Sent) -> httpx2.Response:
            barrier.wait(TIMEOUT)
            return recorder.response(http, sent)

        for number in range(DUPLICATES):
            sent = some_write(rng, session, f"key {number}")
            answers = [future.result() for future in [pool.submit(send, http, sent) for http in clients]]
            assert {answer.status_code for answer in answers} == {200}
            assert len({answer.content for answer in answers}) == 1
            assert len({answer.headers["ETag"] for answer in answers}) == 1
        created = [
            pool.submit(send, http, Sent("POST", "/v1/sessions", json.dumps({"scenario": scenario}), "one key"))
            for scenario in [clients[0].get(f"/v1/sessions/{session}").json()["scenario"]]
            for http in clients
        ]
        assert len({future.result().json()["id"] for future in created}) == 1
        check_stored(database_url, recorder.calls)
        with stored(database_url) as store:
            assert len(store.list_sessions(9, None).items) == 2
