"""Services to measure: started as a laboratory starts them, with durable databases and the default log level."""

import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.support import postgres
from tests.support.balancer import balancer
from tests.support.replicas import replicas
from tests.support.routers import router
from tests.support.waiting import wait_for


@dataclass(frozen=True)
class Target:
    """A service that robots can be sent to.

    Attributes:
        url: at which robots call it.
        pids: its processes by part: "service", "database", "balancer".
        key: of the caller; None: the service has no keys.
        zenoh: endpoint of the router on which robots put their scans; None: they send them by HTTP.
    """

    url: str
    pids: Mapping[str, list[int]]
    key: str | None = None
    zenoh: str | None = None


@contextmanager
def on_sqlite(folder: Path) -> Iterator[Target]:
    """Run one process on SQLite."""
    with replicas(f"sqlite:///{folder / 'voa.db'}", folder) as (own,):
        yield Target(own.url, {"service": [own.pid]})


@contextmanager
def with_a_key(folder: Path) -> Iterator[Target]:
    """Run one process on SQLite that all robots call with one key, under the default rate of a key."""
    database = f"sqlite:///{folder / 'voa.db'}"
    command = [sys.executable, "-m", "voa_cli.main", "keys", "create", "load", "--role", "operator"]
    made = subprocess.run([*command, "--database-url", database], check=True, capture_output=True, text=True)
    with replicas(database, folder) as (own,):
        yield Target(own.url, {"service": [own.pid]}, made.stdout.strip())


@contextmanager
def on_postgres(folder: Path) -> Iterator[Target]:
    """Run one process on PostgreSQL."""
    with postgres.server(durable=True) as server, replicas(server.new_database(), folder) as (own,):
        yield Target(own.url, {"service": [own.pid], "database": server.pids[-1:]})


@contextmanager
def two_replicas(folder: Path) -> Iterator[Target]:
    """Run two processes on one PostgreSQL, behind HAProxy."""
    with (
        postgres.server(durable=True) as server,
        replicas(server.new_database(), folder, 2) as both,
        balancer([own.url for own in both], folder) as front,
    ):
        pids = {"service": [own.pid for own in both], "database": server.pids[-1:], "balancer": [front.pid]}
        yield Target(front.url, pids)


@contextmanager
def on_zenoh(folder: Path) -> Iterator[Target]:
    """Run one process on SQLite that receives scans by a Zenoh router."""
    database = f"sqlite:///{folder / 'voa.db'}"
    with router() as own, replicas(database, folder, 1, "--zenoh", own.endpoint) as (replica,):
        wait_for(lambda: replica.zenoh == "connected", "the service on Zenoh")
        yield Target(replica.url, {"service": [replica.pid], "router": [own.pid]}, zenoh=own.endpoint)


Start = Callable[[Path], AbstractContextManager[Target]]
