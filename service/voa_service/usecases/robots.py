"""Robots: reports of the scans and looks received from each, so that scans that were refused can be seen."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from pydantic import BaseModel, Field

from voa_msgs.robots import LookReport, RobotReport
from voa_msgs.robots import Robots as RobotsMessage
from voa_msgs.sessions import ScanRequest, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_service.failures import InvalidRequest, not_found
from voa_service.ports import Clock

_MOST = 1_000  # reports; the bus lets anyone publish under any name


class LookOutcome(BaseModel):
    """Fields of the response to a scan that a robot's report shows; the others are not parsed."""

    version: int
    update: UpdateReport
    warnings: list[ProbableMistake] = Field(default=[])


class LookSource(Protocol):
    """Port to a mapped robot: the facts that its report shows, and the request for a look."""

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet; None: every scan is a look."""

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Probable mistakes in how the robot is used."""

    def request(self) -> None:
        """Request a look.

        Raises:
            ValueError: the robot's looks are not taken on request.
        """


@dataclass(frozen=True)
class MappedTo:
    """Target of a robot's mapping: a fixed session, or a scenario on whose sessions its scans are used."""

    scenario: str | None
    session: str | None


@dataclass(frozen=True)
class _Mapped:
    """A mapped robot with the target of its mapping."""

    to: MappedTo
    source: LookSource


class Robots:
    """Reports on the robots from which this process has received scans; safe for use from several threads."""

    def __init__(self, now: Clock, session_of: Callable[[str, str], str | None]) -> None:
        """Create an empty collection of reports.

        Args:
            now: clock.
            session_of: returns the session that the next look of a robot, mapped to a scenario, belongs to.
        """
        self.mapping_error: str | None = None
        """Error that keeps the mapping's file from being used, while the mapping before it is still used."""
        self._now = now
        self._session_of = session_of
        self._reports: dict[tuple[str, str], RobotReport] = {}
        self._mapped: dict[str, _Mapped] = {}
        self._lock = threading.Lock()

    def mapped(
        self, robot: str, key: str, source: LookSource, *, scenario: str | None = None, session: str | None = None
    ) -> None:
        """Add a robot whose topic is subscribed to; its mapping names either a scenario or a session."""
        with self._lock:
            self._mapped[robot] = _Mapped(MappedTo(scenario, session), source)
            self._reports.setdefault((robot, "ros2"), _empty_report(robot, "ros2", key))

    def mapped_to(self, robot: str) -> MappedTo | None:
        """Return the target of a robot's mapping; None: the robot is not mapped."""
        with self._lock:
            mapped = self._mapped.get(robot)
        return None if mapped is None else mapped.to

    def names(self) -> list[str]:
        """List the names of the mapped robots, sorted."""
        with self._lock:
            return sorted(self._mapped)

    def unmapped(self, robot: str) -> None:
        """Remove a robot whose topic is no longer subscribed to."""
        with self._lock:
            self._mapped.pop(robot, None)
            self._reports.pop((robot, "ros2"), None)

    def received(self, robot: str, source: Literal["scan", "ros2"], key: str, session: str | None) -> None:
        """Count a scan that was received."""
        with self._lock:
            if self._is_gone(robot, source):
                return
            before = self._report(robot, source, key)
            session = before.session if session is None else session
            changes = {"session": session, "key": key, "last_scan_at": self._now(), "scans": before.scans + 1}
            self._keep(before.model_copy(update=changes))

    def looked(
        self,
        robot: str,
        source: Literal["scan", "ros2"],
        key: str,
        session: str,
        request: ScanRequest,
        outcome: LookOutcome,
    ) -> None:
        """Record a look that was applied to a session, accepted or not."""
        look = LookReport(
            at=self._now(),
            sensor=request.sensor,
            sensor_pose=request.sensor_pose,
            accepted=outcome.update.accepted,
            reason=outcome.update.reason,
            version=outcome.version,
        )
        with self._lock:
            if self._is_gone(robot, source):
                return
            before = self._report(robot, source, key)
            applied = {"session": session, "looks": before.looks + 1, "last_look": look, "warnings": outcome.warnings}
            self._keep(before.model_copy(update=applied))

    def refused(self, robot: str, source: Literal["scan", "ros2"], key: str, why: str) -> bool:
        """Count a scan that could not be used; True if the reason differs from that of the refusal before."""
        with self._lock:
            if self._is_gone(robot, source):
                return False
            before = self._report(robot, source, key)
            self._keep(before.model_copy(update={"refused": before.refused + 1, "last_refusal": why}))
        return why != before.last_refusal

    def reports(self) -> RobotsMessage:
        """List the reports on all robots, sorted by name."""
        with self._lock:
            reports, mapped = sorted(self._reports.items()), dict(self._mapped)
        return RobotsMessage(
            mapping_error=self.mapping_error,
            items=[
                self._shown(report, mapped[robot]) if source == "ros2" and robot in mapped else report
                for (robot, source), report in reports
            ],
        )

    def report(self, robot: str) -> RobotReport:
        """Return the report on a mapped robot.

        Raises:
            NotFound: no robot of this name is mapped.
        """
        return self._shown(*self._one(robot))

    def request_look(self, robot: str) -> RobotReport:
        """Request that the next scans of a mapped robot become a look; returns the report on the robot.

        Raises:
            NotFound: no robot of this name is mapped.
            InvalidRequest: its looks are not taken on request.
        """
        report, mapped = self._one(robot)
        try:
            mapped.source.request()
        except ValueError as error:
            raise InvalidRequest(str(error)) from error
        return self._shown(report, mapped)

    def _one(self, robot: str) -> tuple[RobotReport, _Mapped]:
        """Return a mapped robot and its report; raises NotFound if it is not mapped."""
        with self._lock:
            mapped, report = self._mapped.get(robot), self._reports.get((robot, "ros2"))
        if mapped is None or report is None:
            raise not_found("mapped robot", robot)
        return report, mapped

    def _shown(self, report: RobotReport, mapped: _Mapped) -> RobotReport:
        """Complete a report with the robot's present state; called without the lock because it reads the store."""
        session = mapped.to.session or report.session
        if mapped.to.scenario is not None:
            session = self._session_of(report.robot, mapped.to.scenario)
        warnings = [*mapped.source.warnings, *report.warnings]
        state = {"session": session, "waiting_for": mapped.source.waiting_for, "warnings": warnings}
        return report.model_copy(update=state)

    def _report(self, robot: str, source: Literal["scan", "ros2"], key: str) -> RobotReport:
        return self._reports.get((robot, source)) or _empty_report(robot, source, key)

    def _is_gone(self, robot: str, source: Literal["scan", "ros2"]) -> bool:
        """Return True for a message of a robot that was unmapped meanwhile: its report would never be removed."""
        return source == "ros2" and robot not in self._mapped

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


def _empty_report(robot: str, source: Literal["scan", "ros2"], key: str) -> RobotReport:
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
