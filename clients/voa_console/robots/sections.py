"""Section of a robot: what it is doing, what is wrong with it, its last refusals, and its newest scan."""

from collections.abc import Sequence
from datetime import datetime
from urllib.parse import quote

from nicegui import ui

from voa_client import RobotReport
from voa_console.robots.checklists import Checklist
from voa_console.robots.doing import RefusalLine, certainty, doing, refusal_lines
from voa_console.robots.scan_panel import ScanPanel
from voa_console.robots.watching import RobotsWatch
from voa_doctor.findings import Finding


class RobotSection:
    """Section of a robot.

    Args:
        watch: has its findings and its scan.
        report: on the robot.
    """

    def __init__(self, watch: RobotsWatch, report: RobotReport) -> None:
        self.element = ui.card().classes("w-full").props('role="region"')
        self.element.props["aria-label"] = f"Robot {report.robot}"
        self._reasons: tuple[str, ...] = ()
        self._refusals: list[ui.label] = []
        with self.element, ui.row().classes("w-full gap-8 items-start"):
            with ui.column().classes("gap-3 min-w-0").style("flex: 1 1 20rem"):
                with ui.row().classes("items-baseline gap-4"):
                    ui.label(report.robot).classes("text-lg font-medium").props('role="heading" aria-level="2"')
                    self._session = ui.link("its session", "/").classes("text-sm")
                self._doing = ui.label().classes("text-base").style("overflow-wrap: anywhere")
                self._certainty = ui.label().classes("text-sm")
                self._checklist = Checklist(f"Checks of {report.robot}")
                self._title = ui.label("Last refusals").classes("text-base font-medium mt-2")
                self._title.props('role="heading" aria-level="3"')
                self._lines = ui.column().classes("w-full gap-2").props("role=list")
                self._lines.props["aria-label"] = f"Last refusals of {report.robot}"
                self._none = ui.label("None since the service started.").classes("text-sm")
            with ui.column().classes("gap-2 min-w-0").style("flex: 1 1 20rem; max-width: 34rem"):
                self._scan = ScanPanel(watch, report.robot)

    def update(self, report: RobotReport, findings: Sequence[Finding], now: datetime) -> None:
        """Show another state of the robot.

        Args:
            report: on the robot.
            findings: about the robot.
            now: time by the clock of the service.
        """
        self._doing.set_text(doing(report, now))
        self._certainty.set_text(certainty(report))
        self._certainty.set_visibility(report.sensor_pose is not None)
        self._session.set_visibility(report.session is not None)
        if report.session is not None:
            self._session.props["href"] = f"/sessions/{quote(report.session, safe='')}"
            self._session.props["aria-label"] = f"Open the session of {report.robot}"
            self._session.update()
        self._checklist.update(findings)
        self._update_refusals(refusal_lines(report, now))
        self._scan.update(report)

    def _update_refusals(self, lines: Sequence[RefusalLine]) -> None:
        """Draw the refusals again where their reasons changed, else renew their ages."""
        reasons = tuple(line.reason for line in lines)
        self._none.set_visibility(not lines)
        self._lines.set_visibility(bool(lines))
        if reasons != self._reasons:
            self._reasons = reasons
            self._lines.clear()
            with self._lines:
                self._refusals = [_draw(line) for line in lines]
        for line, label in zip(lines, self._refusals, strict=True):
            label.set_text(line.when)


def _draw(line: RefusalLine) -> ui.label:
    with ui.column().classes("w-full gap-0 min-w-0").props('role="listitem"'):
        when = ui.label().classes("text-xs opacity-80")
        ui.label(line.reason).classes("text-sm min-w-0").style("overflow-wrap: anywhere")
    return when
