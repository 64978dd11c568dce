"""Bytes that are no request yet: endless headers, unfinished bodies, idle connections, readers that do not read."""

import json
import math
import socket
import subprocess
import sys
import threading
import time
from collections import Counter
from contextlib import suppress
from functools import partial
from pathlib import Path

import httpx2

from tests.chaos.attack import Attack, Outcome
from tests.chaos.connection_tools import Server, head, posting, server, status, together
from tests.support.serving import box_obj, data_scenario, mesh_scenario, scan_of
from tests.support.waiting import wait_for

_HEADER_MEGABYTES = 100
_BODIES = 45
_BODY_BYTES = 50_000_000
_PIPELINED = 12_000
_READERS = 24
_LONG_POSES = 500
_LONG_SENSORS = 4_000
_MOST_STOP_SECONDS = 100.0


def endless_headers(folder: Path) -> Outcome:
    """Send header lines for ever on one connection."""
    with server(folder) as service:
        before = service.memory()
        one = service.connect()
        one.sendall(b"GET /livez HTTP/1.1\r\n")
        sent = 0.0
        with suppress(OSError):
            while sent < _HEADER_MEGABYTES:
                one.sendall((b"x-filler: " + b"a" * 86 + b"\r\n") * 10_000)
                sent += 0.98
        said = status(one, 2.0)
        grown = service.memory("VmHWM") - before
        return _outcome(service, f"{said} after {sent:.0f} MB, {grown:+.0f} MB", said == "431" and grown < 20)


def one_endless_header(folder: Path) -> Outcome:
    """Send a header's value for ever, of which a parser makes no header before it ends."""
    with server(folder) as service:
        before = service.memory()
        one = service.connect()
        one.sendall(b"GET /livez HTTP/1.1\r\nx-filler: ")
        sent = 0
        with suppress(OSError):
            while sent < _HEADER_MEGABYTES:
                one.sendall(b"a" * 1_000_000)
                sent += 1
        said = status(one, 2.0)
        grown = service.memory("VmHWM") - before
        return _outcome(service, f"{said} after {sent} MB, {grown:+.0f} MB", said == "431" and grown < 20)


def unfinished_bodies(folder: Path) -> Outcome:
    """Send 45 bodies of 50 MB but for their last byte, all at once."""
    with server(folder) as service:
        before = service.memory()
        unfinished = posting(_BODY_BYTES) + b" " * (_BODY_BYTES - 1)
        many = [service.connect() for _ in range(_BODIES)]
        together([partial(_send, each, unfinished) for each in many])
        works = _scans(service)
        grown = service.memory("VmHWM") - before
        said = Counter(status(each, 0.05) for each in many)
        return _outcome(service, f"{grown:+.0f} MB, {_listed(said)}", works and grown < 350 and said["503"] > 0)


def idle_connections(folder: Path) -> Outcome:
    """Open 1 100 connections to a service that may open 1 024 files, and send nothing."""
    with server(folder, files=1_024) as service:
        with suppress(OSError):
            for _ in range(1_100):
                service.connect()
        late = service.answers()
        return _outcome(service, _late(late), late is not None and _scans(service))


def followers_everywhere(folder: Path) -> Outcome:
    """Take every connection there may be with streams that are wanted, and probe the service's health."""
    with server(folder, files=200) as service, httpx2.Client(base_url=service.url) as client:
        session = _session(client)
        followers = []
        with suppress(OSError):
            for _ in range(250):
                followers.append(service.connect())
                followers[-1].sendall(head("GET", f"/v1/sessions/{session}/events"))
        late = service.answers()
        other = service.connect()
        other.sendall(head("GET", "/v1/lidars"))
        said = status(other, 5.0)
        for each in followers:  # while they stay, nobody else is served
            each.close()
        return _outcome(service, f"{_late(late)}, another request {said}", late is not None and said == "503")


def slow_requests(folder: Path) -> Outcome:
    """Begin 100 headers and 100 bodies, and send a byte of each a second for 35 s."""
    with server(folder) as service:
        headers = [service.connect() for _ in range(100)]
        bodies = [service.connect() for _ in range(100)]
        for each in headers:
            each.sendall(b"GET /livez HTTP/1.1\r\n")
        for each in bodies:
            each.sendall(posting(1_000_000) + b" " * 100)
        end = time.monotonic() + 35.0
        while time.monotonic() < end:
            for each in (*headers, *bodies):
                with suppress(OSError):
                    each.send(b"a")
            time.sleep(1.0)
        said = Counter(status(each, 0.05) for each in (*headers, *bodies))
        return _outcome(service, _listed(said), said["none"] == 0 and said["408"] > 150)


def pipelined_requests(folder: Path) -> Outcome:
    """Send 12 000 requests in one piece on each of 50 connections, without waiting for answers."""
    with server(folder) as service:
        before = service.memory()
        many = [service.connect() for _ in range(50)]
        together([partial(_send, each, head("GET", "/v1/lidars") * _PIPELINED, 5.0) for each in many])
        grown = service.memory("VmHWM") - before
        late = service.answers()
        return _outcome(service, f"{grown:+.0f} MB, {_late(late)}", grown < 100 and late is not None)


