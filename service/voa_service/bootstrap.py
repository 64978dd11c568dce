"""The composition root: builds the service from its settings. Nothing is built anywhere else."""

import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial

import structlog
from threadpoolctl import threadpool_limits

from voa_assets import lidar_presets
from voa_msgs.lidars import LidarPreset
from voa_service.mapping.models import Models
from voa_service.mapping.rules import load_installed_rules
from voa_service.meshes.reader import SubprocessMeshReader
from voa_service.ports import Clock, IdSource
from voa_service.requests.reading import Reader
from voa_service.runtime.cache import Cache
from voa_service.runtime.changes import Changes
from voa_service.runtime.feeds import Feeds
from voa_service.runtime.memory import MemoryBudget, budget, find, processors
from voa_service.runtime.metrics import Metrics
from voa_service.runtime.queues import Threads, WorkQueue
from voa_service.services import Services
from voa_service.settings import MEBIBYTE, Settings
from voa_service.usecases.claims import Claims
from voa_service.usecases.following import versions_since
from voa_service.usecases.health import HealthCheck
from voa_service.usecases.objects import Objects
from voa_service.usecases.rankings import Rankings
from voa_service.usecases.robots import Robots
from voa_service.usecases.scenarios import Scenarios
from voa_service.usecases.sessions import Sessions
from voa_store.starting import open_store

_READERS, _WRITERS, _FEEDERS = 4, 8, 2
_PROBES_WAITING = 32
_END_SECONDS = 4.0
"""How long threads are waited for at the end; one that still works then is left behind."""
_DRAIN_SECONDS = 3.0
"""How long rankings may go on once the service is told to end."""
_ANSWERS_BYTES = 16 * MEBIBYTE
_TOLD_BYTES = 16 * MEBIBYTE


def utc_now() -> datetime:
    """The time."""
    return datetime.now(UTC)


def new_id() -> str:
    """A name that nobody has yet."""
    return secrets.token_hex(8)


@contextmanager
def services(settings: Settings, now: Clock = utc_now, ids: IdSource = new_id) -> Iterator[Services]:
    """Everything behind the entrypoints; released on leaving."""
    limits = settings.limits
    store = open_store(settings.database_url, settings.database_patience_s, settings.wait_for_database)
    memory = budget(settings, find(settings), processors())
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
    metrics.gauge("voa_large_requests", "Large bodies being read or waiting for it.", lambda: reading.inside)
    presets = {name: LidarPreset.model_validate(preset) for name, preset in lidar_presets().items()}
    changes = Changes()
    changes.at_close(lambda: heavy.end_in(_DRAIN_SECONDS))
    store.listen(changes.moved)
    robots = Robots(now, store.robot_session)
    claims = Claims(store, robots)
    sessions = Sessions(
        store,
        models,
        now,
        ids,
        Cache(_TOLD_BYTES),
        changes.committed,
        metrics.observation,
        claims.check,
        limits.history_bytes,
    )
    reader = SubprocessMeshReader(settings.mesh_seconds, memory.mesh, limits.faces)
    feeds = Feeds(
        changes, lambda id_, seen: follows.run(partial(versions_since, sessions, id_, seen)), settings.followers
    )
    _gauges(metrics, cache, feeds)
    metrics.gauge("voa_read_requests", "Reads under way or waiting.", lambda: reads.inside)
    metrics.gauge("voa_write_requests", "Scans and other writes under way or waiting.", lambda: writes.inside)
    metrics.gauge("voa_heavy_requests", "Rankings and the like under way or waiting.", lambda: heavy.inside)
    metrics.gauge("voa_mesh_requests", "Mesh files being read or waiting.", lambda: meshes.inside)
    metrics.gauge("voa_rest_requests", "Stable poses under way or waiting.", lambda: rests.inside)
    try:
        with threadpool_limits(1, user_api="blas"):  # the work is spread over `threads`
            yield Services(
                objects=Objects(store, reader, cache, now, limits),
                scenarios=Scenarios(store, models, presets, limits, now),
                sessions=sessions,
                rankings=Rankings(sessions, models, threads, Cache(_ANSWERS_BYTES), limits),
                robots=robots,
                claims=claims,
                health=HealthCheck(store, now, ids(), memory.message()),
                changes=changes,
                metrics=metrics,
                limits=limits,
                reads=reads,
                writes=writes,
                probes=probes,
                feeds=feeds,
                reader=Reader(limits, reading),
                names=settings.names,
                heavy=heavy,
                meshes=meshes,
                rests=rests,
            )
    finally:
        changes.close()
        reader.close()
        until = time.monotonic() + _END_SECONDS
        for each in (*queues, threads):
            each.close(max(0.0, until - time.monotonic()))
        store.close()


def _report(memory: MemoryBudget) -> None:
    """Log what the parts may hold, as a warning where that is more than there is."""
    log = structlog.get_logger("voa")
    figures = memory.message().model_dump()
    if memory.sum_mebibytes > memory.found.mebibytes:
        log.warning("the parts of the service may hold more memory than there is", **figures)
    else:
        log.info("memory", **figures)


def _gauges(metrics: Metrics, cache: Cache, feeds: Feeds) -> None:
    metrics.gauge("voa_cache_bytes", "Memory held by cuts, predictions and weights.", lambda: cache.held)
    metrics.gauge("voa_followers", "Event streams that are open.", lambda: feeds.followers)
    metrics.gauge("voa_watched_sessions", "Sessions that somebody follows.", lambda: feeds.watched)
