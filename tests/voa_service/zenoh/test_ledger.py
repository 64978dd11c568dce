"""Each stop counts once: two processes that receive the same scans, and apply their looks sooner or later."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import Service, data_scenario, serving
from tests.voa_service.zenoh.test_ros2 import laser_scan
from voa_ros.robots import RobotMapping, load
from voa_ros.topics import LASER_SCAN
from voa_service.failures import Failure
from voa_service.guard import guarded
from voa_service.zenoh.applying import DueLook, apply_look
from voa_service.zenoh.mapped_robot import FOLLOW_SECONDS, MappedRobot
from voa_service.zenoh.samples import Sample
from voa_store.errors import Unavailable

GOOD = (0.5, 0.5, math.inf, 1.0)
NOTHING = (0.0, 0.0, 0.0, 0.0)
"""Ranges of a lidar that spins up: no look of them is accepted."""
SCANS = 3
NAME = "tb3_1"


class Process:
    """A process: a service, and the robot as it is mapped there."""

    def __init__(self, service: Service, mapping: RobotMapping) -> None:
        self.service = service
        self.robot = MappedRobot(mapping, service.inside)
        service.inside.robots.mapped(
            NAME, mapping.scan_topic, self.robot, scenario=mapping.scenario, session=mapping.session
        )
        self.due: list[DueLook] = []
        """Looks that are not applied yet."""

    def receive(self, payload: bytes, sensor: str, late_s: float = 0.0) -> None:
        """Receive a scan, which is worked on so many seconds after it came."""
        attachment = f'{{"sensor": "{sensor}"}}'.encode()
        received_s = time.monotonic() - late_s
        look = self.robot.receive(Sample(LASER_SCAN, f"{NAME}/scan", payload, attachment, received_s))
        if look is not None:
            self.due.append(look)

    def apply(self, most: int = 1_000) -> None:
        """Apply the looks that are due, at most so many, in order."""
        for _ in range(min(most, len(self.due))):
            due = self.due.pop(0)
            try:
                with guarded():
                    answer = apply_look(self.service.inside.updates, due)
            except Failure as failure:
                self.robot.rejected(due, failure.kind)
                continue
            if answer is not None and not answer.update.accepted:
                self.robot.rejected(due, str(answer.update.reason))


class Pair:
    """Two processes on one database."""

    def __init__(self, services: Sequence[Service]) -> None:
        self.services = services
        self.scenario = services[0].create(data_scenario())
        self.session = services[0].open(self.scenario)
        self._turn = 0

    def processes(self, look: str = f"{{ scans = {SCANS} }}", to: str = "", count: int = 2) -> list[Process]:
        to = to or f'session = "{self.session}"'
        text = f'[[robot]]\nname = "{NAME}"\n{to}\nlook = {look}\nplace = {{ from = "attachment" }}\n'
        (mapping,) = load(text)
        return [Process(service, mapping) for service in self.services[:count]]

    def revolution(
        self,
        sensor: str,
        to: Sequence[Process],
        ranges: Sequence[float] = GOOD,
        clock: bool = True,
        late_s: float = 0.0,
    ) -> None:
        self._turn += 1
        shifted = [value + 1e-4 * (self._turn % 7) if clock and value else value for value in ranges]
        payload = laser_scan(shifted, 100.0 + 0.2 * self._turn if clock else 0.0)
        for process in to:
            process.receive(payload, sensor, late_s)

    def stop(
        self,
        sensor: str,
        to: Sequence[Process],
        ranges: Sequence[float] = GOOD,
        clock: bool = True,
        late_s: float = 0.0,
    ) -> None:
        """As many revolutions as a look has."""
        for _ in range(SCANS):
            self.revolution(sensor, to, ranges, clock, late_s)

    def looks(self, session: str | None = None) -> list[Any]:
        """Places of the looks in the history, in order."""
        items = self.services[0].get(f"/v1/sessions/{session or self.session}/history?limit=1000")["items"]
        return [entry["request"]["sensor"] for entry in items if entry["kind"] == "scan"]


@pytest.fixture
def pair(tmp_path: Path) -> Iterator[Pair]:
    with ExitStack() as stack:
        yield Pair([stack.enter_context(serving(tmp_path)) for _ in range(2)])


def test_what_both_take_of_the_same_revolutions_counts_once(pair: Pair) -> None:
    both = one, other = pair.processes()
    for number in range(4):
        pair.stop(["Q1", "Q2"][number % 2], both)
        one.apply()
        other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2"]


def test_looks_of_one_stop_count_once_although_they_are_of_other_revolutions(pair: Pair) -> None:
    both = one, other = pair.processes()
    for number in range(4):
        sensor = ["Q1", "Q2"][number % 2]
        pair.revolution(sensor, [one])  # the other one misses it
        pair.stop(sensor, both)
        one.apply()
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2"]


def test_a_process_that_is_far_behind_counts_nothing_twice(pair: Pair) -> None:
    both = one, other = pair.processes()
    for number in range(12):
        sensor = ["Q1", "Q2"][number % 2]
        pair.revolution(sensor, [other])
        pair.stop(sensor, both)
        one.apply()
    other.apply()
    assert pair.looks() == ["Q1", "Q2"] * 6


def test_what_the_one_has_not_applied_when_it_ends_the_other_does(pair: Pair) -> None:
    both = one, other = pair.processes()
    pair.stop("Q1", both)
    one.apply()
    pair.stop("Q2", both)
    pair.stop("Q1", both)
    other.apply()  # the one was killed
    pair.stop("Q2", [other])
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2"]


def test_a_process_that_starts_while_the_robot_is_parked_takes_no_second_look(pair: Pair) -> None:
    (one,) = pair.processes(count=1)
    pair.stop("Q1", [one])
    one.apply()
    (_, other) = pair.processes()
    for _ in range(3):
        pair.stop("Q1", [other])
    other.apply()
    assert (pair.looks(), other.robot.waiting_for) == (["Q1"], "the robot to move on: this stop's look is taken")
    pair.stop("Q2", [other])
    other.apply()
    assert pair.looks() == ["Q1", "Q2"]


def test_a_process_that_starts_before_the_look_of_the_stop_is_applied_takes_none_that_counts(pair: Pair) -> None:
    (one,) = pair.processes(count=1)
    pair.stop("Q1", [one])
    (_, other) = pair.processes()
    pair.revolution("Q1", [other])
    one.apply()
    for _ in range(3):
        pair.stop("Q1", [other])
    other.apply()
    assert pair.looks() == ["Q1"]


def test_a_look_that_is_refused_is_taken_again_and_counts_once(pair: Pair) -> None:
    both = one, other = pair.processes()
    pair.stop("Q1", both, NOTHING)
    one.apply()
    assert "not accepted (no_beams)" in str(one.robot.waiting_for)
    pair.stop("Q1", both)  # for the other one this stop's look is taken
    one.apply()
    other.apply()
    pair.stop("Q1", both)
    one.apply()
    other.apply()
    assert pair.looks() == ["Q1"]


def test_after_a_stop_without_a_look_the_next_ones_count_once(pair: Pair) -> None:
    both = one, other = pair.processes()
    pair.stop("Q1", both, NOTHING)
    one.apply()
    for number in range(4):
        sensor = ["Q2", "Q1"][number % 2]
        pair.revolution(sensor, [one])
        pair.stop(sensor, both)
        one.apply()
    other.apply()
    assert pair.looks() == ["Q2", "Q1", "Q2", "Q1"]


def test_a_look_that_is_refused_and_not_taken_again_by_who_ends_is_taken_by_the_other(pair: Pair) -> None:
    both = one, other = pair.processes()
    pair.stop("Q1", both, NOTHING)
    one.apply()
    other.apply()
    pair.stop("Q1", [other])
    other.apply()
    assert pair.looks() == ["Q1"]


def test_a_robot_without_a_clock_and_without_noise_comes_back_to_a_place(pair: Pair) -> None:
    both = one, other = pair.processes()
    for sensor in ("Q1", "Q2", "Q1", "Q2", "Q1"):
        pair.stop(sensor, both, clock=False)
        one.apply()
        other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2", "Q1"]


def test_a_look_is_searched_among_those_since_its_stop_began(pair: Pair) -> None:
    """The other process was cut off while the robot was at a place to which it comes back."""
    both = one, other = pair.processes()
    pair.stop("Q2", both)
    pair.stop("Q1", [one])
    pair.stop("Q2", [one])
    one.apply()
    other.apply()
    for _ in range(2):
        pair.stop("Q1", [other])  # the one is gone
    other.apply()
    assert pair.looks() == ["Q2", "Q1", "Q2", "Q1"]


def test_a_look_of_this_stop_is_detected_although_an_own_one_was_counted_after_it(pair: Pair) -> None:
    one, other = pair.processes()
    pair.stop("Q1", [other])  # the one misses it
    pair.stop("Q2", [one])
    one.apply()
    other.apply()  # late
    for _ in range(2):
        pair.stop("Q2", [other])
    other.apply()
    assert pair.looks() == ["Q2", "Q1"]


@pytest.mark.parametrize("missed", [0, 1])
def test_looks_of_two_revolutions_count_once(pair: Pair, missed: int) -> None:
    both = one, other = pair.processes("{ scans = 2 }")
    for number in range(4):
        sensor = ["Q1", "Q2"][number % 2]
        for _ in range(missed):
            pair.revolution(sensor, [one])
        for _ in range(3):
            pair.revolution(sensor, both)
        one.apply()
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2"]


def test_every_scan_counts_once_also_when_one_process_is_far_behind(pair: Pair) -> None:
    both = one, other = pair.processes('{ mode = "every" }')
    for _ in range(150):
        pair.revolution("Q1", both)
        one.apply()
    other.apply()
    assert len(pair.looks()) == 150


@pytest.mark.parametrize("clock", [True, False])
def test_every_scan_counts_once_also_when_one_process_ends(pair: Pair, clock: bool) -> None:
    both = one, other = pair.processes('{ mode = "every" }')
    for _ in range(20):
        pair.revolution("Q1", both, clock=clock)
    one.apply(5)
    other.apply()
    assert len(pair.looks()) == 20


def test_scans_that_are_alike_count_one_for_one_also_after_one_that_was_missed(pair: Pair) -> None:
    both = one, other = pair.processes('{ mode = "every" }')
    pair.revolution("Q1", [other])
    other.due.clear()
    pair.revolution("Q1", [one], (0.6, 0.5, 0.5, 1.0))  # the other one misses it
    one.apply()
    for _ in range(20):
        pair.revolution("Q1", both, clock=False)
    one.apply(5)
    other.apply()
    assert len(pair.looks()) == 21


def test_a_process_reads_no_more_than_it_must_where_every_scan_counts(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    (one,) = pair.processes('{ mode = "every" }', count=1)
    store, reads = pair.services[0].inside.sessions.store, []
    read = store.robot_looks

    def counted(id_: str, robot: str, limit: int) -> Any:
        reads.append(limit)
        return read(id_, robot, limit)

    monkeypatch.setattr(store, "robot_looks", counted)
    for _ in range(50):
        pair.revolution("Q1", [one])
        one.apply()
    assert len(pair.looks()) == 50
    assert set(reads) == {1}


def test_a_scan_that_another_process_applied_before_this_one_entered_the_session_counts_once(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = one, other = pair.processes('{ mode = "every" }', to=f'scenario = "{pair.scenario}"')
    pair.revolution("Q1", both)
    receive = one.receive

    def receive_and_apply(payload: bytes, sensor: str, received_s: float = 0.0) -> None:
        receive(payload, sensor, received_s)
        one.apply()

    monkeypatch.setattr(one, "receive", receive_and_apply)
    second = pair.services[0].open(pair.scenario, robots=[NAME])
    for _ in range(3):
        pair.revolution("Q1", both)  # each time the first process is done before the second one receives it
    other.apply()
    assert len(pair.looks(second)) == 3


@pytest.mark.parametrize("scans", [1, 5])
def test_scans_that_are_alike_count_after_a_restart(pair: Pair, scans: int) -> None:
    (one,) = pair.processes('{ mode = "every" }', count=1)
    for _ in range(scans):
        pair.revolution("Q1", [one], clock=False)
    one.apply()
    (again,) = pair.processes('{ mode = "every" }', count=1)
    for _ in range(scans):
        pair.revolution("Q1", [again], clock=False)
    again.apply()
    assert len(pair.looks()) == 2 * scans


@pytest.mark.parametrize("scans", [2, 3])
def test_requests_to_either_process_are_looks(pair: Pair, scans: int) -> None:
    both = pair.processes(f'{{ mode = "on_request", scans = {scans} }}')
    for number in range(4):
        both[number % 2].robot.request()
        for _ in range(scans):
            pair.revolution("Q1", both)
        for process in both:
            process.apply()
    assert len(pair.looks()) == 4


@pytest.mark.parametrize("look", [f"{{ scans = {SCANS} }}", "{ scans = 2 }"])
def test_the_first_look_of_a_claim_is_the_only_one_of_its_stop(pair: Pair, look: str) -> None:
    (one,) = pair.processes(look, to=f'scenario = "{pair.scenario}"', count=1)
    pair.revolution("Q1", [one])
    second = pair.services[0].open(pair.scenario, robots=[NAME])  # while its scans are gathered
    pair.stop("Q1", [one])
    one.apply()
    for _ in range(4):
        pair.stop("Q1", [one])
        one.apply()
    assert (pair.looks(), pair.looks(second)) == ([], ["Q1"])
    pair.stop("Q2", [one])
    one.apply()
    assert (pair.looks(), pair.looks(second)) == ([], ["Q1", "Q2"])


def test_a_claim_that_one_process_notices_first_is_one_look_of_its_stop(pair: Pair) -> None:
    both = one, other = pair.processes(to=f'scenario = "{pair.scenario}"')
    pair.revolution("Q1", both)
    second = pair.services[0].open(pair.scenario, robots=[NAME])
    pair.stop("Q1", [one])
    one.apply()
    for sensor in ("Q1", "Q1", "Q2", "Q2"):
        pair.stop(sensor, [other])
        other.apply()
    assert (pair.looks(), pair.looks(second)) == ([], ["Q1", "Q2"])


def test_a_look_that_is_due_goes_where_it_was_due_although_the_robot_is_claimed(pair: Pair) -> None:
    both = one, other = pair.processes(to=f'scenario = "{pair.scenario}"')
    pair.stop("Q1", both)
    second = pair.services[0].open(pair.scenario, robots=[NAME])
    one.apply()
    other.apply()
    assert (pair.looks(), pair.looks(second)) == (["Q1"], [])


def test_a_process_that_is_late_leaves_what_came_before_a_claim_in_the_session_before(pair: Pair) -> None:
    both = one, other = pair.processes(to=f'scenario = "{pair.scenario}"')
    pair.stop("Q1", both)
    one.apply()
    other.apply()
    pair.stop("Q2", [one])
    one.apply()
    second = pair.services[0].open(pair.scenario, robots=[NAME])
    pair.stop("Q1", [one])
    one.apply()
    assert (pair.looks(), pair.looks(second)) == (["Q1", "Q2"], ["Q1"])
    pair.stop("Q2", [other], late_s=10.0)
    other.apply()
    assert (pair.looks(), pair.looks(second)) == (["Q1", "Q2"], ["Q1"]), "it is counted already, where it belongs"
    for sensor in ("Q1", "Q2"):
        pair.stop(sensor, [other])
        other.apply()
    assert (pair.looks(), pair.looks(second)) == (["Q1", "Q2"], ["Q1", "Q2"])


def once(call: Callable[..., Any]) -> Callable[..., Any]:
    """Make a call that fails the first time, as where the database does not answer."""
    calls = iter([True])

    def called(*given: Any) -> Any:
        if next(calls, False):
            raise Unavailable("the database does not answer")
        return call(*given)

    return called


def committed_once(call: Callable[..., Any]) -> Callable[..., Any]:
    """Make a call that fails the first time although its work is done, as where the response is lost."""
    failing = once(lambda: None)

    @contextmanager
    def block(inner: AbstractContextManager[Any]) -> Iterator[Any]:
        with inner as change:
            yield change
        failing()

    def called(*given: Any) -> Any:
        result = call(*given)
        if isinstance(result, AbstractContextManager):
            return block(result)
        failing()
        return result

    return called


@pytest.mark.parametrize("method", ["settle_robot", "change", "robot_looks", "history", "get_session"])
@pytest.mark.parametrize("fails", [once, committed_once])
def test_a_call_of_the_database_that_fails_loses_no_look_and_doubles_none(
    pair: Pair, monkeypatch: pytest.MonkeyPatch, method: str, fails: Callable[..., Any]
) -> None:
    (one,) = pair.processes(to=f'scenario = "{pair.scenario}"', count=1)
    pair.revolution("Q1", [one])
    store = pair.services[0].inside.sessions.store
    monkeypatch.setattr(store, method, fails(getattr(store, method)))
    refused = 0
    for _ in range(2 * SCANS + 4):
        try:
            pair.revolution("Q1", [one])
        except Failure:
            refused += 1
        one.apply()
    assert pair.looks() == ["Q1"]
    assert refused <= 1


def test_a_mapping_to_a_missing_session_reads_the_store_seldom(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    (one,) = pair.processes(to='session = "nothing"', count=1)
    store, reads = pair.services[0].inside.sessions.store, []
    read = store.get_session

    def counted(id_: str) -> Any:
        reads.append(id_)
        return read(id_)

    monkeypatch.setattr(store, "get_session", counted)
    for _ in range(100):
        with pytest.raises(Failure, match="there is no session 'nothing'"):
            pair.revolution("Q1", [one])
    assert one.robot.waiting_for == "the mapping's scenario or session: there is no session 'nothing'"
    assert len(reads) <= 1 + int(10 / FOLLOW_SECONDS)
