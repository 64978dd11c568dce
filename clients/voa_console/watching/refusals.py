"""Reason why the scans of a robot are refused at the moment, from its report."""

from datetime import datetime, timedelta

from voa_client import RobotReport
from voa_console.sentences import REASONS

FRESH = timedelta(seconds=15.0)
"""Age up to which a refusal counts as the present state of a robot."""


def refusal_of(report: RobotReport, now: datetime) -> str | None:
    """Return why the scans of a robot are refused at the moment; None: they are not.

    A robot whose newest look was not accepted counts, too.

    Args:
        report: of the robot.
        now: time by the clock of the service.
    """
    newest = next(iter(report.refusals), None)
    if newest is not None and now - newest.at <= FRESH:
        return newest.reason if newest.times == 1 else f"{newest.reason} ({newest.times} times in a row)"
    look = report.last_look
    if look is not None and not look.accepted:
        reason = REASONS.get(look.reason or "", look.reason) or "the service did not state a reason"
        return f"the newest look was not accepted: {reason}"
    return None
