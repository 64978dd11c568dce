"""Crashes: every write with a response is stored exactly once, and the history replays every belief bit for bit."""

import json
import os
import random
import resource
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, field
from math import cos, sin
from pathlib import Path
from typing import NamedTuple

import httpx2
import pytest

from tests.support.postgres import Server
from tests.support.replaying import replayed
from tests.support.replicas import replicas
from tests.support.scale import SCALE, scaled
from tests.support.serving import LIDAR, Json, box_obj, data_scenario, mesh_scenario, scan_of
from voa_core.scenario import Scenario
from voa_service.mapping.looks import record_of
from voa_service.mapping.models import Models
from voa_service.ports import Store
from voa_service.runtime.cache import Cache
from voa_store.records import HistoryEntry
from voa_store.sql import SqlStore

SESSIONS = scaled(10, 100)
WRITERS = scaled(4, 16)
KILLS = scaled(3, 10)
ANSWERS_BETWEEN_KILLS = scaled((10, 40), (200, 400))
DUPLICATES = scaled(5, 50)
VANISHING = scaled(10, 200)

TIMEOUT = 120.0


@dataclass(frozen=True)
class Sent:
    """Write that is identical each time it is sent."""

    method: str
    path: str
    body: str
    key: str

    def to(self, http: httpx2.Client, base: str = "") -> httpx2.Response:
        headers = {"Content-Type": "application/json", "Idempotency-Key": self.key}
        return http.request(self.method, base + self.path, content=self.body, headers=headers)


class Done(NamedTuple):
    """Write and its response."""

    sent: Sent
    session: str
    answer: Json

    @property
    def moved(self) -> bool:
        """True if the write made a version; a replaced belief always does."""
        return bool(self.answer.get("update", {"accepted": True})["accepted"])


@dataclass
class Tally:
    """Responses that all writers received."""

    done: list[Done] = field(default_factory=list)
    sent_again: int = 0
    ended: bool = False
    changed: threading.Condition = field(default_factory=threading.Condition)

    def add(self, done: Done) -> None:
        with self.changed:
            self.done.append(done)
            self.changed.notify_all()

    def again(self) -> None:
        with self.changed:
            self.sent_again += 1

    def wait_for(self, more: int) -> None:
        """Wait until `more` further writes got a response."""
        with self.changed:
            goal = len(self.done) + more
            assert self.changed.wait_for(lambda: len(self.done) >= goal, TIMEOUT), "the writers came to a stop"


def some_write(rng: random.Random, session: str, key: str) -> Sent:
    """Any write: mostly scans, some of which are not accepted."""
    kind = rng.choices(["scan", "outcome", "belief", "nothing"], [70, 15, 10, 5])[0]
    root = f"/v1/sessions/{session}"
    if kind == "outcome":
        body: Json = {"grasp": rng.choice(["G1", "G2"]), "success": rng.random() < 0.5}
        body |= {"object_moved": 0.25} if rng.random() < 0.2 else {}
        return Sent("POST", f"{root}/grasp-outcomes", json.dumps(body), key)
    if kind == "belief":
        first, second = sorted((rng.random(), rng.random()))
        given = rng.choice([None, [first, second - first, 1.0 - second]])
        return Sent("PUT", f"{root}/belief", json.dumps({"belief": given}), key)
    ranges: list[float | None] = (
        [None] * 4 if kind == "nothing" else [round(rng.uniform(0.2, 1.2), 6) for _ in range(4)]
    )
    return Sent("POST", f"{root}/scans", json.dumps(scan_of(ranges, rng.choice(["Q1", "Q2"]), stamp=key)), key)


def write_until(number: int, urls: list[str], sessions: list[str], tally: Tally) -> None:
    """Run a writer: it repeats each write under its key, to any process, until there is a response."""
    rng = random.Random(f"{SCALE} {number}")  # noqa: S311 - not a secret
    count = 0
    with httpx2.Client(timeout=TIMEOUT) as http:
        while not tally.ended:
            session = rng.choice(sessions)
            sent = some_write(rng, session, f"{number}-{count}")
            count += 1
            while True:
                try:
                    answer = sent.to(http, rng.choice(urls))
                except httpx2.TransportError:
                    tally.again()
                    continue
                if answer.status_code == 503:
                    tally.again()
                    continue
                assert answer.is_success, answer.text
                tally.add(Done(sent, session, answer.json()))
                break


def scenario_in(store: Store, id_: str) -> Scenario:
    """The mathematics of a scenario."""
    model = Models(store, Cache(2**20)).get(id_)
    assert model is not None
    return model.scenario


