"""Checks recorded calls of the service against the histories that it has stored, in linear time.

Versions order all writes of a session, so that no search is needed (unlike in a general check of linearizability): an
answered call states the version that it made or read, and a single pass over the calls in the order of time decides.
Nothing here knows a protocol, a database or a clock: a real service, a simulation and a test's own list are checked
alike.

| rule | states |
|---|---|
| `gap` | the versions of a stored history are 0, 1, 2, ... without a gap |
| `lost` | an answered write is that version of the history, with its request and its belief |
| `twice` | no two writes made the same version, and no write made two |
| `unexplained` | each version was made by a recorded write that was answered, or that nobody knows the end of |
| `order` | a call that began after another was answered has no lower version, and a write has a greater one |
| `repeat` | a repeated write with an idempotency key gets its first response |
| `other` | a read returns the belief that is stored for its version |
| `replay` | each stored belief is that of the replayed history, bit for bit |
"""

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

Kind = Literal["create", "write", "read", "delete"]
Outcome = Literal["made", "kept", "read", "gone", "refused", "unknown"]
"""Outcome of a call, as its caller knows it.

made: it made `version` (a deletion: answered). kept: answered, and made no version; the session was at `version`.
read: returned `version`. gone: the session is deleted. refused: nothing was changed. unknown: no response, or one that
leaves it open (503): it may have happened, and may still happen.
"""

GONE = math.inf
"""Version of a deleted session, greater than all others."""


@dataclass(frozen=True)
class Call:
    """A call of the service, one attempt, with its times on one monotonic clock.

    Attributes:
        kind: of the call.
        session: id of the session that it is about.
        started: time at which it was sent.
        ended: time at which it was answered; infinite where it was not.
        outcome: as the caller knows it.
        version: that it made or read; None where the outcome is none of these.
        key: idempotency key, equal in all attempts of one write; None: it has none.
        request: body of a write, which the history must contain; None: not recorded.
        answer: response, equal for all attempts under a key; None: not recorded.
        belief: that the response states; None: not recorded.
    """

    kind: Kind
    session: str
    started: float
    ended: float
    outcome: Outcome
    version: int | None = None
    key: str | None = None
    request: str | None = None
    answer: str | None = None
    belief: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Stored:
    """A version of a session's history, as it was read after everything had ended.

    Attributes:
        version: its number.
        request: body of the request that made it; None: not compared.
        belief: probabilities; None: not compared.
        bits: belief as bytes, with all that is replayed; None: not replayed.
        replayed: result of the replay, in the form of `bits`.
    """

    version: int
    request: str | None = None
    belief: tuple[float, ...] | None = None
    bits: bytes | None = None
    replayed: bytes | None = None


@dataclass(frozen=True)
class Fault:
    """A contradiction between calls and histories.

    Attributes:
        rule: name of the rule that is broken.
        session: id of the session.
        version: that the fault concerns; -1: none.
        detail: for a person.
    """

    rule: str
    session: str
    version: float
    detail: str

    def __str__(self) -> str:
        return f"{self.rule}: session {self.session}, version {self.version:g}: {self.detail}"


def faults_of(calls: Iterable[Call], histories: Mapping[str, Sequence[Stored]]) -> list[Fault]:
    """Find every contradiction.

    Args:
        calls: all calls, in any order. A call that is missing here, and made a version, is a fault.
        histories: by session, in the order of the database; deleted sessions are absent.
    """
    of: dict[str, list[Call]] = defaultdict(list)
    for call in calls:
        of[call.session].append(call)
    faults = _created_twice([call for own in of.values() for call in own if call.kind == "create"])
    for session in sorted({*of, *histories}):
        writes, repeats = _merged(of[session])
        reads = [call for call in of[session] if call.kind == "read" and call.outcome in ("read", "gone")]
        stored = histories.get(session)
        faults += repeats
        faults += _twice(writes)
        if stored is None:
            faults += _vanished(session, of[session])
        else:
            faults += _gaps(session, stored)
            faults += _stored_faults(session, writes, stored)
            faults += _other([*reads, *(call for call in writes if call.outcome == "kept")], stored)
            writes = _placed(writes, stored)
            reads.append(Call("read", session, math.inf, math.inf, "read", stored[-1].version if stored else 0))
        faults += _order([*writes, *reads])
    return faults


