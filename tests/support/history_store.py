"""Reads and replays what a database stores, for `tests.support.histories`."""

import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from tests.support.histories import Call, Stored, check
from tests.support.replaying import replayed
from voa_core.estimates import Estimate
from voa_core.scenario import Scenario
from voa_service.mapping.looks import record_of
from voa_service.mapping.models import Models
from voa_service.ports import Store
from voa_service.runtime.cache import Cache
from voa_store.errors import StoreError
from voa_store.records import HistoryEntry
from voa_store.sql import SqlStore


@contextmanager
def stored(database_url: str) -> Iterator[Store]:
    """Open the store on a database for the duration of a `with`."""
    store = SqlStore(database_url)
    try:
        yield store
    finally:
        store.close()


def check_answered(store: Store, calls: Sequence[Call]) -> None:
    """Assert that each version that was answered so far is stored, while writers go on.

    The versions that answered calls do not explain are those of calls under way, so that these rules are left out.
    """
    of: dict[str, list[Call]] = defaultdict(list)
    for call in calls:
        of[call.session].append(call)
    for session, own in of.items():
        known = [(call, call.version) for call in own if call.version is not None]
        least = min((version for _, version in known), default=0)
        entries = {entry.state.version: entry for entry in store.history(session, least - 1, 10**6)}
        for call, version in known:
            entry = entries.get(version)
            assert entry is not None, f"version {version} of {session} was answered and is missing"
            assert tuple(entry.state.belief.p.tolist()) == call.belief
            assert call.outcome != "made" or call.kind == "create" or entry.request == call.request


def check_stored(database_url: str, calls: Sequence[Call]) -> int:
    """Assert that calls and database do not contradict each other, after all calls have ended.

    All rules of `tests.support.histories` hold, every belief is that of the replayed history, each session's own row is
    its newest version, and all checksums are right.

    Returns:
        the number of versions that writes have made.
    """
    sessions = sorted({call.session for call in calls if call.session})
    with stored(database_url) as store:
        histories = {session: history_of(store, session) for session in sessions}
    versions = check(calls, {session: history for session, history in histories.items() if history is not None})
    check_sums(database_url)
    return versions


def history_of(store: Store, session: str) -> list[Stored] | None:
    """Read and replay the history of a session; None: there is no such session.

    Raises:
        AssertionError: the session's own row is not its newest version.
    """
    state = store.get_session(session)
    if state is None:
        return None
    entries = store.history(session, -1, 10**6)
    newest = entries[-1].state
    assert (state.version, state.looks) == (newest.version, newest.looks)
    assert state.belief.log_p.tobytes() == newest.belief.log_p.tobytes()
    estimates = replayed(scenario_in(store, state.scenario), entries)
    return [_stored(entry, estimate) for entry, estimate in zip(entries, estimates, strict=True)]


def _stored(entry: HistoryEntry, estimate: Estimate) -> Stored:
    state = entry.state
    record = record_of(state.looks)
    looks = [place.looks for place in record.places]
    replayed_looks = [len(place.looks) for place in estimate.places]
    return Stored(
        state.version,
        entry.request,
        tuple(state.belief.p.tolist()),
        state.belief.p.tobytes() + state.belief.log_p.tobytes() + repr((record.log_odds_absent, looks)).encode(),
        estimate.belief.p.tobytes()
        + estimate.belief.log_p.tobytes()
        + repr((estimate.log_odds_absent, replayed_looks)).encode(),
    )


def scenario_in(store: Store, id_: str) -> Scenario:
    """Return the mathematics of a stored scenario."""
    model = Models(store, Cache(2**20)).get(id_)
    assert model is not None
    return model.scenario


def check_sums(database_url: str) -> None:
    """Assert that a program that reads the database alone reports no damage."""
    done = _verify(database_url)
    assert done.returncode == 0, done.stdout or done.stderr


def verified(database_url: str) -> bool:
    """Return True if a program that reads the database alone reports no damage."""
    return _verify(database_url).returncode == 0


def _verify(database_url: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "voa_store.verify", "-"]
    return subprocess.run(command, input=database_url, capture_output=True, text=True, check=False)


def missing(database_url: str, calls: Iterable[Call]) -> int | None:
    """Count the answered versions of the only session that are not stored; None: it cannot be read.

    Raises:
        ValueError: the calls are about several sessions, or about none.
    """
    (session,) = {call.session for call in calls if call.version is not None}
    answered = max(call.version or 0 for call in calls if call.outcome == "made")
    try:
        with stored(database_url) as store:
            state = store.get_session(session)
            entries = store.history(session, -1, 10**6)
    except StoreError:
        return None
    return None if state is None or len(entries) <= state.version else answered - state.version
