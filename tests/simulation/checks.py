"""Checks what a run has recorded against what its database holds in the end."""

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from tests.simulation.announcements import Announcements
from tests.simulation.replay import replayed
from tests.simulation.replica import START, UseCases, use_cases
from tests.simulation.requests import outcome_of
from tests.simulation.world import World
from tests.support.histories import Call, Stored, faults_of
from voa_service.runtime.changes import Changes
from voa_service.usecases.robots import Robots
from voa_store.errors import DamagedData
from voa_store.records import HistoryEntry
from voa_store.rows import blob
from voa_store.sql import SqlStore

_PAGE = 100_000
Histories = Mapping[str, Sequence[HistoryEntry]]


def problems_of(world: World) -> tuple[list[str], int]:
    """Return what was wrong in a run, and the number of versions in all histories; the processes must have ended."""
    store = SqlStore(world.url)
    try:
        listed = store.list_sessions(_PAGE, None).items
        histories = {each.id: store.history(each.id, -1, _PAGE) for each in listed}
    except DamagedData as error:
        store.close()
        return [*_unexpected(world), f"a history cannot be read at the end: {error}"], 0
    try:
        inside = use_cases(store, lambda: START, str, Changes(), Robots(lambda: START, store.robot_session))
        problems = [*_unexpected(world), *_contradictions(world, inside, histories)]
        for check in (_conditions, _publications, _creations, _announcements, _assignments, _looks):
            problems += check(world, histories)
    finally:
        store.close()
    return problems, sum(len(entries) - 1 for entries in histories.values())


def _unexpected(world: World) -> Iterator[str]:
    """Report errors that no code has expected, and refusals that no client has deserved."""
    for task, error in world.scheduler.errors:
        first = str(error).partition("\n")[0]  # SQLAlchemy adds parameters with addresses, which differ in each run
        yield f"{task.name} failed: {type(error).__name__}: {first}"
    yield from world.records.refusals


def _contradictions(world: World, inside: UseCases, histories: Histories) -> Iterator[str]:
    """Compare calls and histories by the rules of `tests.support.histories`."""
    stored: dict[str, list[Stored]] = {}
    for session, entries in histories.items():
        again = replayed(inside, entries)
        stored[session] = [
            Stored(
                entry.state.version,
                entry.request,
                tuple(entry.state.belief.p.tolist()),
                blob(entry.state.belief),
                blob(belief),
            )
            for entry, belief in zip(entries, again, strict=True)
        ]
    for fault in faults_of([*world.records.calls, *_robot_requests(world)], stored):
        yield str(fault)


def _robot_requests(world: World) -> list[Call]:
    """Return the looks of the robot as writes whose end nobody knows, to every session that there ever was."""
    sessions = {call.session for call in world.records.calls}
    return [
        Call("write", session, look.at, math.inf, "unknown", key=f"look {look.number}", request=look.body)
        for look in world.records.looks
        for session in sorted(sessions)
    ]


def _conditions(world: World, histories: Histories) -> Iterator[str]:
    """Report writes that took effect although the session had another version than their caller stated."""
    for seen in world.records.seen:
        expected = seen.request.if_match
        outcome, version = outcome_of(seen.request, seen.reply)
        if expected is not None and version is not None and version != expected + (outcome == "made"):
            yield f"condition: {seen.request.key} expected version {expected}, and was {outcome} {version}"


def _publications(world: World, histories: Histories) -> Iterator[str]:
    """Report announced commits that the histories do not have."""
    for each in world.records.publications:
        entries = histories.get(each.session)
        if each.state is None or entries is None:
            if each.state is None and entries is not None:
                yield f"published: the end of session {each.session}, which exists"
            continue
        version = each.state.version
        if version >= len(entries):
            yield f"published: version {version} of session {each.session}, which has {len(entries) - 1}"
        elif blob(entries[version].state.belief) != blob(each.state.belief):
            yield f"published: another belief for version {version} of session {each.session} than is stored"


def _creations(world: World, histories: Histories) -> Iterator[str]:
    """Report creations that made more than one session, or none although they were answered."""
    made = Counter(entries[0].request for entries in histories.values())
    for request in world.records.creations:
        if made.pop(request.body, 0) > 1:
            yield f"created: {request.key} made more than one session"
    for body in made:
        yield f"created: no client has sent a request for a session with {body[:80]}"


def _announcements(world: World, histories: Histories) -> Iterator[str]:
    """Report announced looks that a read lacks, or has although they had ended."""
    of: dict[str, Announcements] = defaultdict(Announcements)
    for seen in world.records.seen:
        of[seen.request.session].add(seen)
    for call in [*world.records.calls, *_robot_requests(world)]:
        if call.kind == "write":
            of[call.session].writes.append(call)
    jumps = [seconds for _, _, seconds in world.plan.jumps]
    behind = START.timestamp() + sum(min(0.0, seconds) for seconds in jumps)
    ahead = START.timestamp() + sum(max(0.0, seconds) for seconds in jumps)
    for session, announcements in of.items():
        for problem in announcements.problems(behind, ahead):
            yield f"announced: session {session}: {problem}"


def _assignments(world: World, histories: Histories) -> Iterator[str]:
    """Report that the robot moved to another session although nobody moved it."""
    ends = [(call.session, call.started) for call in world.records.calls if call.kind == "delete"]
    settled = [each for each in world.records.settled if each.session is not None]
    for before, after in pairwise(sorted(settled, key=lambda each: each.started)):
        if before.session == after.session:
            continue
        last = max(before.ended, after.ended)
        moved = any(each.started <= last and each.ended >= before.started for each in world.records.claims)
        ended = any(session in (before.session, after.session) and started <= last for session, started in ends)
        if not (moved or ended):
            yield f"robot: it belongs to {before.session} and then to {after.session}, though nobody moved it"


def _looks(world: World, histories: Histories) -> Iterator[str]:
    """Report looks of the robot that a process takes for applied, and that are in no history."""
    bodies = {look.number: look.body for look in world.records.looks}
    for each in world.records.applied:
        entries = histories.get(each.session)
        if entries is None or each.result not in ("accepted", "taken"):
            continue
        count = sum(entry.request == bodies[each.number] for entry in entries)
        if count != 1:
            yield f"look: look {each.number} is {each.result}, and {count} times in session {each.session}"