def check(calls: Iterable[Call], histories: Mapping[str, Sequence[Stored]]) -> int:
    """Assert that there is no fault; returns the number of versions that writes have made.

    Raises:
        AssertionError: there are faults; the message has their number and the first ten.
    """
    faults = faults_of(calls, histories)
    lines = "\n".join(f"  {fault}" for fault in faults[:10])
    assert not faults, f"{len(faults)} faults:\n{lines}"
    return sum(len(stored) - 1 for stored in histories.values())


def tally(faults: Iterable[Fault]) -> dict[str, int]:
    """Count faults by rule."""
    return dict(Counter(fault.rule for fault in faults))


# ------------------------------------------------------------------------------------------------------- writes


def _merged(calls: Sequence[Call]) -> tuple[list[Call], list[Fault]]:
    """Merge the attempts of each keyed write into one call, from its first start to its first response."""
    writes, faults = [], []
    keyed: dict[str, list[Call]] = defaultdict(list)
    for call in calls:
        if call.kind == "read":
            continue
        if call.key is None:
            writes.append(call)
        else:
            keyed[call.key].append(call)
    for key, attempts in keyed.items():
        answered = sorted((call for call in attempts if call.outcome in ("made", "kept")), key=lambda call: call.ended)
        if answered:
            first = answered[0]
            faults += [_repeat(key, first, each) for each in answered[1:] if _differ(first, each)]
        else:
            refused = [call for call in attempts if call.outcome == "refused"]
            first = refused[0] if refused else attempts[0]
        writes.append(replace(first, started=min(call.started for call in attempts)))
    return writes, faults


def _created_twice(creations: Sequence[Call]) -> list[Fault]:
    """Find keys under which two sessions were opened: attempts of one creation that are about different sessions."""
    first: dict[str | None, Call] = {}
    faults = []
    for call in sorted(creations, key=lambda call: call.ended):
        if call.key is not None and call.outcome == "made":
            before = first.setdefault(call.key, call)
            if before.session != call.session:
                detail = f"key {call.key!r} opened this session, after it had opened {before.session}"
                faults.append(Fault("repeat", call.session, 0, detail))
    return faults


def _differ(first: Call, second: Call) -> bool:
    return (first.outcome, first.version, first.answer) != (second.outcome, second.version, second.answer)


def _repeat(key: str, first: Call, second: Call) -> Fault:
    detail = f"key {key!r} was answered {first.outcome} {first.version}, and then {second.outcome} {second.version}"
    if (first.outcome, first.version) == (second.outcome, second.version):
        detail += " with another body"
    return Fault("repeat", first.session, _number(first), detail)


def _number(call: Call) -> float:
    if call.outcome == "gone" or (call.kind == "delete" and call.outcome == "made"):
        return GONE
    return -1 if call.version is None else call.version


def _twice(writes: Sequence[Call]) -> list[Fault]:
    counts = Counter((call.session, _number(call)) for call in writes if call.outcome == "made")
    return [
        Fault("twice", session, version, f"{count} writes were answered with it")
        for (session, version), count in counts.items()
        if count > 1 and version != GONE
    ]


# ------------------------------------------------------------------------------------------------------ history


def _vanished(session: str, calls: Sequence[Call]) -> list[Fault]:
    """Report a session that was answered with a version, has no history, and that nobody deleted."""
    if any(call.kind == "delete" and call.outcome != "refused" for call in calls):
        return []
    newest = max((call.version for call in calls if call.version is not None), default=None)
    return [] if newest is None else [Fault("lost", session, newest, "it was answered, and there is no history")]


def _gaps(session: str, stored: Sequence[Stored]) -> list[Fault]:
    numbers = [each.version for each in stored]
    if numbers[:1] != [0]:
        return [Fault("gap", session, 0, f"the history begins with {numbers[:1]}")]
    return [
        Fault("gap", session, before + 1, f"{after} follows {before}")
        for before, after in pairwise(numbers)
        if after != before + 1
    ]