def assert_nothing_answered_is_missing(store: Store, done: list[Done]) -> dict[str, list[HistoryEntry]]:
    """Each answered write that made a version is that version in the history, with that request and that belief."""
    histories = {id_: store.history(id_, -1, 10**6) for id_ in {each.session for each in done}}
    for each in done:
        entries, version = histories[each.session], each.answer["version"]
        assert version < len(entries), f"version {version} was answered and is missing"
        entry = entries[version]
        assert entry.state.version == version
        assert entry.state.belief.p.tolist() == each.answer["belief"]
        if each.moved:
            assert entry.request == each.sent.body
            assert (None if entry.report is None else json.loads(entry.report)) == each.answer.get("update")
    return histories


def assert_everything_happened_once(store: Store, done: list[Done]) -> int:
    """Assert versions without gaps, each made by one key, after the last response; returns their number."""
    histories = assert_nothing_answered_is_missing(store, done)
    for id_, entries in histories.items():
        state = store.get_session(id_)
        assert state is not None
        scenario = scenario_in(store, state.scenario)
        assert [entry.state.version for entry in entries] == list(range(state.version + 1))
        made = [each.answer["version"] for each in done if each.session == id_ and each.moved]
        assert sorted(made) == list(range(1, state.version + 1)), "a version that no key made, or two keys"
        for entry, estimate in zip(entries, replayed(scenario, entries), strict=True):
            assert entry.state.belief.p.tobytes() == estimate.belief.p.tobytes(), f"{id_} at {entry.state.version}"
            assert entry.state.belief.log_p.tobytes() == estimate.belief.log_p.tobytes()
            record = record_of(entry.state.looks)
            assert record.log_odds_absent == estimate.log_odds_absent
            assert [place.looks for place in record.places] == [len(place.looks) for place in estimate.places]
        assert state.looks == entries[-1].state.looks
        assert state.belief.log_p.tobytes() == entries[-1].state.belief.log_p.tobytes()
    return sum(len(entries) - 1 for entries in histories.values())


@contextmanager
def stored(database_url: str) -> Iterator[Store]:
    store = SqlStore(database_url)
    try:
        yield store
    finally:
        store.close()


def made(http: httpx2.Client, path: str, body: Json) -> str:
    answer = http.post(path, json=body)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def spread_scenario(object_: str) -> Json:
    """A box that spreads about three poses and may be absent, seen by four beams; every scan is evidence."""
    yaws = (0.0, 0.5, 1.0)
    return mesh_scenario(
        object_,
        poses=[
            {"name": f"P{yaw}", "position": [0.0, 0.0, 0.0], "quaternion_wxyz": [cos(yaw / 2), 0.0, 0.0, sin(yaw / 2)]}
            for yaw in yaws
        ],
        scores={"attempts": 10, "successes": [[9, 5, 1], [2, 6, 8]]},
        sensors=[
            {"name": "Q1", "x": 0.3, "y": 0.0, "yaw_rad": 3.0},
            {"name": "Q2", "x": 0.0, "y": 0.3, "yaw_rad": -1.7},
        ],
        lidar=LIDAR | {"height_m": 0.02},
        update={"rule": "exponential", "no_return_m": 1.0, "on_nothing_seen": "evidence"},
        spread={"xy_m": 0.01, "yaw_rad": 0.1},
        absent=0.1,
    )


def opened(url: str, count: int) -> list[str]:
    """Open `count` sessions: the first of two on a scenario of data, the second on one with a spread."""
    with httpx2.Client(base_url=url, timeout=TIMEOUT) as http:
        box = http.post("/v1/objects", files={"file": ("box.obj", box_obj())}).raise_for_status().json()["id"]
        scenarios = [made(http, "/v1/scenarios", body) for body in (data_scenario(), spread_scenario(box))]
        return [made(http, "/v1/sessions", {"scenario": scenarios[number % 2]}) for number in range(count)]


def assert_not_ready(answer: httpx2.Response) -> None:
    """A problem document that says to try again."""
    assert answer.status_code == 503, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["type"] in ("urn:voa:problem:not-ready", "urn:voa:problem:overloaded")
    assert int(answer.headers["Retry-After"]) > 0


