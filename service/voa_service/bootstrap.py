"""The composition root: builds the use cases, their queues and caches from the settings."""

import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial
from typing import NamedTuple

import structlog
from threadpoolctl import threadpool_limits

from voa_assets import lidar_presets
from voa_connections.settings import MEBIBYTE
from voa_msgs.lidars import LidarPreset
from voa_service.access.audit import record_write
from voa_service.access.callers import RETENTION
from voa_service.access.gate import Gate
from voa_service.access.keyring import Keyring
from voa_service.access.rates import Rates
from voa_service.guard import guarded
from voa_service.mapping.models import Models
from voa_service.mapping.rules import load_installed_rules
from voa_service.meshes.reader import SubprocessMeshReader
from voa_service.ports import Clock, IdSource
from voa_service.requests.bodies import Reader
from voa_service.runtime.cache import Cache
from voa_service.runtime.changes import Changes
from voa_service.runtime.feeds import Feeds
from voa_service.runtime.memory import MemoryBudget, available_memory, budget, processors
from voa_service.runtime.metrics import Metrics
from voa_service.runtime.periodic import Periodic
from voa_service.runtime.queues import Threads, WorkQueue
from voa_service.runtime.steady import SteadyClock
from voa_service.runtime.stopping import Drain
from voa_service.services import Services
from voa_service.settings import Settings
from voa_service.usecases.acting import ActingRobots
from voa_service.usecases.claims import Claims
from voa_service.usecases.following import versions_since
from voa_service.usecases.health import HealthCheck
from voa_service.usecases.looks import AnnouncedLooks
from voa_service.usecases.objects import Objects
from voa_service.usecases.places import LookedFrom
from voa_service.usecases.rankings import Rankings
from voa_service.usecases.retention import Retention
from voa_service.usecases.robots import Robots
from voa_service.usecases.scenarios import Scenarios
from voa_service.usecases.sessions import Sessions
from voa_service.usecases.updates import Updates
from voa_store.errors import CannotOpen, StoreError
from voa_store.sql import SqlStore
from voa_store.starting import open_store

_READERS, _WRITERS, _FEEDERS = 4, 8, 2
_RETENTION_SECONDS = 3_600.0
_FIRST_RETENTION_SECONDS = 600.0
"""Time in which the network usually sets the clock of a machine that has just started."""
_PROBES_WAITING = 32
_END_SECONDS = 4.0
"""Time that the end of the process waits for threads; one that still works then is abandoned."""
_DRAIN_SECONDS = 3.0
"""Time that rankings may go on once the service stops."""
_RANKINGS_BYTES = 16 * MEBIBYTE
_RESPONSES_BYTES = 16 * MEBIBYTE


def utc_now() -> datetime:
    """Return the current time, in UTC."""
    return datetime.now(UTC)


def new_id() -> str:
    """Return a new random id of 16 hexadecimal digits."""
    return secrets.token_hex(8)