def _stored_faults(session: str, writes: Sequence[Call], stored: Sequence[Stored]) -> list[Fault]:
    """Compare the history with the answered writes, and the rest of it with those whose end nobody knows."""
    made = {call.version: call for call in writes if call.outcome == "made" and call.kind != "delete"}
    by_version = {each.version: each for each in stored}
    faults = [
        Fault("lost", session, _number(call), f"it was answered, and the history ends at {len(stored) - 1}")
        for call in made.values()
        if call.version not in by_version
    ]
    open_ = Counter(call.request for call in writes if call.outcome == "unknown")
    for each in stored:
        call = made.get(each.version)
        if call is not None:
            faults += _unlike(call, each)
        elif each.version > 0:
            if open_[each.request] > 0:
                open_[each.request] -= 1
            else:
                faults.append(Fault("unexplained", session, each.version, f"no write explains {_short(each.request)}"))
        if each.bits != each.replayed:
            faults.append(Fault("replay", session, each.version, "the replayed history has another belief"))
    return faults + _repeated_requests(session, writes, stored)


def _unlike(call: Call, stored: Stored) -> list[Fault]:
    faults = []
    if call.kind == "write" and None not in (call.request, stored.request) and call.request != stored.request:
        detail = f"{_short(call.request)} was answered with it, and {_short(stored.request)} is stored"
        faults.append(Fault("lost", call.session, stored.version, detail))
    if None not in (call.belief, stored.belief) and call.belief != stored.belief:
        faults.append(Fault("lost", call.session, stored.version, "another belief was answered than is stored"))
    return faults


def _repeated_requests(session: str, writes: Sequence[Call], stored: Sequence[Stored]) -> list[Fault]:
    """Find requests that stand in the history more often than they were sent."""
    sent = Counter(call.request for call in writes if call.request is not None)
    there = Counter(each.request for each in stored if each.request is not None and each.request in sent)
    return [
        Fault("twice", session, -1, f"{_short(request)} was sent {sent[request]} times and is stored {count} times")
        for request, count in there.items()
        if count > sent[request]
    ]


def _placed(writes: Sequence[Call], stored: Sequence[Stored]) -> list[Call]:
    """Give unanswered writes the version that has their request, where no other write has the same."""
    sent = Counter(call.request for call in writes)
    version_of = {each.request: each.version for each in stored if each.request is not None}
    return [
        replace(call, outcome="made", version=version_of[call.request], ended=math.inf)
        if call.outcome == "unknown" and call.request in version_of and sent[call.request] == 1
        else call
        for call in writes
    ]


def _other(reads: Sequence[Call], stored: Sequence[Stored]) -> list[Fault]:
    belief_of = {each.version: each.belief for each in stored}
    faults = []
    for read in reads:
        if read.version is not None and read.version not in belief_of:
            faults.append(Fault("other", read.session, read.version, "it was read, and the history does not have it"))
        elif read.belief is not None and belief_of.get(read.version or 0) not in (None, read.belief):
            faults.append(Fault("other", read.session, _number(read), "another belief was read than is stored"))
    return faults


def _short(request: str | None) -> str:
    text = repr(request)
    return text if len(text) < 100 else f"{text[:60]} ... {text[-36:]}"


# --------------------------------------------------------------------------------------------------------- time


def _order(calls: Sequence[Call]) -> list[Fault]:
    """Compare each call with the greatest version that was answered before it began.

    A call that ended before another began is answered first, and one that ended in the same instant is not: it may
    have been either way.
    """
    known = [call for call in calls if call.outcome in ("made", "kept", "read", "gone")]
    starts = sorted(known, key=lambda call: call.started)
    ends = sorted((call for call in known if call.ended < math.inf), key=lambda call: call.ended)
    faults: list[Fault] = []
    floor, by, done = -1.0, None, 0
    for call in starts:
        while done < len(ends) and ends[done].ended < call.started:
            if _number(ends[done]) > floor:
                floor, by = _number(ends[done]), ends[done]
            done += 1
        least = floor + 1 if call.outcome == "made" and call.kind != "delete" and floor != GONE else floor
        if _number(call) < least and by is not None:
            faults.append(Fault("order", call.session, _number(call), _late(call, by)))
    return faults


def _late(call: Call, by: Call) -> str:
    return (
        f"a {call.kind} that began at {call.started:.6f} is {call.outcome} {_number(call):g}, after a {by.kind} had "
        f"been answered with {_number(by):g} at {by.ended:.6f}"
    )
