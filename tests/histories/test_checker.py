"""The checker of recorded calls: each planted fault is found under its rule, and a right history has none."""

import math
import random
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import pytest

from tests.support.histories import Call, Fault, Stored, check, faults_of, tally

WRITES = 200
SESSION = "s"


@dataclass
class Recorded:
    """Calls on one session, and its history."""

    calls: list[Call]
    stored: list[Stored]

    def faults(self) -> list[Fault]:
        return faults_of(self.calls, {SESSION: self.stored})

    def index(self, matches: Callable[[Call], bool], number: int = 0) -> int:
        """The index of a call, of those that match."""
        return [index for index, call in enumerate(self.calls) if matches(call)][number]

    def change(self, index: int, **changes: object) -> None:
        self.calls[index] = replace(self.calls[index], **changes)  # type: ignore[arg-type] # fields of several types

    def change_stored(self, version: int, **changes: object) -> None:
        self.stored[version] = replace(self.stored[version], **changes)  # type: ignore[arg-type] # fields of several types


def belief_at(version: int) -> tuple[float, ...]:
    return (1.0 / (version + 2), 1.0 - 1.0 / (version + 2))


def recorded(seed: int = 0) -> Recorded:
    """A right history: each call takes effect at one instant, and overlaps with some others.

    Some writes get no response and are repeated under their key, some of them after they were applied; some are given
    up; some are answered twice; some change nothing.
    """
    rng = random.Random(seed)  # noqa: S311 - not a secret
    stored = [Stored(0, "prior", belief_at(0), b"0", b"0")]
    calls = [Call("create", SESSION, -2.0, -1.0, "made", 0, "create", "prior", "a0", belief_at(0))]
    for number in range(WRITES):
        at = float(number)
        started, ended = at - rng.uniform(0, 5), at + rng.uniform(0, 5)
        version, request, key = len(stored), f"request {number}", f"key {number}"
        fate = rng.choices(["made", "kept", "repeated", "again", "open", "never", "read"], [6, 1, 2, 1, 1, 1, 4])[0]
        if fate in ("kept", "read"):
            kind, seen = ("write", key) if fate == "kept" else ("read", None)
            newest = version - 1
            calls.append(
                Call(kind, SESSION, started, ended, fate, newest, seen, request, f"a{number}", belief_at(newest))  # type: ignore[arg-type] # a parameter of the test
            )
            continue
        made = Call("write", SESSION, started, ended, "made", version, key, request, f"a{number}", belief_at(version))
        unknown = replace(made, outcome="unknown", version=None, ended=math.inf, answer=None, belief=None)
        if fate != "never":
            stored.append(Stored(version, request, belief_at(version), b"%d" % version, b"%d" % version))
        if fate in ("open", "never"):
            calls.append(replace(unknown, key=None))
        elif fate == "repeated":
            late = ended + rng.uniform(0, 9)
            calls += [unknown, replace(made, started=rng.uniform(ended, late), ended=late)]
        else:
            calls += [made, replace(made, started=ended + 20, ended=ended + 21)][: 2 if fate == "again" else 1]
    rng.shuffle(calls)
    return Recorded(calls, stored)


def is_made(call: Call) -> bool:
    return call.kind == "write" and call.outcome == "made"


def once_made(own: Recorded, version: int) -> int:
    """The index of the only attempt of the write that made this version, or of the first such one after it."""
    attempts = Counter(call.key for call in own.calls)
    able = [
        (call.version or 0, index)
        for index, call in enumerate(own.calls)
        if is_made(call) and attempts[call.key] == 1 and (call.version or 0) >= version
    ]
    return min(able)[1]


@pytest.mark.parametrize("seed", range(20))
def test_a_right_history_has_no_fault_and_its_versions_are_counted(seed: int) -> None:
    own = recorded(seed)
    assert own.faults() == []
    assert check(own.calls, {SESSION: own.stored}) == len(own.stored) - 1 > WRITES / 3


def lose_the_newest(own: Recorded) -> None:
    newest = max(call.version or 0 for call in own.calls if is_made(call))
    del own.stored[newest:]


