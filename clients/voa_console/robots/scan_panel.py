"""Panel of a robot's newest scan: the chart, the buttons of its readings, and the repair that they suggest."""

from typing import get_args

from nicegui import ui

from voa_client import RobotReport
from voa_console.robots.chart import Drawing, Window, drawing_of, legend, options
from voa_console.robots.comparing import Comparison, readings_of
from voa_console.robots.previews import Preview
from voa_console.robots.readings import AS_MEASURED, READINGS, Reading
from voa_console.robots.repairs import Repair, repair
from voa_console.robots.snippets import snippet
from voa_console.robots.watching import RobotsWatch

_NO_SCAN = "The service has not decoded a scan of this robot yet."
_NO_SESSION = "Its scans go to no session, so there is no prediction to compare them with."
_NO_PLACE = "It is not known where the lidar was: the scan is drawn around the origin, and not compared."
_NO_MESH = "The scenario has no mesh: the scan is compared as measured only."
_MOVING = "The scan is compared with the object's poses as soon as the robot stands still."
_FITS = "No other reading of the beams fits much better than the scan as measured."
_CHOSEN, _OTHER = "unelevated color=primary", "outline"
_WINDOWS: tuple[Window, ...] = get_args(Window)


class ScanPanel:
    """Panel of a robot's scan.

    Args:
        watch: has the previews.
        robot: name of the robot.
    """

    def __init__(self, watch: RobotsWatch, robot: str) -> None:
        self._watch = watch
        self._robot = robot
        self._reading = AS_MEASURED
        self._window: Window = "Table"
        self._drawn: tuple[object, ...] = ()
        self._repair: Repair | None = None
        self._advice = ui.column().classes("w-full gap-1 rounded p-3").props('role="alert"')
        self._advice.style("border: 2px solid #D55E00")
        self._advice.set_visibility(False)
        with ui.row().classes("gap-2").props('role="group"') as self._row:
            self._row.props["aria-label"] = f"Readings of the scan of {robot}"
            self._buttons = {reading: self._button(reading) for reading in READINGS}
        self._note = ui.label().classes("text-xs")
        with ui.column().classes("w-full gap-2") as self._drawing:
            self._chart = ui.echart({}).classes("w-full").style("aspect-ratio: 1; height: auto").props('role="img"')
            self._legend = ui.row().classes("gap-x-4 gap-y-1 items-center")
            windows = ui.toggle(list(_WINDOWS), value=self._window, on_change=lambda event: self._zoom(event.value))
            windows.props('no-caps padding="xs sm" toggle-color=primary role="group"')
            windows.props('aria-label="Part that the chart shows"')
            self._windows = windows
        self._shown_legend: list[tuple[str, str]] = []

    def update(self, report: RobotReport) -> None:
        """Show the newest scan of the robot, if there is one.

        Args:
            report: on the robot.
        """
        preview = self._watch.previews.get(report.robot)
        self._drawing.set_visibility(preview is not None)
        self._row.set_visibility(preview is not None)
        self._update_advice(preview)
        if preview is None:
            self._note.set_text(_NO_SCAN)
            return
        self._note.set_text(_note(preview))
        self._windows.set_visibility(preview.scenario is not None)
        self._update_buttons(preview)
        self._draw(preview)

    def _button(self, reading: Reading) -> ui.button:
        return (
            ui.button(reading.name, on_click=lambda: self._choose(reading), color=None)
            .props("no-caps dense")
            .classes("px-2")
        )

    def _choose(self, reading: Reading) -> None:
        self._reading = reading
        self._watch.want(self._robot, reading)
        self._redraw()

    def _zoom(self, window: Window) -> None:
        self._window = window
        self._redraw()

    def _redraw(self) -> None:
        preview = self._watch.previews.get(self._robot)
        if preview is not None:
            self._update_buttons(preview)
            self._draw(preview)

    def _draw(self, preview: Preview) -> None:
        predicted = preview.outlines.get(self._reading, ())
        fit = None if preview.comparison is None else preview.comparison.fit(self._reading)
        pose = None if fit is None else fit.pose
        state = (preview.scan.at, self._reading, self._window, predicted, preview.scenario)
        if state == self._drawn:
            return
        self._drawn = state
        drawing = drawing_of(preview.scan.scan, preview.place, preview.scenario, self._reading, predicted, pose)
        self._chart.props["aria-label"] = _description(self._robot, drawing, self._reading)
        self._chart.options.clear()
        self._chart.options.update(options(drawing, self._window))
        self._chart.update()
        self._draw_legend(legend(drawing))

    def _draw_legend(self, entries: list[tuple[str, str]]) -> None:
        if entries == self._shown_legend:
            return
        self._shown_legend = entries
        self._legend.clear()
        with self._legend:
            for name, colour in entries:
                with ui.row().classes("items-center gap-1 no-wrap"):
                    ui.element("div").style(f"width: 0.8rem; height: 0.8rem; border-radius: 2px; background: {colour}")
                    ui.label(name).classes("text-xs")

    def _update_buttons(self, preview: Preview) -> None:
        comparable = () if preview.scenario is None or preview.place is None else readings_of(preview.scenario)
        for reading, button in self._buttons.items():
            chosen = reading == self._reading
            button.set_text(_label(reading, preview.comparison))
            button.props(remove="unelevated outline color").props(_CHOSEN if chosen else _OTHER)
            button.props(f'aria-pressed="{"true" if chosen else "false"}"')
            button.set_visibility(reading in comparable or preview.scenario is None)

    def _update_advice(self, preview: Preview | None) -> None:
        comparison = None if preview is None else preview.comparison
        suspected = None if comparison is None else comparison.suspected
        before, self._repair = self._repair, None
        if preview is not None and suspected is not None:
            self._repair = repair(suspected, preview.scan)
        advice = self._repair
        self._advice.set_visibility(advice is not None)
        if advice is None or suspected is None or comparison is None or advice == before:
            return
        self._advice.clear()
        with self._advice:
            for mistake in comparison.mistakes:
                if mistake.kind in ("scan-mirrored", "scan-turned"):
                    ui.label(f"{mistake.kind}: {mistake.detail}").classes("text-sm font-medium")
            ui.label(f"Press “{suspected.name}” to see it over the prediction.").classes("text-sm")
            ui.label(advice.words).classes("text-sm")
            if advice.line is not None:
                snippet(advice.line, "toml")


