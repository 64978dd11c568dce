"""Moments: now, and past versions with their beliefs."""

from datetime import UTC, datetime

from voa_console.session.moments import moment_at
from voa_msgs.sessions import HistoryEntry, Session

AT = datetime(2026, 11, 29, tzinfo=UTC)
SESSION = Session(
    id="s",
    scenario="c",
    version=2,
    poses=["A", "B"],
    belief=[0.9, 0.1],
    best_grasp="G1",
    expected_score=0.8,
    entropy_nats=0.3,
    last_fit_rmsd_mm=None,
    created_at=AT,
    updated_at=AT,
)


def entry(version: int, belief: list[float] | None) -> HistoryEntry:
    return HistoryEntry(
        version=version,
        kind="scan",
        at=AT,
        request=None,
        update=None,
        belief=belief,
        best_grasp="G2",
        expected_score=0.4,
        entropy_nats=0.6,
    )


HISTORY = [entry(0, [0.5, 0.5]), entry(1, [0.6, 0.4]), entry(2, [0.9, 0.1])]


def test_the_past_has_its_own_belief_and_is_marked_as_past() -> None:
    moment = moment_at(1, SESSION, HISTORY)
    assert (list(moment.belief), moment.best_grasp, moment.expected_score) == ([0.6, 0.4], "G2", 0.4)
    assert moment.is_past
    assert moment.title == "version 1 of 2, the past"


def test_no_choice_the_newest_version_and_unknown_versions_are_now() -> None:
    for chosen in (None, 2, 3):
        moment = moment_at(chosen, SESSION, HISTORY)
        assert (moment.version, list(moment.belief), moment.is_past) == (2, [0.9, 0.1], False)
        assert moment.title == "version 2 of 2, now"
    assert not moment_at(1, SESSION, []).is_past
    assert not moment_at(1, SESSION, [entry(1, None)]).is_past