def lose_one_and_close_the_gap(own: Recorded) -> None:
    version = own.calls[once_made(own, 50)].version or 0
    del own.stored[version]
    own.stored[version:] = [replace(each, version=each.version - 1) for each in own.stored[version:]]


def apply_twice(own: Recorded) -> None:
    version = own.calls[once_made(own, 50)].version or 0
    own.stored.append(replace(own.stored[version], version=len(own.stored)))


def answer_two_writes_with_a_version(own: Recorded) -> None:
    own.change(once_made(own, 50), version=own.calls[once_made(own, 60)].version)


def make_a_version_of_nothing(own: Recorded) -> None:
    own.stored.append(Stored(len(own.stored), "nobody's"))


def apply_a_refused_write(own: Recorded) -> None:
    unanswered = own.index(lambda call: call.outcome == "unknown" and call.key is None)
    requests = {each.request for each in own.stored}
    while own.calls[unanswered].request not in requests:
        del own.calls[unanswered]
        unanswered = own.index(lambda call: call.outcome == "unknown" and call.key is None)
    own.change(unanswered, outcome="refused")


def leave_a_gap(own: Recorded) -> None:
    own.stored[50:] = [replace(each, version=each.version + 1) for each in own.stored[50:]]


def store_another_request(own: Recorded) -> None:
    own.change_stored(own.calls[once_made(own, 50)].version or 0, request="another")


def store_another_belief(own: Recorded) -> None:
    own.change_stored(own.calls[once_made(own, 50)].version or 0, belief=(0.5, 0.5))


def read_too_old(own: Recorded) -> None:
    own.change(own.index(lambda call: call.kind == "read", 30), version=1, belief=belief_at(1))


def read_too_new(own: Recorded) -> None:
    own.change(own.index(lambda call: call.kind == "read" and (call.version or 0) < 20), version=40, belief=None)


def read_what_nobody_had_begun(own: Recorded) -> None:
    """Read a version of a write that got no response, before it was sent."""
    index = own.index(lambda call: call.outcome == "unknown" and call.key is None)
    requests = {each.request: each.version for each in own.stored}
    while own.calls[index].request not in requests:
        del own.calls[index]
        index = own.index(lambda call: call.outcome == "unknown" and call.key is None)
    call = own.calls[index]
    at = call.started - 0.001
    own.calls.append(Call("read", SESSION, at - 0.001, at, "read", requests[call.request]))


def read_another_belief(own: Recorded) -> None:
    own.change(own.index(lambda call: call.kind == "read", 3), belief=(0.5, 0.5))


def keep_another_belief(own: Recorded) -> None:
    own.change(own.index(lambda call: call.outcome == "kept"), belief=(0.5, 0.5))


def read_what_is_gone(own: Recorded) -> None:
    own.calls.append(Call("read", SESSION, 30.0, 31.0, "gone"))


def go_back_in_time(own: Recorded) -> None:
    """Exchange two versions that were made long after each other, in calls and history alike."""
    first, second = once_made(own, 20), once_made(own, 70)
    one, other = own.calls[first], own.calls[second]
    own.change(first, version=other.version, belief=other.belief)
    own.change(second, version=one.version, belief=one.belief)
    own.change_stored(one.version or 0, request=other.request)
    own.change_stored(other.version or 0, request=one.request)


def answer_a_repeat_with_another_version(own: Recorded) -> None:
    index = once_made(own, 50)
    call = own.calls[index]
    own.calls.append(replace(call, started=900.0, ended=901.0, version=len(own.stored), belief=None))
    own.stored.append(Stored(len(own.stored), "x"))
    own.calls.append(Call("write", SESSION, 800.0, math.inf, "unknown", request="x"))


def answer_a_repeat_with_another_body(own: Recorded) -> None:
    call = own.calls[once_made(own, 50)]
    own.calls.append(replace(call, started=900.0, ended=901.0, answer="another"))


def replay_differently(own: Recorded) -> None:
    own.change_stored(50, replayed=b"another")


