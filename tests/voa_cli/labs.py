"""A service that is joined to a router."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import httpx2

from tests.support.routers import Router
from tests.support.waiting import wait_for
from voa_client.local import running


class Lab(NamedTuple):
    """Addresses of a service: its URL, its router's endpoint, and its options for Zenoh."""

    url: str
    endpoint: str
    zenoh: str


@contextmanager
def service_on(router: Router, folder: Path, options: Sequence[str] = (), *, joined: bool = True) -> Iterator[Lab]:
    """`voa serve --zenoh` with a router."""
    folder.mkdir(parents=True, exist_ok=True)
    more = ["--database-url", f"sqlite:///{folder / 'voa.db'}", "--zenoh", router.endpoint, *options]
    with running("voa_service", more, folder / "service.log") as service:
        if joined:
            wait_for(
                lambda: httpx2.get(f"{service.url}/readyz").json()["zenoh"] == "connected",
                "the service joins",
            )
        yield Lab(service.url, router.endpoint, f"zenoh://127.0.0.1:{router.port}")