def _label(reading: Reading, comparison: Comparison | None) -> str:
    """Write the name of a reading, with its difference from the best pose if that is known."""
    fit = None if comparison is None else comparison.fit(reading)
    if fit is None:
        return reading.name
    return f"{reading.name}: {'no beam' if fit.rmsd_mm is None else f'{_millimetres(fit.rmsd_mm)}'}"


def _millimetres(value: float) -> str:
    """Write a length, with a decimal if it is short."""
    return f"{value:.1f} mm" if value < 10.0 else f"{value:.0f} mm"


def _note(preview: Preview) -> str:
    """Write what the figures on the buttons are, or why there are none."""
    if preview.scenario is None:
        return _NO_SESSION
    if preview.place is None:
        return _NO_PLACE
    if preview.problem is not None:
        return f"The scan could not be compared. {preview.problem}"
    if preview.comparison is None:
        return _MOVING
    figures = "The figures are the root mean square difference from the pose that fits best, over all beams."
    if preview.scenario.object is None:
        return f"{_NO_MESH} {figures}"
    return figures if preview.comparison.suspected is not None else f"{_FITS} {figures}"


def _description(robot: str, drawing: Drawing, reading: Reading) -> str:
    """Describe a chart for people who do not see it."""
    where = "in the workspace" if drawing.scenario is not None else "around the lidar"
    outline = "over a prediction" if drawing.outline else "without a prediction"
    name = reading.name.lower()
    return f"Scan of {robot} from above, {name}: {len(drawing.inside)} returns {where}, {outline}"
