"""Robots: reports of the scans and looks received from each, so that scans that were refused can be seen."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import BaseModel, Field

from voa_msgs.robots import LookReport, Refusal, RobotReport, RobotScan
from voa_msgs.robots import Robots as RobotsMessage
from voa_msgs.sessions import ScanRequest, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_ros.pipeline import SeenScan
from voa_service.failures import InvalidRequest, not_found
from voa_service.ports import Clock
from voa_service.usecases.robot_reports import LookSource, at_place, empty_report, in_order_of_use, with_refusal
from voa_service.usecases.seen_scans import SeenScans, of_decoded, of_request

_MOST = 1_000  # reports; the bus lets anyone publish under any name


class LookOutcome(BaseModel):
    """Fields of the response to a scan that a robot's report shows; the others are not parsed."""

    version: int
    update: UpdateReport
    warnings: list[ProbableMistake] = Field(default=[])


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
        self._scans = SeenScans()
        self._lock = threading.Lock()

    def mapped(
        self, robot: str, key: str, source: LookSource, *, scenario: str | None = None, session: str | None = None
    ) -> None:
        """Add a robot whose topic is subscribed to; its mapping names either a scenario or a session."""
        with self._lock:
            self._mapped[robot] = _Mapped(MappedTo(scenario, session), source)
            self._reports.setdefault((robot, "ros2"), empty_report(robot, "ros2", key))

    def mapped_to(self, robot: str) -> MappedTo | None:
        """Return the target of a robot's mapping; None: the robot is not mapped."""
        with self._lock:
            mapped = self._mapped.get(robot)
        return None if mapped is None else mapped.to

    def ages(self) -> dict[str, float]:
        """Return the age of the newest scan of each mapped robot that has sent one, seconds."""
        with self._lock:
            seen = {robot: self._reports[robot, "ros2"].last_scan_at for robot in sorted(self._mapped)}
        now = self._now()
        return {robot: (now - at).total_seconds() for robot, at in seen.items() if at is not None}

    def names(self) -> list[str]:
        """List the names of the mapped robots, sorted."""
        with self._lock:
            return sorted(self._mapped)

    def unmapped(self, robot: str) -> None:
        """Remove a robot whose topic is no longer subscribed to."""
        with self._lock:
            self._mapped.pop(robot, None)
            self._reports.pop((robot, "ros2"), None)
            self._scans.drop(robot, "ros2")

    def received(self, robot: str, source: Literal["scan", "ros2"], key: str, session: str | None) -> None:
        """Count a scan that was received: of a mapped robot any, else only one that its caller may put.

        Any other put may come from anybody and name any session, so it must change nothing but the refusals.
        """
        with self._lock:
            if self._is_gone(robot, source):
                return
            before = self._report(robot, source, key)
            session = before.session if session is None else session
            changes = {"session": session, "key": key, "last_scan_at": self._now(), "scans": before.scans + 1}
            self._keep(before.model_copy(update=changes))

    def put(self, robot: str, key: str, session: str, request: ScanRequest | None) -> None:
        """Count a scan that a robot has put for a session and may put there, and keep it for a preview.

        Args:
            robot: name of the robot.
            key: key expression that the scan was put on.
            session: id of the session.
            request: that the scan makes; None: it cannot be read.
        """
        self.received(robot, "scan", key, session)
        if request is None:
            return
        with self._lock:
            self._scans.keep(robot, "scan", of_request(request, self._now(), session))

    def seen(self, robot: str, scan: SeenScan, session: str | None) -> None:
        """Keep the newest scan of a mapped robot for a preview, with the session that it is for, if that is known."""
        with self._lock:
            if robot in self._mapped:
                self._scans.keep(robot, "ros2", of_decoded(scan, self._now(), session))

    def scan(self, robot: str) -> RobotScan:
        """Return the newest scan of a robot, whether it was accepted or not.

        Raises:
            NotFound: no scan of a robot of this name was received.
        """
        with self._lock:
            newest = self._scans.newest(robot)
        if newest is None:
            raise not_found("scan of robot", robot)
        source, seen = newest
        return RobotScan(
            robot=robot,
            session=seen.session or self._session(robot, source),
            source=source,
            at=seen.at,
            sensor=seen.sensor,
            sensor_pose=seen.sensor_pose,
            scan=seen.message(),
        )

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
            refusals = with_refusal(before.refusals, Refusal(at=self._now(), reason=why))
            counted = {"refused": before.refused + 1, "last_refusal": why, "refusals": refusals}
            self._keep(before.model_copy(update=counted))
        return why != before.last_refusal

    def reports(self, shows: Callable[[str, str | None], bool] = lambda *_: True) -> RobotsMessage:
        """List the reports on robots, sorted by name.

        Args:
            shows: returns True for the robots to list, by name and session; default: all.
        """
        with self._lock:
            reports, mapped = sorted(self._reports.items()), dict(self._mapped)
            places = {robot: self._scans.get(robot, "scan") for robot, source in self._reports if source == "scan"}
        shown = [
            self._shown(report, mapped[robot])
            if source == "ros2" and robot in mapped
            else at_place(report, places.get(robot))
            for (robot, source), report in reports
        ]
        items = [report for report in shown if shows(report.robot, report.session)]
        return RobotsMessage(mapping_error=self.mapping_error, items=items)

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
        source = mapped.source
        standing = source.standing
        state: dict[str, Any] = {
            "session": self._mapped_session(report, mapped),
            "waiting_for": source.waiting_for,
            "warnings": [*source.warnings, *report.warnings],
            "sensor": standing.sensor,
            "sensor_pose": standing.sensor_pose,
            "gathered": standing.gathered,
            "wanted": standing.wanted,
        }
        return report.model_copy(update=state)

    def _mapped_session(self, report: RobotReport, mapped: _Mapped) -> str | None:
        if mapped.to.scenario is not None:
            return self._session_of(report.robot, mapped.to.scenario)
        return mapped.to.session or report.session

    def _session(self, robot: str, source: Literal["scan", "ros2"]) -> str | None:
        """Return the session to which the scans of a robot are applied; called without the lock."""
        with self._lock:
            report, mapped = self._reports.get((robot, source)), self._mapped.get(robot)
        if report is None or source == "scan" or mapped is None:
            return None if report is None else report.session
        return self._mapped_session(report, mapped)

    def _report(self, robot: str, source: Literal["scan", "ros2"], key: str) -> RobotReport:
        return self._reports.get((robot, source)) or empty_report(robot, source, key)

    def _is_gone(self, robot: str, source: Literal["scan", "ros2"]) -> bool:
        """Return True for a message of a robot that was unmapped meanwhile: its report would never be removed."""
        return source == "ros2" and robot not in self._mapped

    def _keep(self, report: RobotReport) -> None:
        named = (report.robot, report.source)
        if named not in self._reports and len(self._reports) >= _MOST:
            oldest = min(
                (each for each in self._reports if each[1] == "scan"),
                key=lambda each: in_order_of_use(self._reports[each]),
                default=None,
            )
            if oldest is not None:
                del self._reports[oldest]
        self._reports[named] = report
