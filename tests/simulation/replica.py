"""A simulated process of the service: the production use cases on the production store, until it dies."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Protocol

from sqlalchemy.exc import DBAPIError

from tests.simulation.robot import IDLE, ROBOT_NAME, SimulatedRobot
from tests.simulation.scheduler import Owner, Scheduler
from voa_service.mapping.models import Model, Models
from voa_service.runtime.cache import Cache
from voa_service.runtime.changes import Changes
from voa_service.runtime.steady import SteadyClock
from voa_service.settings import Limits
from voa_service.usecases.claims import Claims
from voa_service.usecases.looks import AnnouncedLooks
from voa_service.usecases.places import LookedFrom
from voa_service.usecases.retention import Retention
from voa_service.usecases.robots import Robots
from voa_service.usecases.scenarios import Scenarios
from voa_service.usecases.sessions import Sessions
from voa_service.usecases.updates import Updates
from voa_store.drivers import sqlite_driver
from voa_store.errors import StoreError
from voa_store.records import SessionState
from voa_store.sql import SqlStore

START = datetime(2026, 1, 1, tzinfo=UTC)
_CACHE_BYTES = 2**22
_RETENTION_SECONDS = 20.0
_PAUSE_SECONDS = 0.001
_RESPONSE_DAYS = 1.0
_RESTART_SECONDS = 1.0


@dataclass(frozen=True)
class UseCases:
    """The use cases of one process, as `voa_service.bootstrap` builds them, without its threads."""

    store: SqlStore
    models: Models
    scenarios: Scenarios
    sessions: Sessions
    updates: Updates
    looks: AnnouncedLooks
    claims: Claims
    retention: Retention


def use_cases(
    store: SqlStore,
    now: Callable[[], datetime],
    ids: Callable[[], str],
    changes: Changes,
    robots: Robots,
    seconds: Callable[[], float] = lambda: 0.0,
) -> UseCases:
    """Build the use cases on a store.

    Args:
        store: of all content.
        now: wall clock.
        ids: source of ids.
        changes: announces commits.
        robots: mapped robots.
        seconds: clock that is never set, seconds.
    """
    cache = Cache(_CACHE_BYTES)
    models, claims, limits = Models(store, cache), Claims(store, robots), Limits()
    sessions = Sessions(
        store, models, now, ids, Cache(_CACHE_BYTES), changes.committed, claims.check, limits.history_bytes
    )
    return UseCases(
        store,
        models,
        Scenarios(store, models, {}, limits, now),
        sessions,
        Updates(sessions, LookedFrom(store, cache), lambda *_: None, lambda *_, **__: None),
        AnnouncedLooks(sessions),
        claims,
        Retention(store, sessions.delete_version, SteadyClock(now, seconds), None, _RESPONSE_DAYS),
    )


class Witness(Protocol):
    """Records what processes do."""

    def published(self, replica: str, session: str, state: SessionState | None) -> None:
        """Record that a process announced a commit: the session's new state, or None where it was deleted."""

    def settled(self, session: str | None, began: float) -> None:
        """Record the session that the robot's look belongs to, and when a process began to search for it."""

    def applied(self, number: int, session: str, result: str) -> None:
        """Record the result of a look of the robot in a process."""


class Replica(Owner):
    """A process that starts, serves, dies at any step, and is started again.

    Args:
        name: for the trace.
        scheduler: of its tasks.
        url: of the database that all replicas share.
        models: built models by scenario, which each process keeps from its start on.
        witness: records what the process does.
    """

    def __init__(
        self,
        name: str,
        scheduler: Scheduler,
        url: str,
        models: dict[str, Model],
        witness: Witness,
    ) -> None:
        super().__init__(name, on_crash=self.crash)
        self.inside: UseCases | None = None
        self.skew = 0.0
        self.life = 0
        self._scheduler = scheduler
        self._url = url
        self._models = models
        self._witness = witness
        self._store: SqlStore | None = None
        self._ids = 0
        self.robot: SimulatedRobot | None = None
        self.crashes: list[int] = []
        """Steps after which the process dies, each counted from its start or from when the first was planned."""

    def plan_crash(self) -> None:
        """Let the process die after the next number of steps in `crashes`, if there is one."""
        self.crash_at = self.steps + self.crashes.pop(0) if self.crashes else None

    def now(self) -> datetime:
        """Read the clock of this process, which may be wrong."""
        return START + timedelta(seconds=self._scheduler.now + self.skew)

    def start(self) -> None:
        """Start the process, in a task of its own."""
        self.life += 1
        self._scheduler.spawn(f"{self.name}.{self.life}/main", self._main, self)

    def crash(self) -> None:
        """Kill the process, and start it again a little later."""
        self._scheduler.note("dies", self.name)
        self.inside = self.robot = None
        self._scheduler.kill(self)
        if self._store is not None:
            self._store.close()
            self._store = None
        self.plan_crash()
        self._scheduler.at(_RESTART_SECONDS, self.start)

    def close(self) -> None:
        """End the process in order."""
        if self._store is not None:
            self._store.close()

    def _id(self) -> str:
        self._ids += 1
        return f"{self.name}{self.life}n{self._ids}"

    def _main(self) -> None:
        try:
            store = self._store = SqlStore(self._url, seconds=lambda: self.now().timestamp())
        except (StoreError, DBAPIError, sqlite_driver().Error) as error:
            self._scheduler.note(f"cannot start: {error}")
            self._scheduler.at(_RESTART_SECONDS, self.start)
            return
        changes = Changes()
        robots = Robots(self.now, store.robot_session)
        inside = use_cases(store, self.now, self._id, changes, robots, lambda: self._scheduler.now)
        for id_, model in self._models.items():
            inside.models.keep(id_, model)
        with changes.listening(lambda session, state: self._witness.published(self.name, session, state)):
            self.inside = inside
            self.robot = self._robot(inside, robots)
            while True:
                self._scheduler.pause(_RETENTION_SECONDS)
                with suppress(StoreError):  # as `runtime.periodic`: the next round tries again
                    inside.retention.apply(lambda _: self._scheduler.pause(_PAUSE_SECONDS))

    def _robot(self, inside: UseCases, robots: Robots) -> SimulatedRobot:
        """Map the robot to the scenario, and begin to apply its looks."""
        (scenario,) = self._models
        robots.mapped(ROBOT_NAME, "scan", IDLE, scenario=scenario)
        robot = SimulatedRobot(
            self._scheduler, scenario, inside.claims, inside.updates, self._witness.settled, self._witness.applied
        )
        self._scheduler.spawn(f"{self.name}.{self.life}/robot", robot.run, self)
        return robot
