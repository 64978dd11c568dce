"""What was heard of robots stays bounded, and those heard longest ago are forgotten first."""

from datetime import UTC, datetime, timedelta
from itertools import count

import pytest

from voa_msgs.warnings import ProbableMistake
from voa_service.usecases import robots as module
from voa_service.usecases.robots import Robots


class Quiet:
    """A mapped robot of which nothing was received."""

    waiting_for = "a scan"
    warnings: list[ProbableMistake] = []  # noqa: RUF012  # the protocol reads it

    def request(self) -> None:
        """Nobody asks."""


NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)


def test_the_robot_heard_longest_ago_is_forgotten_but_none_that_is_mapped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST", 4)
    seconds = count()
    robots = Robots(lambda: NOON + timedelta(seconds=next(seconds)), lambda robot, scenario: None)
    robots.mapped("mapped", "mapped/scan", Quiet(), session="S")
    for name in ("a", "b", "c", "a", "d", "e"):
        robots.heard(name, "scan", f"scan/S/{name}", "S")
    assert [report.robot for report in robots.reports().items] == ["a", "d", "e", "mapped"]