def answers_that_nobody_reads(folder: Path) -> Outcome:
    """Request predictions of 12 MB on 24 connections and read nothing of them."""
    with server(folder) as service, httpx2.Client(base_url=service.url, timeout=60.0) as client:
        sensors = [{"name": str(i), "x": 0.0, "y": 0.0, "yaw_rad": 0.0} for i in range(150)]
        poses = [{"name": str(i)} for i in range(20)]
        ranges = [0.123456789012345 + i / 1e3 for i in range(360)]
        made = data_scenario(
            poses=poses,
            sensors=sensors,
            scores={"probabilities": [[0.5] * len(poses)] * 2},
            lidar={"preset": "lds-01"},
            predictions={sensor["name"]: {pose["name"]: ranges for pose in poses} for sensor in sensors},
        )
        id_ = client.post("/v1/scenarios", json=made).raise_for_status().json()["id"]
        size = len(client.post(f"/v1/scenarios/{id_}/predictions").content) / 1e6
        for _ in range(_READERS):
            opened = service.connect()
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4_096)
            opened.sendall(head("POST", f"/v1/scenarios/{id_}/predictions", "Content-Length: 0"))
        end = time.monotonic() + 40.0
        held = 0.0
        while time.monotonic() < end:
            held = _unread(service.port)
            time.sleep(1.0)
        return _outcome(service, f"{held:.0f} of {_READERS} answers of {size:.0f} MB held after 40 s", held == 0)


def stop_when_idle(folder: Path) -> Outcome:
    """Stop a service that nobody uses."""
    with server(folder) as service:
        return _stopped(service)


def stop_with_hanging_connections(folder: Path) -> Outcome:
    """Stop a service with 100 followers, 100 idle connections, 100 unfinished headers, bodies and unread answers."""
    with server(folder) as service, httpx2.Client(base_url=service.url) as client:
        session = _session(client)
        for _ in range(100):
            service.connect().sendall(head("GET", f"/v1/sessions/{session}/events"))
            service.connect()
            service.connect().sendall(b"GET /livez HTTP/1.1\r\n")
            service.connect().sendall(posting(1_000_000) + b" " * 100)
            service.connect().sendall(head("GET", "/openapi.json") * 10)
        service.answers()
        return _stopped(service)


def stop_during_long_work(folder: Path) -> Outcome:
    """Stop a service that computes rankings for minutes, while a robot sends scans; no answered scan is lost."""
    with server(folder, VOA_WORKERS="2") as service, httpx2.Client(base_url=service.url, timeout=60.0) as client:
        session = _session(client)
        _begin_long_rankings(service, client)
        answered = 0
        stopped: list[float | None] = []
        ending = threading.Thread(target=lambda: stopped.append(service.stop(_MOST_STOP_SECONDS)))
        with suppress(httpx2.HTTPError):
            for count in range(10_000):
                if count == 5:
                    ending.start()
                client.post(f"/v1/sessions/{session}/scans", json=scan_of([0.5, 0.5, 0.6, 1.0])).raise_for_status()
                answered += 1
        ending.join()
        code = service.process.poll()
    with server(folder) as again:
        kept = httpx2.get(f"{again.url}/v1/sessions/{session}").raise_for_status().json()["version"]
    figure = _stop_figure(stopped[0], code)
    survived = f"{kept} of {answered} answered scans are stored"
    return Outcome(figure, survived, held=_stops(stopped[0], code) and kept >= answered)


def stop_while_waiting(folder: Path) -> Outcome:
    """Stop a service that waits for its database."""
    waiting = ["--wait-for-database", "60", "--database-url", "postgresql://voa@127.0.0.1:1/voa", "--port", "0"]
    log = folder / "service.log"
    with log.open("wb") as stderr:
        process = subprocess.Popen([sys.executable, "-m", "voa_service", *waiting], stderr=stderr)
    service = Server(process, 0, log)
    try:
        wait_for(lambda: b"waiting for the database" in log.read_bytes(), "the service to wait")
        return _stopped(service)
    finally:
        process.kill()
        process.wait()


def _begin_long_rankings(service: Server, client: httpx2.Client) -> None:
    """Request rankings that take minutes on as many threads as the service has, and wait until they are under way."""
    object_id = client.post("/v1/objects", files={"file": ("box.obj", box_obj())}).raise_for_status().json()["id"]
    turns = [2.0 * math.pi * i / _LONG_POSES for i in range(_LONG_POSES)]
    made = mesh_scenario(
        object_id,
        poses=[
            {
                "name": str(i),
                "position": [0.0, 0.0, 0.0],
                "quaternion_wxyz": [math.cos(turn / 2.0), 0.0, 0.0, math.sin(turn / 2.0)],
            }
            for i, turn in enumerate(turns)
        ],
        scores={"probabilities": [[0.5] * _LONG_POSES, [i / _LONG_POSES for i in range(_LONG_POSES)]]},
    )
    scenario = client.post("/v1/scenarios", json=made).raise_for_status().json()["id"]
    session = client.post("/v1/sessions", json={"scenario": scenario}).raise_for_status().json()["id"]
    for shift in range(4):
        places = [2.0 * math.pi * i / _LONG_SENSORS for i in range(_LONG_SENSORS)]
        sensors = [{"x": 0.3 * math.cos(at), "y": 0.3 * math.sin(at), "yaw_rad": at + shift / 100.0} for at in places]
        body = json.dumps({"sensors": sensors}).encode()
        headers = ("Content-Type: application/json", f"Content-Length: {len(body)}")
        service.connect().sendall(head("POST", f"/v1/sessions/{session}/voa", *headers) + body)
    wait_for(lambda: "voa_heavy_requests 4" in client.get("/metrics").text, "the rankings to begin")


