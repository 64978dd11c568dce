"""Meshes, scenarios, sessions and writes to keep in a store, and calls that begin at the same moment."""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from threading import Barrier
from typing import Any, NamedTuple, TypeVar

import numpy as np
from sqlalchemy import Engine, create_engine

from tests.voa_core.worlds import BOX_FACES
from voa_core.filtering import Belief
from voa_core.objects import Object
from voa_service.ports import Store
from voa_store.drivers import sqlite_driver
from voa_store.errors import SessionMissing
from voa_store.records import (
    IdempotencyKey,
    SessionState,
    StoredObject,
    StoredResponse,
    StoredScenario,
    Upload,
    Write,
    WriteKind,
)

T = TypeVar("T")
Open = Callable[[], Store]

NOON = datetime(2026, 1, 2, 12, 0, 0, 123456, tzinfo=UTC)
THREADS = 4


def engine_of(url: str) -> Engine:
    """An engine beside the store's, by the same driver: two SQLites in one process undo each other's locks."""
    return create_engine(url, module=sqlite_driver()) if url.startswith("sqlite") else create_engine(url)


def mesh(size: float = 0.05) -> Object:
    corners = [[x * size, y / 3.0, z * math.pi] for x in (-1, 1) for y in (-1, 1) for z in (0, 1)]
    return Object.from_arrays(corners, BOX_FACES)


def stored_mesh(size: float = 0.05, name: str = "box") -> StoredObject:
    return StoredObject(mesh(size), name, NOON)


def scenario(id_: str, name: str = "name") -> StoredScenario:
    return StoredScenario(id_, name, f'{{"name": "{id_}", "data": "ü\\u0000"}}', NOON)


def belief(*p: float) -> Belief:
    given = np.array(p or (0.25, 0.75))
    with np.errstate(divide="ignore"):
        return Belief(given, np.log(given))


def session(id_: str = "S") -> SessionState:
    return SessionState(id_, "A", 0, belief(), belief(), None, NOON, NOON)


def key(name: str = "K", scope: str = "session:S", fingerprint: str = "F") -> IdempotencyKey:
    return IdempotencyKey(scope, name, fingerprint)


def write(
    named: IdempotencyKey | None = None,
    if_match: frozenset[int] | None = None,
    request: str = "{}",
    kind: WriteKind = "scan",
) -> Write:
    return Write(kind, request, named, if_match)


def create(
    store: Store,
    id_: str = "S",
    named: IdempotencyKey | None = None,
    robots: Sequence[str] = (),
    of: str = "A",
) -> StoredResponse:
    """Open a session on the scenario `of`, for robots."""
    state = replace(session(id_), scenario=of)
    return store.create_session(state, write(named, kind="prior"), StoredResponse(f"created {id_}", 0), robots)


class Result(NamedTuple):
    """Result of a step, the body of a write: the arguments of `SessionChange.respond`."""

    response: StoredResponse
    after: SessionState | None = None
    report: str | None = None


def change(store: Store, id_: str, write: Write, step: Callable[[SessionState], Result]) -> StoredResponse | None:
    """Apply a write by a step; None: there is no such session."""
    try:
        return store.change(id_, write, lambda change, state: change.respond(*step(state))).response
    except SessionMissing:
        return None


def next_version(state: SessionState) -> Result:
    """Accept: the session gets its next version."""
    version = state.version + 1
    after = replace(state, version=version, updated_at=NOON + timedelta(seconds=version))
    return Result(StoredResponse(f"v{version}", version), after, f'"report {version}"')


def looking(looks: str | None) -> Callable[[SessionState], Result]:
    """Make a step that accepts a look, after which the record of looks is the given text."""

    def step(state: SessionState) -> Result:
        response, after, report = next_version(state)
        assert after is not None
        return Result(response, replace(after, looks=looks), report)

    return step


def announcing(under_way: str | None) -> Callable[[SessionState], Result]:
    """Make a step that sets the announced looks of a session, which makes no version."""

    def step(state: SessionState) -> Result:
        return Result(StoredResponse(f"announced {under_way}", state.version), replace(state, under_way=under_way))

    return step


def refuse(state: SessionState) -> Result:
    """Respond without changing the session."""
    return Result(StoredResponse(f"refused at v{state.version}", state.version), report='"refused"')


def never(state: SessionState) -> Result:
    raise AssertionError("the step must not run")


def at_once(calls: Sequence[Callable[[], T]]) -> list[T]:
    """The results of calls that begin at the same moment, each in a thread of its own."""
    barrier = Barrier(len(calls))

    def begin(call: Callable[[], T]) -> T:
        barrier.wait()
        return call()

    with ThreadPoolExecutor(len(calls)) as pool:
        return list(pool.map(begin, calls))


def upload(**changes: Any) -> Upload:
    """Make an uploaded file, with some fields changed."""
    return replace(Upload("0" * 64, "obj", 0.1 + 0.2, "+Z"), **changes)
