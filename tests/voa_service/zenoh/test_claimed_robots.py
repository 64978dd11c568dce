"""Robots that are claimed for another session while they drive, or whose session does not exist."""

from typing import Any

import pytest

from tests.voa_service.zenoh.replica_pair import NAME, PERIOD_S, SCANS, Pair
from voa_service.failures import Failure
from voa_service.zenoh.joining import FOLLOW_SECONDS


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
    assert len(reads) <= 2 + 100 * PERIOD_S / FOLLOW_SECONDS
