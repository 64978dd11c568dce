"""Parts of a report: refusals one below the other, and the place of a robot that puts its scans."""

from datetime import UTC, datetime, timedelta

from tests.support.serving import scan_of
from voa_msgs.robots import Refusal
from voa_msgs.sessions import ScanRequest
from voa_service.usecases.robot_reports import at_place, empty_report, with_refusal
from voa_service.usecases.seen_scans import of_request

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)


def test_refusals_for_one_reason_in_a_row_are_one_and_the_newest_five_are_kept() -> None:
    refusals: list[Refusal] = []
    for minute, reason in enumerate("aabcdeff"):
        refusals = with_refusal(refusals, Refusal(at=NOON + timedelta(minutes=minute), reason=reason))
    assert [(each.reason, each.times) for each in refusals] == [("f", 2), ("e", 1), ("d", 1), ("c", 1), ("b", 1)]
    assert refusals[0].at == NOON + timedelta(minutes=7)


def test_the_place_is_that_of_the_newest_scan() -> None:
    report = empty_report("r", "scan", "scan/S/r").model_copy(update={"session": "S"})
    assert at_place(report, None) == report
    request = ScanRequest.model_validate(scan_of([0.5], "Q2"))
    shown = at_place(report, of_request(request, NOON, "S"))
    assert shown.sensor == "Q2"
    assert at_place(report, of_request(request, NOON, "before")) == report, "the place is for readers of that session"
