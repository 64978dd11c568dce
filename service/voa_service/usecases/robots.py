"""What was heard of robots, so that a scan that came to nothing can be seen."""

import threading
from dataclasses import dataclass
from typing import Literal, Protocol

from pydantic import BaseModel, Field

from voa_msgs.robots import LookReport, RobotReport
from voa_msgs.robots import Robots as RobotsMessage
from voa_msgs.sessions import ScanRequest, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_service.failures import INVALID, Failure, not_found
from voa_service.ports import Clock

_MOST = 1_000  # anyone may put anything as a robot's name


class LookOutcome(BaseModel):
    """Fields of the answer to a scan that a robot's report needs; the others are not read."""

    version: int
    update: UpdateReport
    warnings: list[ProbableMistake] = Field(default=[])


class LookSource(Protocol):
    """A mapped robot, as far as its report needs it."""

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet; None: each scan is a look."""

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Probable mistakes in how the robot is used."""

    def request(self) -> None:
        """Ask for a look; raises ValueError where looks are not taken on request."""


@dataclass(frozen=True)
class _Mapped:
    """A mapped robot, and what its mapping names."""

    source: LookSource
    scenario: str | None
    session: str | None


class Robots:
    """Reports by robot, as this process heard them; from any thread."""

    def __init__(self, now: Clock) -> None:
        self.mapping_error: str | None = None
        """Why the mapping in force is not the one that its file has."""
        self._now = now
        self._reports: dict[tuple[str, str], RobotReport] = {}
        self._mapped: dict[str, _Mapped] = {}
        self._lock = threading.Lock()

    def mapped(
        self, robot: str, key: str, source: LookSource, *, scenario: str | None = None, session: str | None = None
    ) -> None:
        """Note that a robot's topic is subscribed to, for the scenario or session that its mapping names."""
        with self._lock:
            self._mapped[robot] = _Mapped(source, scenario, session)
            self._reports.setdefault((robot, "ros2"), _unheard(robot, "ros2", key))

    def unmapped(self, robot: str) -> None:
        """A robot's topic is no longer listened to."""
        with self._lock:
            self._mapped.pop(robot, None)
            self._reports.pop((robot, "ros2"), None)

    def heard(self, robot: str, source: Literal["scan", "ros2"], key: str, session: str | None) -> None:
        """A scan came in."""
        with self._lock:
            if source == "ros2" and robot not in self._mapped:  # what was on its way when its mapping went
                return
            before = self._report(robot, source, key)
            session = before.session if session is None else session
            heard = {"session": session, "key": key, "last_scan_at": self._now(), "scans": before.scans + 1}
            self._keep(before.model_copy(update=heard))

    def looked(
        self,
        robot: str,
        source: Literal["scan", "ros2"],
        key: str,
        session: str,
        request: ScanRequest,
        outcome: LookOutcome,
    ) -> None:
        """Note that a look was applied to a session, accepted or not."""
        look = LookReport(
            at=self._now(),
            sensor=request.sensor,
            sensor_pose=request.sensor_pose,
            accepted=outcome.update.accepted,
            reason=outcome.update.reason,
            version=outcome.version,
        )
        with self._lock:
            before = self._report(robot, source, key)
            applied = {"session": session, "looks": before.looks + 1, "last_look": look, "warnings": outcome.warnings}
            self._keep(before.model_copy(update=applied))

    def refused(self, robot: str, source: Literal["scan", "ros2"], key: str, why: str) -> bool:
        """A scan could not be used; whether that is news, and not the same as for the one before."""
        with self._lock:
            before = self._report(robot, source, key)
            self._keep(before.model_copy(update={"refused": before.refused + 1, "last_refusal": why}))
        return why != before.last_refusal

    def reports(self) -> RobotsMessage:
        """All of them, by name."""
        with self._lock:
            reports, mapped = sorted(self._reports.items()), dict(self._mapped)
        return RobotsMessage(
            mapping_error=self.mapping_error,
            items=[
                _as_it_stands(report, mapped[robot].source) if source == "ros2" and robot in mapped else report
                for (robot, source), report in reports
            ],
        )

    def request_look(self, robot: str) -> RobotReport:
        """The robot's next scans are to be a look.

        Raises:
            Failure: no such robot is mapped, or its looks are not on request.
        """
        with self._lock:
            mapped, report = self._mapped.get(robot), self._reports.get((robot, "ros2"))
        if mapped is None or report is None:
            raise not_found("mapped robot", robot)
        try:
            mapped.source.request()
        except ValueError as error:
            raise Failure(INVALID, str(error)) from error
        return _as_it_stands(report, mapped.source)

    def _report(self, robot: str, source: Literal["scan", "ros2"], key: str) -> RobotReport:
        return self._reports.get((robot, source)) or _unheard(robot, source, key)

    def _keep(self, report: RobotReport) -> None:
        named = (report.robot, report.source)
        if named not in self._reports and len(self._reports) >= _MOST:
            oldest = min(
                (each for each in self._reports if each[1] == "scan"),
                key=lambda each: str(self._reports[each].last_scan_at),
                default=None,
            )
            if oldest is not None:
                del self._reports[oldest]
        self._reports[named] = report


def _as_it_stands(report: RobotReport, source: LookSource) -> RobotReport:
    """The report of a mapped robot, with its present state."""
    state = {"waiting_for": source.waiting_for, "warnings": [*source.warnings, *report.warnings]}
    return report.model_copy(update=state)


def _unheard(robot: str, source: Literal["scan", "ros2"], key: str) -> RobotReport:
    return RobotReport(
        robot=robot,
        session=None,
        source=source,
        key=key,
        last_scan_at=None,
        scans=0,
        looks=0,
        refused=0,
        last_refusal=None,
        waiting_for=None,
    )
