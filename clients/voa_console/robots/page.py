"""The page Robots: the checks of the service, and a section for each robot."""

from nicegui import ui

from voa_client import RobotReport
from voa_console import layout
from voa_console.context import Console
from voa_console.now.summary import age
from voa_console.robots.checklists import Checklist, draw_sign
from voa_console.robots.mapping_help import mapping_help
from voa_console.robots.sections import RobotSection
from voa_console.robots.watching import RobotsWatch, of_robot
from voa_console.robots.wording import plain, tally
from voa_doctor.findings import Finding, State

_GRAVE: tuple[State, ...] = ("wrong", "warning")


def register() -> None:
    """Declare the page `/robots`."""

    @ui.page("/robots")
    def robots() -> None:
        with layout.page("Robots") as console:
            _Robots(console, console.part(RobotsWatch))


class _Tally:
    """Line with the sign of a state and the number of checks that ended in it; hidden if there are none."""

    def __init__(self, state: State) -> None:
        self._state: State = state
        with ui.row().classes("items-center gap-2 no-wrap") as self._row:
            draw_sign(state)
            self._label = ui.label().classes("text-base font-medium")

    def update(self, number: int) -> None:
        self._row.set_visibility(number > 0)
        self._label.set_text(tally(self._state, number))


class _Robots:
    """Content of the page, kept up to date while its browser shows it."""

    def __init__(self, console: Console, watch: RobotsWatch) -> None:
        self._hub = console.hub
        self._watch = watch
        self._sections: dict[tuple[str, str], RobotSection] = {}
        with ui.card().classes("w-full gap-3").props('role="region" aria-label="Service"'):
            with ui.row().classes("w-full items-center gap-4"):
                ui.label("Service").classes("text-lg font-medium").props('role="heading" aria-level="2"')
                ui.button("Examine now", icon="refresh", on_click=watch.examine_now, color=None).props(
                    "outline no-caps dense"
                )
                self._age = ui.label().classes("text-sm")
            self._tallies = {state: _Tally(state) for state in _GRAVE}
            self._checklist = Checklist("Checks of the service that need attention")
            with ui.expansion().classes("w-full").props('dense header-class="px-0"') as self._passed:
                with self._passed.add_slot("header"), ui.element("div").classes("grow"):
                    self._tallies["ok"] = _Tally("ok")
                self._good = Checklist("Checks of the service that passed")
        self._help = mapping_help()
        self._column = ui.column().classes("w-full gap-4")
        layout.while_open(console.hub.subscribe(self._update))
        layout.while_open(watch.subscribe(self._update))
        self._update()

    def _update(self) -> None:
        hub, watch = self._hub, self._watch
        now = hub.now()
        of_robots = watch.robot_findings(now) if hub.has_responded else []
        general = [finding for finding in of_robots if finding.check == "mapping"]
        findings = [plain(finding) for finding in (*general, *(watch.findings or []))]
        good = [finding for finding in findings if finding.state == "ok"]
        self._checklist.update([finding for finding in findings if finding.state != "ok"])
        self._good.update(good)
        self._passed.set_visibility(bool(good))
        self._passed.set_text(tally("ok", len(good)))  # its name for screen readers, below the sign and the text
        for state, drawn in self._tallies.items():
            drawn.update(sum(finding.state == state for finding in findings))
        self._age.set_text(
            "examining ..."
            if watch.examined_at is None or watch.is_examining
            else f"examined {age(now - watch.examined_at)} ago"
        )
        self._help.set_visibility(hub.has_responded and not hub.robots())
        self._update_sections(hub.robots(), of_robots)

    def _update_sections(self, reports: list[RobotReport], findings: list[Finding]) -> None:
        """Draw sections for new robots, update the others, and remove those of robots that are gone."""
        now = self._hub.now()
        for gone in self._sections.keys() - {(report.robot, report.source) for report in reports}:
            self._sections.pop(gone).element.delete()
        for index, report in enumerate(reports):
            section = self._sections.get((report.robot, report.source))
            if section is None:
                with self._column:
                    section = RobotSection(self._watch, report)
                section.element.move(target_index=index)
                self._sections[report.robot, report.source] = section
            section.update(report, of_robot(findings, report.robot), now)
