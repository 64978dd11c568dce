"""The composition root: builds the service from its settings. Nothing is built anywhere else."""

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime

from threadpoolctl import threadpool_limits

from voa_assets import lidar_presets
from voa_msgs.lidars import LidarPreset
from voa_service.cache import Cache
from voa_service.changes import Changes
from voa_service.compute import Threads, WorkQueue
from voa_service.meshes.reader import SubprocessMeshReader
from voa_service.metrics import Metrics
from voa_service.models import Models
from voa_service.ports import Clock, IdSource
from voa_service.reading import Reader
from voa_service.services import Services
from voa_service.settings import MEBIBYTE, Settings
from voa_service.store.sql import SqlStore
from voa_service.usecases.claims import Claims
from voa_service.usecases.health import HealthCheck
from voa_service.usecases.objects import Objects
from voa_service.usecases.rankings import Rankings
from voa_service.usecases.robots import Robots
from voa_service.usecases.scenarios import Scenarios
from voa_service.usecases.sessions import Sessions

_QUICK_WORKERS = 8
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
    store = SqlStore(settings.database_url)
    threads = Threads(settings.workers)
    cache = Cache(settings.cache_mebibytes * MEBIBYTE)
    models = Models(store, cache)
    metrics = Metrics()
    quick = WorkQueue("quick", _QUICK_WORKERS, settings.scan_queue)
    heavy = WorkQueue("heavy", settings.workers, settings.queue)
    reading = WorkQueue("large", settings.readers, settings.reader_queue)
    rests = WorkQueue("stable-poses", 1, settings.queue)
    metrics.gauge("voa_cache_bytes", "Memory held by cuts, predictions and weights.", lambda: cache.held)
    metrics.gauge("voa_quick_requests", "Scans and reads under way or waiting.", lambda: quick.inside)
    metrics.gauge("voa_heavy_requests", "Rankings and the like under way or waiting.", lambda: heavy.inside)
    metrics.gauge("voa_rest_requests", "Stable poses under way or waiting.", lambda: rests.inside)
    metrics.gauge("voa_large_requests", "Large bodies being read or waiting for it.", lambda: reading.inside)
    presets = {name: LidarPreset.model_validate(preset) for name, preset in lidar_presets().items()}
    changes = Changes()
    store.listen(changes.moved)
    robots = Robots(now, store.robot_session)
    claims = Claims(store, robots)
    sessions = Sessions(
        store, models, now, ids, Cache(_TOLD_BYTES), changes.committed, metrics.observation, claims.check
    )
    reader = SubprocessMeshReader(settings.mesh_seconds, settings.mesh_mebibytes, limits.faces)
    try:
        with threadpool_limits(1, user_api="blas"):  # the work is spread over `threads`
            yield Services(
                objects=Objects(store, reader, cache, now, limits),
                scenarios=Scenarios(store, models, presets, limits, now),
                sessions=sessions,
                rankings=Rankings(sessions, models, threads),
                robots=robots,
                claims=claims,
                health=HealthCheck(store, now, ids()),
                changes=changes,
                metrics=metrics,
                limits=limits,
                reader=Reader(limits, reading),
                names=settings.names,
                quick=quick,
                heavy=heavy,
                rests=rests,
            )
    finally:
        changes.close()
        quick.close()
        heavy.close()
        rests.close()
        reading.close()
        threads.close()
        store.close()
