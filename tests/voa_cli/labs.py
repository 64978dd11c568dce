"""A router and a service that is joined to it, and a way to wait for things."""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import httpx2

from tests.routers import Router
from voa_cli.local_service import running

WAIT_SECONDS = 30.0


class Lab(NamedTuple):
    """Where things are."""

    url: str
    endpoint: str
    zenoh: str


def wait_until(condition: Callable[[], bool], what: str, seconds: float = WAIT_SECONDS) -> None:
    """Returns when it holds."""
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until, f"{what}: not within {seconds} s"
        threading.Event().wait(0.02)


@contextmanager
def service_on(router: Router, folder: Path, options: Sequence[str] = (), *, joined: bool = True) -> Iterator[Lab]:
    """`voa serve --zenoh` with a router."""
    folder.mkdir(parents=True, exist_ok=True)
    more = ["--database-url", f"sqlite:///{folder / 'voa.db'}", "--zenoh", router.endpoint, *options]
    with running("voa_service", more, folder / "service.log") as service:
        if joined:
            wait_until(
                lambda: httpx2.get(f"{service.url}/readyz").json()["zenoh"] == "connected", "the service joins the router"
            )
        yield Lab(service.url, router.endpoint, f"zenoh://127.0.0.1:{router.port}")