def assert_checksums_are_right(database_url: str) -> None:
    """Every version of every session is as it was written, for a program that reads the database alone."""
    command = [sys.executable, "-m", "voa_store.verify", "-"]
    done = subprocess.run(command, input=database_url, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout or done.stderr


def test_kill_9_at_random_moments_under_writers_loses_nothing_and_repeats_nothing(
    database_url: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    processes = 2 if database_url.startswith("postgresql") else 1
    rng = random.Random(SCALE)  # noqa: S311 - not a secret
    tally, checked = Tally(), 0
    with ExitStack() as stack:
        running = stack.enter_context(replicas(database_url, tmp_path, processes))
        urls = [replica.url for replica in running]
        sessions = opened(urls[0], SESSIONS)
        store = stack.enter_context(stored(database_url))
        pool = stack.enter_context(ThreadPoolExecutor(WRITERS))
        try:
            writers = [pool.submit(write_until, number, urls, sessions, tally) for number in range(WRITERS)]
            for _ in range(KILLS):
                tally.wait_for(rng.randint(*ANSWERS_BETWEEN_KILLS))
                victim = rng.choice(running)
                victim.kill()
                with tally.changed:
                    answered = tally.done[checked:]
                victim.start()
                assert_nothing_answered_is_missing(store, answered)
                checked += len(answered)
            tally.wait_for(ANSWERS_BETWEEN_KILLS[0])
        finally:
            tally.ended = True
        for writer in writers:
            writer.result()
        versions = assert_everything_happened_once(store, tally.done)
    assert_checksums_are_right(database_url)
    scans = sum(each.sent.path.endswith("/scans") for each in tally.done)
    with capsys.disabled():
        print(
            f"\n  {database_url.partition(':')[0]}, {processes} process(es): {KILLS} kills, {WRITERS} writers, "
            f"{SESSIONS} sessions; {len(tally.done)} writes answered ({scans} scans), {tally.sent_again} sent again, "
            f"{versions} versions; 0 missing, 0 applied twice, {versions} beliefs replayed bit for bit"
        )


# ----------------------------------------------------------------------------------------------------- disk full


class Disk(NamedTuple):
    """Folder on a disk that becomes full."""

    what: str
    folder: Path
    fill: Callable[[int], None]
    """Make the disk full for a process."""
    free: Callable[[int], None]
    """Make room again for a process."""


@contextmanager
def small_disk(folder: Path) -> Iterator[Disk]:
    """A tmpfs of a megabyte (root only) that is made larger."""
    place = folder / "disk"
    place.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "voa-test", place], check=True, capture_output=True)

    def free(_: int) -> None:
        subprocess.run(["mount", "-o", "remount,size=64m", place], check=True, capture_output=True)

    try:
        yield Disk("a tmpfs of 1 MB", place, lambda _: None, free)
    finally:
        subprocess.run(["umount", "--lazy", place], check=True, capture_output=True)


@contextmanager
def limited_files(folder: Path) -> Iterator[Disk]:
    """Files of the process cannot grow beyond a megabyte (RLIMIT_FSIZE), until they can."""
    place = folder / "disk"
    place.mkdir()

    def limit(pid: int, size: int) -> None:
        hard = resource.prlimit(pid, resource.RLIMIT_FSIZE)[1]
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, hard))

    yield Disk(
        "RLIMIT_FSIZE of 1 MB", place, lambda pid: limit(pid, 2**20), lambda pid: limit(pid, resource.RLIM_INFINITY)
    )


def can_mount(folder: Path = Path("/tmp")) -> bool:  # noqa: S108 - only a mount point, and only if root
    """True if this process may mount; in most containers even root may not."""
    if os.geteuid() != 0:
        return False
    place = folder / f"voa-mount-{os.getpid()}"
    place.mkdir()
    try:
        if subprocess.run(["mount", "-t", "tmpfs", "voa-test", place], check=False, capture_output=True).returncode:
            return False
        subprocess.run(["umount", place], check=True, capture_output=True)
        return True
    finally:
        place.rmdir()


DISKS = [small_disk, limited_files] if can_mount() else [limited_files]


def padded_scan(session: str, number: int) -> Sent:
    """A scan whose request is 20 kB long."""
    body = scan_of([0.5, 0.5 + number / 1000, None, 1.0], stamp=f"{number} " + "x" * 20_000)
    return Sent("POST", f"/v1/sessions/{session}/scans", json.dumps(body), f"key {number}")


