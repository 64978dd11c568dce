"""Hints that come over a bus or a proxy are checked with the service before one is handed out, or ends anything."""

from collections.abc import Sequence

import pytest

from tests.voa_client.stepping import POLL_S, Service, body, hints, news
from tests.voa_client.test_attempts import problem
from voa_client import NotFoundError, Retries, UnexpectedResponseError, UnreachableError, WireVersionError
from voa_client._following import GRACE_S, PAUSE_S
from voa_client._mailbox import Batch
from voa_client._responses import Response, check, synthetic_problem
from voa_client._transport import Deleted, Lost, State
from voa_msgs.sessions import Session

FORGED = 10**12
HINT = Batch(hinted=True)
SILENCE = Batch()


def versions(sessions: Sequence[Session]) -> list[int | None]:
    return [session.version for session in sessions]


@pytest.mark.parametrize(
    "forged",
    [
        Batch(hinted=True, bodies={FORGED: [body(FORGED)]}),
        Batch(hinted=True, bodies={1: [body(1)]}),
        Batch(hinted=True, bodies={1: [b"\0", b"{}", b"[" * 100_000, body(1, id="other")]}),
        HINT,
    ],
    ids=["far ahead", "next", "garbage", "delete"],
)
def test_what_the_service_does_not_bear_out_is_nothing(forged: Batch) -> None:
    service = Service(0)
    sessions, lost = service.follow(service.following(), [forged, 1, HINT, 2, SILENCE])
    assert (versions(sessions), lost) == ([0, 1, 2], None)
    assert service.requested == ["session.get"] * 4
    assert service.paused == [PAUSE_S]


def test_the_body_is_the_service_s_and_not_the_bus_s() -> None:
    service = Service(0)
    sessions, _ = service.follow(service.following(), [1, hints(1, best_grasp="forged")])
    assert sessions[-1] == Session.model_validate_json(body(1))


def test_versions_between_two_questions_come_from_the_bus_as_the_history_has_them() -> None:
    service = Service(0)
    sessions, _ = service.follow(service.following(), [8, hints(*range(1, 9)), hints(9, 10)])
    assert versions(sessions) == list(range(9))
    assert service.requested == ["session.get"] * 2 + ["history.get"] * 3 + ["session.get"]


def test_hints_that_are_still_on_their_way_are_waited_for_a_moment() -> None:
    service = Service(0)
    sessions, _ = service.follow(service.following(), [4, hints(1), hints(3), hints(2)])
    assert versions(sessions) == [0, 1, 2, 3, 4]
    service = Service(0)
    sessions, _ = service.follow(service.following(), [4, hints(1), hints(3), SILENCE, SILENCE])
    assert versions(sessions) == [0, 1, 3, 4]
    assert service.waited == [POLL_S, GRACE_S, pytest.approx(GRACE_S, abs=0.01), POLL_S]


def test_a_flood_does_not_prolong_that_moment() -> None:
    service = Service(0)
    service.follow(service.following(), [4, hints(1), *[HINT] * 1_000])
    assert len([seconds for seconds in service.waited if seconds is not None and seconds <= GRACE_S]) <= 250


@pytest.mark.parametrize(
    "changed",
    [
        {"updated_at": "2026-01-01T00:00:59Z"},
        {"scenario": "other"},
        {"poses": ["Q"]},
        {"belief": [0.5, 0.5]},
        {"id": "other"},
        {"version": 3},
        {"created_at": "2026-01-02T00:00:00Z"},
    ],
)
def test_a_version_between_that_contradicts_the_service_is_left_out(changed: dict[str, object]) -> None:
    service = Service(0)
    bodies = {1: [body(1)], 2: [body(2, **changed)], 3: [body(3)]}
    sessions, _ = service.follow(service.following(), [4, Batch(hinted=True, bodies=bodies)])
    assert versions(sessions) == [0, 1, 3, 4]


def test_of_several_bodies_the_true_one_is_taken_and_none_of_two_that_could_be() -> None:
    service = Service(0)
    bodies = {1: [b"\0", body(1, updated_at="2027-01-01T00:00:00Z"), body(1)], 2: [body(2), body(2, best_grasp="G")]}
    sessions, _ = service.follow(service.following(), [3, Batch(hinted=True, bodies=bodies)])
    assert versions(sessions) == [0, 1, 3]


def test_a_history_that_cannot_be_had_leaves_out_what_lies_between() -> None:
    service = Service(0)
    following = service.following()
    answer = service._answer
    service._answer = lambda rpc, query: problem("overloaded", 503) if rpc == "history.get" else answer(rpc, query)  # type: ignore[method-assign] # replaced for this test alone
    sessions, lost = service.follow(following, [3, hints(1, 2)])
    assert (versions(sessions), lost) == ([0, 3], None)


