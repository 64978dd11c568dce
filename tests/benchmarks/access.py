"""Cost of a key: CPU time that the check adds to a request, and that a line of the audit adds to a write.

    python -m tests.benchmarks.access

Proves that keys need no query and no slow hash: a few microseconds, where a scan update takes milliseconds. The request
passes through the middleware alone, in front of an application that does nothing; medians of seven runs.
"""

import asyncio
import io
import logging
import statistics
import time
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

from voa_connections.asgi import Message, Receive, Scope, Send
from voa_service.access.gate import Gate
from voa_service.access.keyring import Keyring
from voa_service.access.keys import new_key
from voa_service.access.rates import Rates
from voa_service.bootstrap import utc_now
from voa_service.http.authentication import Authentication
from voa_service.runtime import logs
from voa_store.records import StoredKey

KEYS, RUNS, REQUESTS = 50, 7, 5_000
RATE = "1000000000/second"
NEVER_S = 3_600.0


class Shelf:
    """A store of keys in memory."""

    def __init__(self, keys: list[StoredKey]) -> None:
        self.keys = keys

    def list_keys(self) -> list[StoredKey]:
        return self.keys

    def keys_used(self, used: Mapping[str, datetime]) -> None:
        """Store nothing."""


async def nothing(scope: Scope, receive: Receive, send: Send) -> None:
    """An application that begins its response, and does nothing else."""
    await send({"type": "http.response.start", "status": 200, "headers": [(b"etag", b'"v3"')]})


async def silence() -> Message:
    return {"type": "http.disconnect"}


async def drop(message: Message) -> None:
    """Send nothing."""


def microseconds(application: Callable[..., Any], scope: dict[str, Any]) -> float:
    """CPU time of a request."""

    async def requests() -> None:
        for _ in range(REQUESTS):
            await application(dict(scope), silence, drop)

    times = []
    for _ in range(RUNS):
        began = time.process_time()
        asyncio.run(requests())
        times.append(1e6 * (time.process_time() - began) / REQUESTS)
    return statistics.median(times)


def main() -> None:
    """Print the table."""
    logs.configure("INFO", io.StringIO())
    made = [new_key() for _ in range(KEYS)]
    stored = [StoredKey(each.id, each.digest, f"k{each.id}", "operator", utc_now()) for each in made]
    rings = [Keyring(Shelf(keys), utc_now, NEVER_S) for keys in ([], stored)]
    without, closed = (Authentication(nothing, Gate(ring, Rates(RATE, RATE, RATE))) for ring in rings)
    headers = [(b"host", b"127.0.0.1"), (b"authorization", f"Bearer {made[7].text}".encode())]
    read = {"type": "http", "method": "GET", "path": "/v1/sessions/0123456789abcdef", "headers": headers}
    write = read | {"method": "POST", "path": "/v1/sessions/0123456789abcdef/scans"}
    bare = microseconds(nothing, read)
    print(f"read, a service without keys    {microseconds(without, read) - bare:5.1f} us")
    print(f"read with a key                 {microseconds(closed, read) - bare:5.1f} us")
    print(f"write with a key, audit logged  {microseconds(closed, write) - bare:5.1f} us")
    logging.getLogger().setLevel("WARNING")
    print(f"write with a key, no audit      {microseconds(closed, write) - bare:5.1f} us")
    for ring in rings:
        ring.close()


if __name__ == "__main__":
    main()