PLANTED: Sequence[tuple[Callable[[Recorded], None], str]] = [
    (lose_the_newest, "lost"),
    (lose_one_and_close_the_gap, "lost"),
    (apply_twice, "twice"),
    (answer_two_writes_with_a_version, "twice"),
    (make_a_version_of_nothing, "unexplained"),
    (apply_a_refused_write, "unexplained"),
    (leave_a_gap, "gap"),
    (store_another_request, "lost"),
    (store_another_belief, "lost"),
    (read_too_old, "order"),
    (read_too_new, "order"),
    (read_what_nobody_had_begun, "order"),
    (read_another_belief, "other"),
    (keep_another_belief, "other"),
    (read_what_is_gone, "order"),
    (go_back_in_time, "order"),
    (answer_a_repeat_with_another_version, "repeat"),
    (answer_a_repeat_with_another_body, "repeat"),
    (replay_differently, "replay"),
]


@pytest.mark.parametrize(("plant", "rule"), PLANTED, ids=[plant.__name__ for plant, _ in PLANTED])
def test_each_planted_fault_is_reported_under_its_rule(plant: Callable[[Recorded], None], rule: str) -> None:
    for seed in range(5):
        own = recorded(seed)
        plant(own)
        assert rule in tally(own.faults()), (seed, own.faults())
        with pytest.raises(AssertionError, match=f"{rule}: session {SESSION}"):
            check(own.calls, {SESSION: own.stored})


def test_every_rule_of_the_table_is_broken_by_a_planted_fault() -> None:
    documented = {line.split("`")[1] for line in (faults_of.__globals__["__doc__"]).splitlines() if "| `" in line}
    assert documented == {rule for _, rule in PLANTED}


def test_a_deleted_session_is_gone_afterwards_and_writes_before_it_are_no_fault() -> None:
    own = recorded()
    end = max(call.ended for call in own.calls if call.ended < math.inf)
    deletion = Call("delete", SESSION, end + 1, end + 2, "made")
    gone = Call("read", SESSION, end + 3, end + 4, "gone")
    assert faults_of([*own.calls, deletion, gone], {}) == []
    assert tally(faults_of([*own.calls, gone], {SESSION: own.stored})) == {"order": 1}, "its history is there"
    late = Call("write", SESSION, end + 5, end + 6, "made", len(own.stored), request="late")
    assert tally(faults_of([*own.calls, deletion, late], {})) == {"order": 1}
    read = Call("read", SESSION, end + 5, end + 6, "read", 3)
    assert tally(faults_of([*own.calls, deletion, read], {})) == {"order": 1}


def test_a_session_that_nobody_deleted_and_that_has_no_history_is_lost() -> None:
    own = recorded()
    assert tally(faults_of(own.calls, {})) == {"lost": 1}


def test_a_key_that_opens_two_sessions_is_reported() -> None:
    calls = [Call("create", name, at, at + 1.0, "made", 0, "key") for name, at in (("s", 1.0), ("t", 3.0))]
    assert tally(faults_of(calls, {"s": [Stored(0)], "t": [Stored(0)]})) == {"repeat": 1}


def test_calls_of_one_session_say_nothing_about_another() -> None:
    own = recorded()
    other = [replace(call, session="t", key=f"t {call.key}") for call in own.calls if call.key is not None]
    other += [replace(call, session="t") for call in own.calls if call.key is None]
    assert faults_of([*own.calls, *other], {SESSION: own.stored, "t": own.stored}) == []
    assert tally(faults_of(own.calls, {SESSION: own.stored, "t": own.stored})).keys() == {"unexplained"}


def test_calls_that_end_in_the_instant_in_which_another_begins_may_be_either_way() -> None:
    stored = [Stored(number) for number in range(3)]
    calls = [Call("write", SESSION, 1.0, 2.0, "made", 2), Call("write", SESSION, 2.0, 3.0, "made", 1)]
    assert faults_of(calls, {SESSION: stored}) == []
    apart = [calls[0], replace(calls[1], started=2.001)]
    assert tally(faults_of(apart, {SESSION: stored})) == {"order": 1}
