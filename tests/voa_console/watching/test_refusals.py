"""Refusals count while they are fresh, and a look that was not accepted until the next one."""

from datetime import timedelta

from tests.voa_console.now.test_summary import NOW, report
from voa_console.watching.refusals import FRESH, refusal_of


def refused(age: timedelta, times: int = 1) -> list[dict[str, object]]:
    return [{"at": NOW - age, "reason": "the frame is missing", "times": times}]


def test_a_fresh_refusal_counts_and_an_old_one_does_not() -> None:
    assert refusal_of(report(refusals=refused(FRESH)), NOW) == "the frame is missing"
    assert refusal_of(report(refusals=refused(FRESH, 4)), NOW) == "the frame is missing (4 times in a row)"
    assert refusal_of(report(refusals=refused(FRESH + timedelta(seconds=1))), NOW) is None
    assert refusal_of(report(), NOW) is None


def test_a_look_that_was_not_accepted_counts_until_the_next_one() -> None:
    look = {"at": NOW, "sensor": "E", "sensor_pose": None, "accepted": False, "reason": "no_beams", "version": 0}
    assert "every beam of the scan is missing" in (refusal_of(report(last_look=look), NOW) or "")
    assert refusal_of(report(last_look=look | {"accepted": True, "reason": None}), NOW) is None
