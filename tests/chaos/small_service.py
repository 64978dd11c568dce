"""A small service to attack: one process, one small scenario, scans for it."""

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2

from tests.support.replicas import Replica
from tests.support.serving import data_scenario, scan_of

_TIMEOUT = 120.0


@contextmanager
def service(url: str, folder: Path) -> Iterator[Replica]:
    """Run one process of the service on a database."""
    replica = Replica(url, folder / f"voa-{secrets.token_hex(4)}.log")
    try:
        replica.start()
        yield replica
    finally:
        replica.end()


def client(replica: Replica) -> httpx2.Client:
    """Give a client that waits for long."""
    return httpx2.Client(base_url=replica.url, timeout=_TIMEOUT)


def opened(http: httpx2.Client) -> str:
    """Open a session on a small scenario; returns its id."""
    scenario = http.post("/v1/scenarios", json=data_scenario()).raise_for_status().json()["id"]
    return str(http.post("/v1/sessions", json={"scenario": scenario}).raise_for_status().json()["id"])


def scan(http: httpx2.Client, session: str, number: int = 0) -> httpx2.Response:
    """Send the scan with a number."""
    return http.post(f"/v1/sessions/{session}/scans", json=scan_of([0.5, 0.5, None, 1.0], stamp=number))