@pytest.mark.parametrize("kind", DISKS[: scaled(1, 2)], ids=lambda kind: kind.__name__)
def test_a_full_disk_is_a_503_that_loses_nothing_and_passes(
    kind: Callable[[Path], AbstractContextManager[Disk]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with kind(tmp_path) as disk:
        url = f"sqlite:///{disk.folder / 'voa.db'}"
        with replicas(url, tmp_path) as (replica,), httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http:
            (session,) = opened(replica.url, 1)
            disk.fill(replica.pid)
            done: list[Done] = []
            refused: Sent | None = None
            for number in range(200):
                sent = padded_scan(session, number)
                answer = sent.to(http)
                if answer.status_code != 200:
                    assert_not_ready(answer)
                    refused = sent
                    break
                done.append(Done(sent, session, answer.json()))
            assert refused is not None, "the disk was never full"
            for _ in range(5):  # it stays so, and what was answered can still be read
                assert_not_ready(refused.to(http))
                assert http.get(f"/v1/sessions/{session}").json()["version"] == len(done)
            assert http.get("/livez").status_code == 200
            disk.free(replica.pid)
            for sent in (refused, padded_scan(session, 1000)):
                answer = sent.to(http)
                assert answer.status_code == 200, answer.text
                done.append(Done(sent, session, answer.json()))
            replica.kill()
            replica.start()
            with stored(url) as store:
                assert assert_everything_happened_once(store, done) == len(done)
            assert_checksums_are_right(url)
    with capsys.disabled():
        print(f"\n  disk full ({disk.what}): {len(done)} scans answered, then none, then again")


# ------------------------------------------------------------------------------------- database gone, caller gone


def test_a_database_that_goes_and_comes_back_needs_no_restart(postgres: Server, tmp_path: Path) -> None:
    url = postgres.new_database()
    with replicas(url, tmp_path) as (replica,), httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http:
        (session,) = opened(replica.url, 1)
        writes = [padded_scan(session, number) for number in range(4)]
        done = [Done(writes[0], session, writes[0].to(http).json())]
        with http.stream("GET", f"/v1/sessions/{session}/events", timeout=TIMEOUT) as events:
            ids = (line for line in events.iter_lines() if line.startswith("id: "))
            assert next(ids) == "id: 1"
            postgres.stop()
            try:
                for _ in range(3):
                    assert_not_ready(writes[1].to(http))
                    assert_not_ready(http.get(f"/v1/sessions/{session}"))
                    assert_not_ready(http.get("/v1/sessions"))
                    assert_not_ready(http.get("/readyz"))
                    assert http.get("/livez").status_code == 200
            finally:
                postgres.start()
            assert http.get("/readyz").status_code == 200
            for sent in (writes[1], writes[1], writes[2]):
                answer = sent.to(http)
                assert answer.status_code == 200, answer.text
            done += [Done(sent, session, sent.to(http).json()) for sent in writes[1:3]]
            assert [next(ids), next(ids)] == ["id: 2", "id: 3"]
        with stored(url) as store:
            assert assert_everything_happened_once(store, done) == 3
        assert_checksums_are_right(url)
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
    url = f"sqlite:///{tmp_path / 'voa.db'}"
    with replicas(url, tmp_path) as (replica,), httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http:
        (session,) = opened(replica.url, 1)
        address = ("127.0.0.1", httpx2.URL(replica.url).port or 0)
        done = []
        for number in range(VANISHING):
            sent = padded_scan(session, number)
            whole = raw_request(sent)
            for length in (40, len(whole) - len(sent.body) + 10, len(whole) - 1):
                with socket.create_connection(address) as half:
                    half.sendall(whole[:length])
            assert http.get(f"/v1/sessions/{session}").json()["version"] == number
            with socket.create_connection(address) as deaf:
                deaf.sendall(whole)
            answer = sent.to(http)
            assert answer.status_code == 200, answer.text
            done.append(Done(sent, session, answer.json()))
        with stored(url) as store:
            assert assert_everything_happened_once(store, done) == VANISHING
        log = replica.log.read_text()
        assert "Traceback" not in log
        assert "unexpected error" not in log


def test_a_duplicate_sent_to_two_processes_at_the_same_instant_has_one_effect(
    database_url: str, tmp_path: Path
) -> None:
    rng = random.Random(SCALE)  # noqa: S311 - not a secret
    with replicas(database_url, tmp_path, 2) as pair, ThreadPoolExecutor(4) as pool, ExitStack() as stack:
        (session,) = opened(pair[0].url, 1)
        clients = [stack.enter_context(httpx2.Client(base_url=each.url, timeout=TIMEOUT)) for each in pair * 2]
        done = []
        barrier = threading.Barrier(len(clients))

        def send(http: httpx2.Client, sent: Sent) -> httpx2.Response:
            barrier.wait(TIMEOUT)
            return sent.to(http)

        for number in range(DUPLICATES):
            sent = some_write(rng, session, f"key {number}")
            answers = [future.result() for future in [pool.submit(send, http, sent) for http in clients]]
            assert {answer.status_code for answer in answers} == {200}
            assert len({answer.content for answer in answers}) == 1
            assert len({answer.headers["ETag"] for answer in answers}) == 1
            done.append(Done(sent, session, answers[0].json()))
        created = [
            pool.submit(send, http, Sent("POST", "/v1/sessions", json.dumps({"scenario": scenario}), "one key"))
            for scenario in [clients[0].get(f"/v1/sessions/{session}").json()["scenario"]]
            for http in clients
        ]
        assert len({future.result().json()["id"] for future in created}) == 1
        with stored(database_url) as store:
            assert_everything_happened_once(store, done)
            assert len(store.list_sessions(9, None).items) == 2