def _stopped(service: Server) -> Outcome:
    took = service.stop(_MOST_STOP_SECONDS)
    code = service.process.poll()
    lost = "Traceback" in service.log.read_text()
    return Outcome(_stop_figure(took, code), "errors in the log" if lost else "a clean log", _stops(took, code))


def _stops(took: float | None, code: int | None) -> bool:
    return took is not None and took <= 10.0 and code == 0


def _stop_figure(took: float | None, code: int | None) -> str:
    return f"over {_MOST_STOP_SECONDS:.0f} s" if took is None else f"{took:.1f} s, exit code {code}"


def _send(opened: socket.socket, data: bytes, seconds: float = 20.0) -> None:
    opened.settimeout(seconds)
    rest = memoryview(data)
    with suppress(OSError):
        while rest:
            rest = rest[opened.send(rest[:1_000_000]) :]


def _unread(port: int) -> int:
    """Count the service's connections with bytes that wait to be sent."""
    rows = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    return sum(row[1].endswith(f":{port:04X}") and int(row[4].partition(":")[0], 16) > 0 for row in rows)


def _session(client: httpx2.Client) -> str:
    scenario = client.post("/v1/scenarios", json=data_scenario()).raise_for_status().json()["id"]
    return str(client.post("/v1/sessions", json={"scenario": scenario}).raise_for_status().json()["id"])


def _scans(service: Server) -> bool:
    """Say whether a robot can open a session and send a scan within 10 s."""
    with suppress(httpx2.HTTPError), httpx2.Client(base_url=service.url, timeout=10.0) as client:
        session = _session(client)
        body = scan_of([0.5, 0.5, 0.6, 1.0])
        return client.post(f"/v1/sessions/{session}/scans", json=body).raise_for_status().is_success
    return False


def _outcome(service: Server, figure: str, within: bool) -> Outcome:
    works = service.process.poll() is None and _scans(service)
    return Outcome(figure, "a scan is answered" if works else "no scan is answered", held=within and works)


def _late(seconds: float | None) -> str:
    return "/livez not answered in 5 s" if seconds is None else f"/livez after {seconds:.2f} s"


def _listed(said: Counter[str]) -> str:
    return ", ".join(f"{count} x {kind}" for kind, count in said.most_common())


ATTACKS = [
    Attack("headers without end", "2026-11-28: none after 101 MB, +252 MB", "431, 20 MB", endless_headers),
    Attack("one header without end", "2026-11-28: none after 100 MB, +192 MB", "431, 20 MB", one_endless_header),
    Attack(
        "45 unfinished bodies of 50 MB",
        "2026-11-28: +2247 MB, 45 x none",
        "350 MB, scans are answered",
        unfinished_bodies,
    ),
    Attack(
        "1 100 idle connections, 1 024 files",
        "2026-11-28: /livez not answered in 5 s",
        "/livez within 5 s",
        idle_connections,
    ),
    Attack(
        "followers on every connection",
        "2026-11-28: /livez not answered in 5 s, another request none",
        "/livez within 5 s, others 503",
        followers_everywhere,
    ),
    Attack("200 slow requests", "2026-11-28: 200 x none", "408", slow_requests),
    Attack(
        "50 x 12 000 pipelined requests", "2026-11-28: +4 MB, /livez not answered in 5 s", "100 MB", pipelined_requests
    ),
    Attack(
        "24 answers that nobody reads",
        "2026-11-28: 18 of 24 answers of 20 MB held after 40 s",
        "none held after 40 s",
        answers_that_nobody_reads,
    ),
    Attack("SIGTERM when idle", "2026-11-28: 2.7 s, exit code 0", "10 s, exit code 0", stop_when_idle),
    Attack(
        "SIGTERM with 500 hanging connections",
        "2026-11-28: 23.4 s, exit code 0, errors in the log",
        "10 s, exit code 0",
        stop_with_hanging_connections,
    ),
    Attack(
        "SIGTERM with rankings under way",
        "2026-11-28: 36.2 s, exit code 0",
        "10 s, exit code 0, no scan lost",
        stop_during_long_work,
    ),
    Attack(
        "SIGTERM while waiting for the database",
        "nothing waited for a database",
        "10 s, exit code 0",
        stop_while_waiting,
    ),
]