@contextmanager
def services(settings: Settings, now: Clock = utc_now, ids: IdSource = new_id) -> Iterator[Services]:
    """Build the use cases and queues behind the entrypoints; releases them at the end of the `with` block.

    Args:
        settings: of the service.
        now: clock.
        ids: source of the ids of sessions and of this process.

    Raises:
        CannotOpen: the database cannot be used.
    """
    limits = settings.limits
    store = open_store(settings.database_url, settings.database_patience_s, settings.wait_for_database)
    keyring = _keyring(store, now, required=settings.require_keys)
    memory = budget(settings, available_memory(settings), processors())
    _report(memory)
    threads = Threads(memory.workers)
    cache = Cache(memory.cache * MEBIBYTE)
    models = Models(store, cache, settings.precision, load_installed_rules())
    metrics = Metrics()
    reads = WorkQueue("read", _READERS, settings.scan_queue)
    writes = WorkQueue("write", _WRITERS, settings.scan_queue)
    probes = WorkQueue("readiness", 1, _PROBES_WAITING)
    follows = WorkQueue("follow", _FEEDERS, 2 * settings.followers)
    heavy = WorkQueue("heavy", memory.workers, settings.queue)
    meshes = WorkQueue("mesh", memory.meshes, settings.queue)
    rests = WorkQueue("stable-poses", 1, settings.queue)
    reading = WorkQueue("large", settings.readers, settings.reader_queue)
    queues = (reads, writes, probes, follows, heavy, meshes, rests, reading)
    presets = {name: LidarPreset.model_validate(preset) for name, preset in lidar_presets().items()}
    changes = Changes()
    changes.at_close(lambda: heavy.end_in(_DRAIN_SECONDS))
    store.listen(changes.changed)
    store.measure(metrics.store)
    robots = Robots(now, store.robot_session)
    metrics.robots(robots.ages)
    claims = Claims(store, robots)
    sessions = Sessions(
        store,
        models,
        now,
        ids,
        Cache(_RESPONSES_BYTES),
        changes.committed,
        claims.check,
        limits.history_bytes,
    )
    places = LookedFrom(store, cache)
    reader = SubprocessMeshReader(settings.mesh_seconds, memory.mesh, limits.faces)
    feeds = Feeds(
        changes,
        lambda id_, seen: follows.run(partial(guarded()(versions_since), sessions, id_, seen)),
        settings.followers,
    )
    retention = Retention(
        store, _recorded(sessions.delete_version), SteadyClock(now), settings.retention_days, settings.response_days
    )
    caretaker = Periodic("voa-retention", retention.apply, _RETENTION_SECONDS, _FIRST_RETENTION_SECONDS)
    caretaker.start()
    _gauges(metrics, cache, feeds, _Depths(reads, writes, heavy, meshes, rests, reading))
    try:
        with threadpool_limits(1, user_api="blas"):  # the work is spread over `threads`
            yield Services(
                objects=Objects(store, reader, cache, now, limits),
                scenarios=Scenarios(store, models, presets, limits, now),
                sessions=sessions,
                updates=Updates(sessions, places, metrics.observation, metrics.attempt),
                looks=AnnouncedLooks(sessions),
                rankings=Rankings(sessions, models, places, threads, Cache(_RANKINGS_BYTES), limits),
                robots=robots,
                claims=claims,
                acting=ActingRobots(claims, sessions),
                health=HealthCheck(store, now, ids(), memory.message(), drain=Drain(settings.drain_seconds)),
                changes=changes,
                metrics=metrics,
                limits=limits,
                reads=reads,
                writes=writes,
                probes=probes,
                feeds=feeds,
                reader=Reader(limits, reading),
                gate=Gate(keyring, Rates(**settings.rates.model_dump())),
                names=settings.names,
                heavy=heavy,
                meshes=meshes,
                rests=rests,
            )
    finally:
        caretaker.close()
        changes.close()
        keyring.close()
        reader.close()
        until = time.monotonic() + _END_SECONDS
        for each in (*queues, threads):
            each.close(max(0.0, until - time.monotonic()))
        store.close()


def _keyring(store: SqlStore, now: Clock, *, required: bool) -> Keyring:
    """Read the keys for the first time.

    Raises:
        CannotOpen: the database cannot be used.
    """
    try:
        return Keyring(store, now, required=required)
    except BaseException as error:
        store.close()
        if isinstance(error, StoreError):
            raise CannotOpen(str(error)) from error
        raise


def _recorded(delete: Callable[[str, int], bool]) -> Callable[[str, int], bool]:
    """Make the deletion of old sessions record each one in the audit."""

    def deleted(id_: str, version: int) -> bool:
        done = delete(id_, version)
        if done:
            record_write(RETENTION, "session.delete", 204, session=id_)
        return done

    return deleted


def _report(memory: MemoryBudget) -> None:
    """Log how much memory each part may hold; a warning where the sum exceeds the available memory."""
    log = structlog.get_logger("voa")
    figures = memory.message().model_dump()
    if memory.sum_mebibytes > memory.available.mebibytes:
        log.warning("the bounds of the service's parts exceed the available memory", **figures)
    else:
        log.info("memory of the service's parts", **figures)


class _Depths(NamedTuple):
    """Queues whose length is a gauge."""

    reads: WorkQueue
    writes: WorkQueue
    heavy: WorkQueue
    meshes: WorkQueue
    rests: WorkQueue
    reading: WorkQueue


def _gauges(metrics: Metrics, cache: Cache, feeds: Feeds, queues: _Depths) -> None:
    metrics.gauge("voa_large_requests", "Large request bodies being parsed or waiting.", lambda: queues.reading.inside)
    metrics.gauge("voa_read_requests", "Reading requests under way or waiting.", lambda: queues.reads.inside)
    metrics.gauge("voa_write_requests", "Scans and other writes under way or waiting.", lambda: queues.writes.inside)
    heavy = "Rankings and other heavy requests under way or waiting."
    metrics.gauge("voa_heavy_requests", heavy, lambda: queues.heavy.inside)
    metrics.gauge("voa_mesh_requests", "Mesh files being read or waiting to be read.", lambda: queues.meshes.inside)
    rests = "Computations of stable poses under way or waiting."
    metrics.gauge("voa_rest_requests", rests, lambda: queues.rests.inside)
    metrics.gauge("voa_cache_bytes", "Bytes of cuts, predictions and weights in the cache.", lambda: cache.held)
    metrics.gauge("voa_followers", "Open event streams.", lambda: feeds.followers)
    metrics.gauge("voa_watched_sessions", "Sessions that have a follower.", lambda: feeds.watched)