def test_a_flood_costs_ten_questions_a_second_and_no_version_is_late_by_more_than_a_pause() -> None:
    service = Service(0)
    sessions, _ = service.follow(service.following(), [*[HINT] * 100, 1, HINT, *[HINT] * 100, 2, HINT])
    assert versions(sessions) == [0, 1, 2]
    assert len(service.requested) == 203
    assert service.now == pytest.approx(200 * PAUSE_S)


def test_a_delete_is_believed_of_the_service_alone() -> None:
    service = Service(0)
    following = service.following()
    sessions, lost = service.follow(following, [HINT, None, HINT])
    assert versions(sessions) == [0]
    assert lost is not None
    assert not following.is_over
    following.lost(lost)
    assert following.is_over


def test_after_something_was_received_spoilt_answers_are_waited_out() -> None:
    for spoilt in (
        Response(b"<html>"),
        Response(synthetic_problem(404, "a proxy", "no"), refused=True),
        Response(b"", refused=True),
    ):
        service = Service(0)
        following = service.following()
        service.follow(following, [])
        service.spoilt = spoilt
        _, lost = service.follow(following, [])
        assert lost is not None
        assert following.lost(lost) == Retries().wait_s(1, 0.0)
        assert not following.is_over
        service.spoilt = None
        service.version = 1
        assert versions(service.follow(following, [])[0]) == [1]


def test_before_anything_was_received_they_say_that_something_else_is_there() -> None:
    for spoilt, kind in (
        (Response(b"<html>"), UnexpectedResponseError),
        (Response(synthetic_problem(404, "a proxy", "no"), refused=True), NotFoundError),
        (Response(b"{}", wire=2), WireVersionError),
    ):
        service = Service(0, spoilt)
        following = service.following()
        _, lost = service.follow(following, [])
        assert lost is not None
        with pytest.raises(kind):
            following.lost(lost)


def test_a_service_of_another_version_of_the_messages_is_said_at_once() -> None:
    service = Service(0)
    following = service.following()
    service.follow(following, [])
    service.spoilt = Response(b"{}", wire=2)
    _, lost = service.follow(following, [])
    assert lost is not None
    with pytest.raises(WireVersionError):
        following.lost(lost)


def test_the_service_s_own_events_are_taken_as_they_come() -> None:
    service = Service(2)
    events = [State(body(version)) for version in (2, 3, 3, 2, 4)]
    sessions, lost = service.follow(service.following(), [news(*events)], poll_s=None)
    assert (versions(sessions), lost) == ([2, 3, 4], None)
    assert service.requested == ["session.get"], "the first one only"


@pytest.mark.parametrize(
    "odd",
    [State(b"\0"), State(body(1, id="other")), State(body(FORGED)), State(body(1, version=None)), Deleted()],
    ids=["garbage", "another session", "far ahead", "no version", "delete"],
)
def test_an_event_that_the_service_does_not_bear_out_begins_a_new_watch(odd: State | Deleted) -> None:
    service = Service(0)
    following = service.following()
    sessions, lost = service.follow(following, [news(State(body(0)), odd, State(body(2)))], poll_s=None)
    assert versions(sessions) == [0]
    assert lost is not None
    assert isinstance(lost.error, UnexpectedResponseError)
    assert following.lost(lost) == Retries().wait_s(1, 0.0)
    service.version = 1
    sessions, _ = service.follow(following, [news(State(body(1)))], poll_s=None)
    assert versions(sessions) == [1]


def test_events_that_skip_versions_are_checked_and_then_go_on() -> None:
    service = Service(9)
    following = service.following()
    sessions, _ = service.follow(following, [news(*[State(body(each)) for each in (2, 5, 6, 9)])], poll_s=None)
    assert versions(sessions) == [2, 5, 6, 9]
    assert service.requested == ["session.get"] * 3


def test_an_end_that_the_service_confirms_is_one() -> None:
    service = Service(0)
    following = service.following()
    _, lost = service.follow(following, [news(State(body(0))), None, news(Deleted())], poll_s=None)
    assert lost is not None
    following.lost(lost)
    assert following.is_over


def test_a_watch_that_is_lost_says_so_after_what_came_before() -> None:
    service = Service(1)
    gone = Lost(UnreachableError("gone"))
    batch = news(State(body(0)), State(body(1)), gone, State(body(2)))
    sessions, lost = service.follow(service.following(), [batch], poll_s=None)
    assert (versions(sessions), lost) == ([0, 1], gone)


def test_refusals_of_the_service_differ_from_those_of_a_proxy() -> None:
    for reply, own in (
        (problem("not-found", 404), True),
        (Response(synthetic_problem(404, "a proxy", "no"), refused=True), False),
    ):
        with pytest.raises(NotFoundError) as refused:
            check(reply)
        assert refused.value.is_of_the_service is own
