"""Lets the production store run in a simulation: its engines pause at every statement, and wait in virtual time.

The database is a real SQLite file, in memory where the machine has a file system there. A process that dies loses its
open transaction, as SQLite's own recovery would have it; committed rows stay. The loss of power is not simulated.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any
from unittest.mock import patch

from sqlalchemy import Connection, Engine, RootTransaction, create_engine, event
from sqlalchemy.pool import ConnectionPoolEntry, QueuePool

import voa_service.runtime.cache
import voa_store.engines
import voa_store.grouping
import voa_store.sql
from tests.simulation.scheduler import Killed, Scheduler, Signal
from voa_store.drivers import sqlite_driver
from voa_store.engines import Engines, transaction
from voa_store.errors import StoreError
from voa_store.removal import remove_some

_PATIENCE_SECONDS = 10.0
"""Virtual time that a call waits for a connection, or for the write lock."""
_REMOVED_ROWS = 8
_RETRY_SECONDS = 1.0


class Disk:
    """The lock of writers on the database's file, and its errors.

    Args:
        scheduler: of the tasks.
        errors: probability that a statement or commit fails.
    """

    def __init__(self, scheduler: Scheduler, errors: float) -> None:
        self.scheduler = scheduler
        self.errors = errors
        self.holder: object | None = None
        self.released = Signal()

    def lock(self, holder: object) -> None:
        """Wait until no transaction writes; after the patience SQLite itself says that the file is locked."""
        end = self.scheduler.now + _PATIENCE_SECONDS
        while self.holder is not None and self.scheduler.now < end:
            self.scheduler.wait(self.released, end - self.scheduler.now)
        if self.holder is None:
            self.holder = holder

    def unlock(self, holder: object) -> None:
        """Let another transaction write, if `holder` did."""
        if self.holder is holder:
            self.holder = None
            self.scheduler.notify(self.released)

    def fail_sometimes(self) -> None:
        """Raise the driver's error for a broken disk, with the probability of this run."""
        task = self.scheduler.current
        if task is not None and task.owner is not None and not task.dead and task.random.random() < self.errors:
            self.scheduler.note("disk I/O error")
            raise sqlite_driver().OperationalError("disk I/O error")

    def check_alive(self) -> None:
        """Raise Killed in a task whose process has died: whatever it does on its way out does not reach the file."""
        task = self.scheduler.current
        if task is not None and task.dead:
            raise Killed


@contextmanager
def simulated(scheduler: Scheduler, disk: Disk) -> Iterator[None]:
    """Let every store that is opened within the `with` block run on the scheduler."""
    pool = type("Pool", (SimulatedPool,), {"scheduler": scheduler, "disk": disk})

    def create(url: Any, **options: Any) -> Engine:
        engine = create_engine(url, poolclass=pool, connect_args={"timeout": 0}, **options)
        if options["pool_size"] == 1:  # the writer's
            event.listen(engine, "begin", lambda _: disk.lock(engine.pool))
        event.listen(engine, "before_cursor_execute", _before_statement(disk))
        event.listen(engine, "commit", _before_commit(disk))
        return engine

    def computed(pending: Any, check: Callable[[], None]) -> Any:
        while not pending.done():
            scheduler.step("waits for a value of the cache")
            check()
        return pending.result()

    with ExitStack() as stack:
        for module, name, value in (
            (voa_store.engines, "create_engine", create),
            (voa_store.engines, "_BUSY_MS", 0),
            (voa_store.sql, "Remover", _remover_type(scheduler)),
            (voa_store.grouping, "Latch", partial(SimulatedLatch, scheduler)),
            (voa_service.runtime.cache, "_result", computed),
        ):
            stack.enter_context(patch.object(module, name, value))
        yield


def _before_statement(disk: Disk) -> Callable[..., None]:
    def before(_connection: Connection, _cursor: Any, text: str, *_: Any) -> None:
        disk.check_alive()
        disk.scheduler.step(text[:60].replace("\n", " "))
        disk.fail_sometimes()

    return before


def _before_commit(disk: Disk) -> Callable[[Connection], None]:
    def before(_connection: Connection) -> None:
        disk.check_alive()
        disk.scheduler.step("COMMIT")
        disk.fail_sometimes()

    return before


class SimulatedLatch:
    """Signal that one task waits for in virtual time, and another gives once.

    Args:
        scheduler: of the tasks.
    """

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._given = Signal()
        self._is_open = False

    def wait(self, seconds: float | None = None) -> bool:
        """Wait for the signal, for so many seconds of virtual time (None: no bound)."""
        end = math.inf if seconds is None else self._scheduler.now + seconds
        while not self._is_open and self._scheduler.now < end:
            self._scheduler.wait(self._given, min(end - self._scheduler.now, _PATIENCE_SECONDS))
        return self._is_open

    def open(self) -> None:
        """Give the signal."""
        self._is_open = True
        self._scheduler.notify(self._given)


class SimulatedPool(QueuePool):
    """Connections for which tasks wait in virtual time; each run makes a class of its own.

    Attributes:
        scheduler: of the tasks.
        disk: that the connections write to.
    """

    scheduler: Scheduler
    disk: Disk

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options | {"timeout": 0})
        self._free = Signal()
        self._late: dict[RootTransaction, Connection] = {}
        """Transactions of `commit_delayed` that are still open."""

    def commit_delayed(self, begun: RootTransaction, connection: Connection) -> None:
        """Commit a transaction in another task: a fault that `faults` plants, and no part of the store."""

        self._late[begun] = connection

        def commit() -> None:
            self.scheduler.step("is about to commit")
            del self._late[begun]
            with connection:
                begun.commit()

        task = self.scheduler.current
        if task is None:
            commit()
        else:
            self.scheduler.spawn(f"{task.name.partition('/commit')[0]}/commit", commit, task.owner)

    def dispose(self) -> None:
        """Roll back what a dead process has not committed, and close the connections that nobody uses."""
        late, self._late = self._late, {}
        for begun, connection in late.items():
            with connection:
                begun.rollback()
        super().dispose()

    def _do_get(self) -> ConnectionPoolEntry:
        self.disk.check_alive()
        self.scheduler.step("connects")
        end = self.scheduler.now + _PATIENCE_SECONDS
        while self.scheduler.current is not None and self.checkedout() >= self.size() and self.scheduler.now < end:
            self.scheduler.wait(self._free, end - self.scheduler.now)
        return super()._do_get()

    def _do_return_conn(self, record: ConnectionPoolEntry) -> None:
        super()._do_return_conn(record)
        self.disk.unlock(self)
        self.scheduler.notify(self._free)
        self.scheduler.step("has left the database")
        if self.size() == 1:  # the commit is done, and yet an error is reported
            self.disk.fail_sometimes()


def _remover_type(scheduler: Scheduler) -> type:
    class Remover:
        """Removes the rows of deleted sessions in a task, as `voa_store.removal.Remover` does in a thread."""

        def __init__(self, engines: Engines) -> None:
            self._engines = engines
            self._running = False

        def wake(self) -> None:
            task = scheduler.current
            if not self._running and task is not None and task.owner is not None:
                self._running = True
                scheduler.spawn(f"{task.name}/remover", self._run, task.owner)

        wake_if_needed = wake

        def close(self) -> None:
            """Do nothing: the task dies with its process."""

        def _run(self) -> None:
            more = True
            while more:
                try:
                    with transaction(self._engines.writer) as connection:
                        more = remove_some(connection, _REMOVED_ROWS)
                except StoreError:
                    scheduler.pause(_RETRY_SECONDS)
            self._running = False

    return Remover
